"""Where things lie: the shipped folders, the tree that a case belongs to, and what is below a
folder."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from shaderlab.errors import CaseError, UsageError

TREE_FILE = "cases.toml"
_SKIPPED_FOLDERS = frozenset({"__pycache__", "node_modules", "site-packages", "build", "dist"})


def data_folder(kind: str) -> Path:
    """The folder of the shipped "shaders" or "cases", in the installed package or the checkout.

    Raises:
        UsageError: there is none: the installation is incomplete.
    """
    package = Path(__file__).resolve().parents[2]
    for candidate in (package / "_data" / kind, package.parent / kind):
        if candidate.is_dir():
            return candidate
    raise UsageError(
        f"this installation has no {kind} folder", remedy="install shaderlab again, or run `make`"
    )


def tree_of(file: Path) -> Path:
    """The root of the tree that a case file belongs to: the nearest folder above it that holds a
    cases.toml, or else the file's own folder.

    The tree is one package: its modules import each other by relative imports.
    """
    own = folder = os.path.dirname(os.path.abspath(file))
    while not os.path.isfile(os.path.join(folder, TREE_FILE)):
        below, folder = folder, os.path.dirname(folder)
        if folder == below:
            return Path(own)
    return Path(folder)


def chapter_title(file: str | Path, section: str) -> str:
    """The title of the chapter that a section such as "5.5.2" lies in, as [chapters] in the
    cases.toml of the case's tree gives it; "" where there is none.

    Raises:
        CaseError: the cases.toml is wrong.
    """
    number = section.split(".")[0].strip()
    return _chapters(tree_of(Path(file)) / TREE_FILE).get(number, "") if number else ""


@cache
def _chapters(file: Path) -> Mapping[str, str]:
    import tomllib  # few trees of cases have chapters

    try:
        found = tomllib.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    except (OSError, ValueError) as error:
        raise CaseError(f"this is no TOML file: {error}", file=file) from error
    chapters: dict[str, str] = found.pop("chapters", {})
    if found or not isinstance(chapters, dict):
        wrong = next(iter(found), "chapters")
        raise CaseError(f"there is no setting {wrong!r}", file=file, remedy="write [chapters]")
    for number, title in chapters.items():
        if not (number.isdigit() and isinstance(title, str)):
            raise CaseError(
                f"{number} = {title!r} is no chapter", file=file, remedy='write 5 = "Lamps"'
            )
    return chapters


def files_below(folder: Path) -> Iterator[Path]:
    """All files below `folder`, sorted, except in hidden folders and build products.

    Raises:
        UsageError: `folder` is not a folder that can be read.
    """
    try:
        entries = sorted(folder.iterdir())
    except OSError as error:
        raise UsageError(f"can't read this folder: {error.strerror}", file=folder) from error
    for entry in entries:
        if not entry.is_dir():
            yield entry
        elif not entry.name.startswith(".") and entry.name not in _SKIPPED_FOLDERS:
            yield from files_below(entry)


def place(section: str, case_id: str) -> tuple[list[int], str]:
    """The sort key of cases: section by section, then id; those without a section come last."""
    numbers = [int(part) if part.isdigit() else 0 for part in section.split(".")]
    return (numbers if section else [999], case_id)
