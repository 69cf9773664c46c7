"""A project's settings: `[tool.shaderlab]` in its pyproject.toml.

Every command reads them here. What the command line says goes before them.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from shaderlab.errors import UsageError, suggest
from shaderlab.files import display_path, read_regular
from shaderlab.model.options import Limits

FILE = "pyproject.toml"
TABLE = "shaderlab"
_MOST_BYTES = 4 << 20


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What a project says, each thing None or empty where it says nothing.

    Attributes:
        root: the project's folder: that of the nearest pyproject.toml with a table
            `[tool.shaderlab]`, or else of the nearest repository; None where there is neither.
        shaders: the folders in which shaders are found by name.
        timeout: seconds that one variant may take; `memory`, gigabytes that one worker may have.
        keep: how many runs stay in reports/; 0 for all.
    """

    root: Path | None = None
    shaders: tuple[Path, ...] | None = None
    include: tuple[Path, ...] = ()
    targets: tuple[str, ...] = ()
    driver: str | None = None
    timeout: float | None = None
    memory: float | None = None
    keep: int | None = None

    @property
    def limits(self) -> Limits:
        """Those of one job."""
        return Limits(**dict(_drop_missing(seconds=self.timeout, gigabytes=self.memory)))

    def shader_folders(self, folder: Path) -> tuple[Path, ...]:
        """Where the shaders are that files in `folder` name, in the order of the search.

        First the folder itself and `shaders` in it. Then what the project says; without a word of
        it, each folder up to the project's root, and `shaders` in each. Where nothing marks a
        project, its root is the working folder, and if that is elsewhere, only `shaders` beside the
        folder counts.
        """
        here = Path(os.path.abspath(folder))
        if self.shaders is not None:
            others = list(self.shaders)
        elif self.root is not None and here.is_relative_to(self.root):
            above = [here, *here.parents]
            above = above[1 : above.index(self.root) + 1]
            others = [each for one in above for each in (one, one / "shaders")]
        else:
            others = [here.parent / "shaders"]
        others += self.include
        if not folder.is_absolute():  # messages name files as the command did
            others = [Path(display_path(path)) for path in others]
        found = [folder, folder / "shaders", *others]
        return tuple(path for path in dict.fromkeys(found) if path.is_dir())


def load_settings(folder: str | Path) -> Settings:
    """The settings of the project that a folder belongs to. Raises UsageError: they can't be read,
    or say something that does not exist."""
    try:
        return _settings(os.path.abspath(folder), os.getcwd())
    except FileNotFoundError:  # the working folder is gone
        return Settings()


# Of a project without version control, such as an archive that was unpacked.
MARKS = ("package.json", FILE, "LICENSE", "LICENSE.md", "LICENSE.txt")


@cache
def _settings(folder: str, working: str) -> Settings:
    here = Path(folder)
    for root in (here, *here.parents):
        file = root / FILE
        table = _read_table(file) if file.is_file() else None
        if table is not None:
            return _parse_table(table, file)
        if (root / ".git").exists():
            return Settings(root=root)
    marked = (r for r in (here, *here.parents) if any((r / name).is_file() for name in MARKS))
    # Without a mark, where the command was given; but nobody's whole home folder.
    home = Path(os.path.expanduser("~"))
    known = here.is_relative_to(working) and not home.is_relative_to(working)
    return Settings(root=next(marked, Path(working) if known else None))


def _read_table(file: Path) -> Mapping[str, Any] | None:
    """The table of a pyproject.toml; None if it has none."""
    import tomllib  # few folders have one

    try:
        text = read_regular(file, _MOST_BYTES + 1).decode("utf-8")
        if len(text) > _MOST_BYTES:
            raise ValueError("it has more than 4 MB")
        if TABLE not in text:
            return None
        table = tomllib.loads(text).get("tool", {}).get(TABLE)
    except (OSError, ValueError, AttributeError, RecursionError) as error:
        raise UsageError(f"this is no TOML file: {error}", file=file) from error
    if table is not None and not isinstance(table, dict):
        raise UsageError(f"tool.{TABLE} is no table", file=file, remedy=f"write [tool.{TABLE}]")
    return table


def _parse_table(table: Mapping[str, Any], file: Path) -> Settings:
    found: dict[str, Any] = {}
    for name, value in table.items():
        if name not in _KEYS:
            raise UsageError(
                f"[tool.{TABLE}] has no setting {name!r}", file=file, remedy=suggest(name, _KEYS)
            )
        try:
            found[name] = _KEYS[name](value, file.parent)
        except ValueError as error:
            raise UsageError(f"[tool.{TABLE}] {name}: {error}", file=file) from None
    return Settings(root=file.parent, **found)


def _parse_folders(value: Any, root: Path) -> tuple[Path, ...]:
    folders = tuple(Path(os.path.normpath(root / word)) for word in _parse_words(value))
    for word, folder in zip(value, folders, strict=True):
        if not folder.is_dir():
            raise ValueError(f"there is no folder {word!r} here")
        if not folder.resolve().is_relative_to(root.resolve()):
            raise ValueError(
                f"{word!r} leads out of the project; name it on the command line: --include"
            )
    return folders


def _parse_words(value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(word, str) for word in value):
        raise ValueError(f'write a list of words, such as ["shaders"], not {value!r}')
    return tuple(value)


def _parse_targets(value: Any, root: Path) -> tuple[str, ...]:
    from shaderlab.compiler.glslang import ALL_TARGETS

    words = _parse_words(value)
    if not words:
        raise ValueError(f"name one or more of {', '.join(ALL_TARGETS)}")
    for word in words:
        _require_known("target", word, ALL_TARGETS)
    return words


def _parse_driver(value: Any, root: Path) -> str:
    from shaderlab.drivers import DRIVERS

    _require_known("driver", str(value), DRIVERS)
    return str(value)


def _require_known(what: str, word: str, known: Iterable[str]) -> None:
    if word not in known:
        raise ValueError(f"there is no {what} {word!r}; {suggest(word, known)}")


def _parse_number(value: Any, root: Path) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not value > 0:
        raise ValueError(f"write a number above 0, not {value!r}")
    return float(value)


def _parse_amount(value: Any, root: Path) -> float:
    """As `_parse_number`, or 0 for any amount."""
    return 0.0 if value == 0 and value is not False else _parse_number(value, root)


def _parse_count(value: Any, root: Path) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError(f"write a whole number, 0 for all, not {value!r}")
    return value


_KEYS: Mapping[str, Callable[[Any, Path], Any]] = {
    "shaders": _parse_folders,
    "include": _parse_folders,
    "targets": _parse_targets,
    "driver": _parse_driver,
    "timeout": _parse_number,
    "memory": _parse_amount,
    "keep": _parse_count,
}


def option_defaults(settings: Settings) -> dict[str, dict[str, Any]]:
    """Defaults of the commands' options, by command and by the parameter's name."""
    limits = dict(_drop_missing(seconds=settings.timeout, gigabytes=settings.memory))
    running = {**limits, **dict(_drop_missing(driver=settings.driver))}
    return {
        "run": running,
        "watch": running,
        "mutate": dict(_drop_missing(gigabytes=settings.memory)),
        "compile": dict(
            _drop_missing(compile_targets=settings.targets or None, gigabytes=settings.memory)
        ),
    }


def _drop_missing(**values: Any) -> Iterator[tuple[str, Any]]:
    return ((name, value) for name, value in values.items() if value is not None)
