"""Finds case files without importing them, the trees that they belong to, and the shipped folders;
imports case files and checks them; finds the shaders of cases.

A folder of cases may be part of a larger project, so its files are read, not run, to find the
cases. A case file takes `Case` from shaderlab, itself or by a module of its project, and assigns
`case` at its top level.
"""

from __future__ import annotations

import ast
import functools
import os
import re
import signal
import sys
import sysconfig
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from shaderlab.engine.settings import load_settings
from shaderlab.errors import CaseError, MissingPackageError, ShaderlabError, UsageError, suggest
from shaderlab.files import read_regular, search_folder

if TYPE_CHECKING:
    from shaderlab.compiler.sources import Shaders
    from shaderlab.model.case import Case
    from shaderlab.model.records import Place

TREE_FILE = "cases.toml"
MAX_BYTES = 4 << 20  # of a case file
_SKIPPED_FOLDERS = frozenset({"__pycache__", "node_modules", "site-packages", "build", "dist"})
_SYSTEM = ("/proc", "/dev", "/sys", "/etc")
_OF_TOOLS = frozenset({"__pycache__", ".git", ".hypothesis", ".pytest_cache"})
_LIBRARIES = ("stdlib", "platstdlib", "purelib", "platlib")
_ASSIGNS = re.compile(rb"^case\s*(:[^=\n]*)?=", re.MULTILINE)
_MENTIONS = re.compile(rb"\bcase\b|\bCase\b")
_NO_CASES = (
    ast.Constant, ast.JoinedStr, ast.List, ast.Tuple, ast.Set, ast.Dict, ast.ListComp, ast.SetComp,
    ast.DictComp, ast.GeneratorExp, ast.Lambda,
)  # fmt: skip


def case_files(folder: Path, skipped: Callable[[Path, str], None] | None = None) -> Iterator[Path]:
    """The case files of `files_below`; `skipped` gets others that take `Case`, and why."""
    for path in files_below(folder):
        reason = inspect_file(path)
        if reason == "":
            yield path
        elif reason is not None and skipped is not None:
            skipped(path, reason)


def shipped_cases() -> Iterator[Path]:
    """The case files that come with the lab, sorted. Their text is matched, not parsed: parsing
    would take longer than loading them."""
    for path in files_below(data_folder("cases")):
        source = _read(path) if path.suffix == ".py" and not path.name.startswith("_") else b""
        if b"shaderlab" in source and _ASSIGNS.search(source):
            yield path


def is_case_file(path: Path) -> bool:
    """Whether `path` is a case file; never raises."""
    return inspect_file(path) == ""


def inspect_file(path: Path) -> str | None:
    """Tell what a file is, without importing it; never raises: "" for a case file, also for one
    with a mistake, which loading it reports; the reason why a file is none that takes `Case` from
    shaderlab; None for all others."""
    if path.suffix != ".py" or path.name.startswith("."):
        return None
    try:
        source = read_regular(path, MAX_BYTES + 1)
    except OSError:  # a link to nothing, a FIFO, a file of someone else
        return "" if os.path.lexists(path) and not path.is_dir() else None
    large = len(source) > MAX_BYTES
    if b"\0" in source or (large and b"shaderlab" in source):  # UTF-16 or damaged; or too large
        return ""
    if large or not _MENTIONS.search(source):
        return None
    try:
        body = list(_statements(ast.parse(source).body))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return "" if b"shaderlab" in source else None
    values = [value for statement in body for value in _find_assigned_values(statement)]
    imports_lab, takes = _imports_lab(body)
    literal = all(isinstance(value, _NO_CASES) for value in values)
    if not takes:
        may_be_case = values and not literal
        if not may_be_case or not (imports_lab or _neighbour_takes_case(path)):
            return None
    if path.name.startswith("_"):
        return "its name begins with _"
    if not values:
        return "it assigns no `case` at its top level: one case a file, case = Case(…)"
    return ""


def find_imported_files(path: Path) -> set[Path]:
    """The files of a project's own modules that a file imports at module level, and of those that
    these import; a file that can't be parsed imports none."""
    return set(_find_imported_modules(path))


def _find_imported_modules(path: Path) -> Mapping[Path, Sequence[ast.stmt]]:
    """As `find_imported_files`, with the statements of each."""
    found: dict[Path, Sequence[ast.stmt]] = {}
    waiting = [(Path(os.path.abspath(path)), _parse(path))]
    while waiting:
        importing, body = waiting.pop()
        for imported in _imports(body):
            other = _neighbour(importing, *imported)
            if other is not None and other not in found:
                found[other] = _parse(other)
                waiting.append((other, found[other]))
    return found


def _neighbour_takes_case(path: Path) -> bool:
    """Whether a file takes `Case` by a module of its own project."""
    return any(_imports_lab(body)[1] for body in _find_imported_modules(path).values())


def _read(path: Path) -> bytes:
    try:
        return read_regular(path, MAX_BYTES)
    except OSError:
        return b""


def _parse(path: Path) -> Sequence[ast.stmt]:
    """The statements of a file that run when it is imported; none if it can't be parsed."""
    try:
        return list(_statements(ast.parse(_read(path)).body))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return []


def _statements(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements that run when a module is imported, not those of functions and classes, nor
    what is for type checkers only."""
    for statement in body:
        yield statement
        inside = isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        typing = isinstance(statement, ast.If) and "TYPE_CHECKING" in ast.unparse(statement.test)
        if not inside and not typing:
            for name in ("body", "orelse", "finalbody"):
                yield from _statements(getattr(statement, name, []))
            for handler in getattr(statement, "handlers", []):
                yield from _statements(handler.body)


def _find_assigned_values(statement: ast.stmt) -> Iterator[ast.expr | None]:
    """What a statement gives to the name `case`; None if that is not written there."""
    match statement:
        case ast.Assign(targets=targets, value=value):
            for target in targets:
                if isinstance(target, ast.Name) and target.id == "case":
                    yield value
                elif any(isinstance(n, ast.Name) and n.id == "case" for n in ast.walk(target)):
                    yield None
        case ast.AnnAssign(target=ast.Name(id="case"), value=value) if value is not None:
            yield value
        case ast.ClassDef(name="case"):
            yield ast.Constant(statement.name)
        case ast.ImportFrom(names=names):
            yield from (None for alias in names if (alias.asname or alias.name) == "case")


def _imports_lab(body: Sequence[ast.stmt]) -> tuple[bool, bool]:
    """Whether a module imports from shaderlab, and whether it takes `Case` from there."""
    absolute = [(module, name) for level, module, name in _imports(body) if level == 0]
    names = [name for module, name in absolute if module.split(".")[0] == "shaderlab"]
    if not names or {"Case", "*"} & set(names):
        return bool(names), bool(names)
    nodes = (node for statement in body for node in ast.walk(statement))
    return True, any(isinstance(n, ast.Attribute) and n.attr == "Case" for n in nodes)


def _imports(body: Sequence[ast.stmt]) -> Iterator[tuple[int, str, str]]:
    """All imports at module level: how many dots, the module, and the name taken from it."""
    for statement in body:
        match statement:
            case ast.Import(names=names):
                yield from ((0, alias.name, "") for alias in names)
            case ast.ImportFrom(module=name, names=names, level=level):
                yield from ((level, name or "", alias.name) for alias in names)


def _neighbour(path: Path, level: int, module: str, name: str) -> Path | None:
    """The file of a module that a file imports from its own project."""
    folder = Path(os.path.abspath(path)).parent
    if level:
        folder = folder.joinpath(*[os.pardir] * (level - 1))
    parts = [part for part in module.split(".") if part]
    for candidate in ([*parts, name] if name else [], parts):
        if candidate:
            file = folder.joinpath(*candidate[:-1], f"{candidate[-1]}.py")
            if file.is_file():
                return file
    package = folder.joinpath(*parts, "__init__.py")
    return package if parts and package.is_file() else None


def data_folder(kind: str) -> Path:
    """The folder of the shipped "shaders" or "cases", in the installed package or the checkout.
    Raises UsageError: there is none: the installation is incomplete."""
    package = Path(__file__).resolve().parents[1]
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
    cases.toml of the case's tree gives it; else "". Raises CaseError: the cases.toml is wrong."""
    number = section.split(".")[0].strip()
    chapters: Mapping[str, str] = _course(tree_of(Path(file)) / TREE_FILE).get("chapters", {})
    return chapters.get(number, "")


def place_of(file: str | Path, id: str, section: str) -> Place:
    """Where a lesson stands in its course, as the cases.toml of its tree says. Raises CaseError:
    the cases.toml is wrong."""
    from shaderlab.model.records import Place  # late, as for all commands that read cases

    tree = tree_of(Path(file)) / TREE_FILE
    course = _course(tree)
    try:
        title, title_zh = course.get("sections", {}).get(section, ("", ""))
        place = Place(section_title=title, section_title_zh=title_zh, text=course.get("text", ""))
        return replace(place, **_path(tree).get(id, {}))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise CaseError(f"[sections] or [[path]] is wrong: {error}", file=tree) from error


@functools.cache
def _path(file: Path) -> Mapping[str, Mapping[str, Any]]:
    """What [[path]] says of each lesson, and of the stage of the path that it is in."""
    found: dict[str, Mapping[str, Any]] = {}
    for number, stage in enumerate(_course(file).get("path", ()), 1):
        titles = {f"stage_{name}": text for name, text in stage.items() if name != "lessons"}
        for id, lesson in stage["lessons"].items():
            known = {**lesson, "assumes": tuple(lesson.get("assumes", ()))}
            found[id] = {"order": len(found) + 1, "stage": number, **titles, **known}
    return found


@functools.cache
def _course(file: Path) -> Mapping[str, Any]:
    import tomllib  # few trees of cases have chapters

    try:
        found = tomllib.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    except (OSError, ValueError, RecursionError) as error:
        raise CaseError(f"this is no TOML file: {error}", file=file) from error
    chapters = found.get("chapters", {})
    wrong = set(found) - {"text", "chapters", "sections", "path"} or not isinstance(chapters, dict)
    if wrong or not all(n.isdigit() and isinstance(title, str) for n, title in chapters.items()):
        raise CaseError('write [chapters] with lines such as 5 = "Lamps"', file=file)
    return found


def files_below(folder: Path) -> list[Path]:
    """All files below `folder`, sorted, except in hidden folders and build products. A folder that
    links lead to is looked through once, and as itself if it is below, too; those above are not.
    Raises UsageError: a folder can't be read."""
    files: list[Path] = []
    seen: set[tuple[int, int]] = set()
    top = Path(os.path.realpath(folder))
    folders, links = [folder], list[Path]()
    while folders or links:
        here = (folders or links).pop(0)
        try:
            there, entries = here.stat(), sorted(here.iterdir())
        except OSError as error:
            raise UsageError(f"can't read this folder: {error.strerror}", file=here) from error
        place = there.st_dev, there.st_ino
        for entry in entries if place not in seen else ():
            if not os.path.isdir(entry):  # which raises nothing where Path.is_dir may
                files.append(entry)
            elif entry.name.startswith(".") or entry.name in _SKIPPED_FOLDERS:
                continue
            elif not entry.is_symlink():
                folders.append(entry)
            elif not top.is_relative_to(os.path.realpath(entry)):
                links.append(entry)
        seen.add(place)
    return sorted(files)


def sort_key(section: str, case_id: str) -> tuple[list[int], str]:
    """The key that sorts cases: section by section, then id; those without a section come last."""
    numbers = [int(part) if part.isdigit() else 0 for part in section.split(".")]
    return (numbers if section else [999], case_id)


def is_project_file(path: Path) -> bool:
    """Whether a file belongs to a project: not to Python, to a package, to the system, to a tool
    that keeps files of its own there, or to the compile cache."""
    return _OF_TOOLS.isdisjoint(path.parts) and not any(map(path.is_relative_to, _foreign()))


@functools.cache
def _foreign() -> tuple[str | Path, ...]:
    from shaderlab.compiler.compile_cache import cache_folder  # few commands ask

    package = Path(__file__).resolve().parents[1]
    libraries = [sysconfig.get_path(name) for name in _LIBRARIES]
    return (package, *libraries, *_SYSTEM, *filter(None, [cache_folder()]))


_PACKAGE = "shaderlab_cases_"
_FOR_CASES = ("shaderlab", "shaderlab.glslmath", "shaderlab.glslmath.sampling", "shaderlab.assets")
"""The modules whose names case files import."""


def load_case(path: Path) -> Case:
    """Import a case file and check all that needs no compiler.

    The id is the file's name with "_" as "-", the lesson its docstring. Raises CaseError: the file
    can't be read or imported, defines no `case`, or its data is wrong; names the file, the line
    and, for a misspelt word, the nearest correct one."""
    from shaderlab.model.case import Case  # late, as below: commands import this module

    if not path.is_file():
        what = "is a folder, not a case file" if path.is_dir() else "is no regular file"
        what = what if path.exists() else "there is no such case file"
        remedy = "name a case file that can be read, or remove this one"
        raise CaseError(what, file=path, remedy=remedy)
    if path.stem == "__init__":
        what = "this file makes its folder a package: it is no case"
        raise CaseError(what, file=path, remedy="rename it")
    if path.stat().st_size > MAX_BYTES:
        what = f"is larger than {MAX_BYTES >> 20} MiB, which no case file is"
        raise CaseError(what, file=path, remedy="move large data to a file beside the case")
    module = _import(path)
    case = getattr(module, "case", None)
    # isinstance() alone believes what an object says of its class.
    if not isinstance(case, Case) or not issubclass(type(case), Case):
        what = f"its `case` is of type {type(case).__name__}, not a Case"
        raise CaseError(
            "the file defines no case" if case is None else what,
            file=path,
            remedy="assign one, case = Case(title=…, …); tests of functions are run by pytest",
        )
    lesson = (module.__doc__ or "").strip()
    try:
        loaded = replace(case, id=path.stem.replace("_", "-"), file=str(path), lesson=lesson)
        chapter_title(path, loaded.section)
        place_of(path, loaded.id, loaded.section)
        if not list(loaded.scenes()):
            raise CaseError("the case has no variant to run", remedy="see its class")
    except ShaderlabError as error:
        file = error.file or path
        raise CaseError(error.message, file=file, line=error.line, remedy=error.remedy) from error
    except Exception as error:
        raise CaseError(_text(error), file=path, remedy="see the class of `case`") from error
    return loaded


def _import(path: Path) -> ModuleType:
    """Run a case file as a module of its tree's package (`tree_of`)."""
    if path.suffix != ".py":
        raise CaseError("a case file is a Python file (.py)", file=path)
    file = Path(os.path.abspath(path))
    tree = tree_of(file)
    known = set(sys.modules)
    try:
        with search_folder(str(file.parent)):  # for `import helper` of a module beside the file
            name = f"{_ensure_package(file.parent, tree)}.{file.stem.replace('.', '_')}"
            return _execute(spec_from_file_location(name, path))
    except ShaderlabError as error:
        line = error.line or _line_in(path, error)
        kind = MissingPackageError if isinstance(error, MissingPackageError) else CaseError
        raise kind(error.message, file=path, line=line, remedy=error.remedy) from error
    except BaseException as error:  # SystemExit too; where interrupts are ignored, a file's own
        ignored = signal.getsignal(signal.SIGINT) == signal.SIG_IGN
        if isinstance(error, KeyboardInterrupt) and not ignored:
            raise
        raise CaseError(
            _text(error),
            file=path,
            line=error.lineno if isinstance(error, SyntaxError) else _line_in(path, error),
            remedy=_import_hint(error, file, tree),
        ) from error
    finally:
        _forget_scripts(sorted(set(sys.modules) - known, reverse=True), file.parent)


def _ensure_package(folder: Path, tree: Path) -> str:
    """The package that stands for a folder of a tree; its name is made of the tree's whole path,
    so that folders of equal name are different packages."""
    if folder == tree:
        import hashlib  # loads OpenSSL, which takes as long as compiling a file

        digest = hashlib.blake2b(os.fsencode(tree), digest_size=6).hexdigest()
        name = f"{_PACKAGE}{digest}"
    else:
        name = f"{_ensure_package(folder.parent, tree)}.{folder.name.replace('.', '_')}"
    if name not in sys.modules:
        init = folder / "__init__.py"
        if init.is_file():
            _execute(spec_from_file_location(name, init, submodule_search_locations=[str(folder)]))
        else:
            spec = ModuleSpec(name, None, is_package=True)
            spec.submodule_search_locations = [str(folder)]
            sys.modules[name] = module_from_spec(spec)
    return name


def _execute(spec: ModuleSpec | None) -> ModuleType:
    """Execute a module anew, also if it was imported before."""
    assert spec is not None and spec.loader is not None  # the name ends in .py
    module = module_from_spec(spec)
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[spec.name]
        raise
    return module


def _forget_scripts(names: Iterable[str], folder: Path) -> None:
    """Drop modules imported by bare name from beside a case: the next folder may have its own."""
    for name in names:
        spec = getattr(sys.modules.get(name.partition(".")[0]), "__spec__", None)
        places = list(spec.submodule_search_locations or [spec.origin or ""]) if spec else []
        if any(Path(place).parent == folder for place in places):
            del sys.modules[name]


def _line_in(path: Path, error: BaseException) -> int | None:
    file = os.path.abspath(path)
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == file]
    return frames[-1].lineno if frames else None


def _text(error: BaseException) -> str:
    """An exception's name and message, also of one whose str() raises."""
    lines = traceback.format_exception_only(error)  # a syntax error begins with its source
    return next(line for line in lines if not line.startswith(" ")).strip()


def _import_hint(error: BaseException, file: Path, tree: Path) -> str | None:
    """What to do about a file that can't be imported."""
    if isinstance(error, SyntaxError):
        lines = error.lineno or 0  # 0 of an unknown encoding, and of a file that is no text
        return "correct this line" if lines else "save the file as text in UTF-8"
    if not isinstance(error, Exception):
        return "a case file is imported: it must come to its end"
    if not isinstance(error, ImportError):
        return "to see the traceback: shaderlab --debug run …"
    name = error.name or ""
    if "beyond top-level package" in str(error):
        return (
            f"the tree of cases begins at {tree}; to share modules between folders, put an empty "
            f"{TREE_FILE} into the folder that holds them all"
        )
    if name in sys.stdlib_module_names and (file.parent / f"{name}.py").is_file():
        return f"{name} is a module of Python's own; the file beside the case is .{name}"
    word = re.search(r"cannot import name '(\w+)'", str(error))
    if word is None or not name.startswith("shaderlab"):
        return None
    for other in _FOR_CASES:
        if word.group(1) in _public_names(import_module(other)):
            return f"it is elsewhere: from {other} import {word.group(1)}"
    return suggest(word.group(1), _public_names(sys.modules[name]))


def _public_names(module: ModuleType) -> list[str]:
    names: list[str] = getattr(module, "__all__", None) or dir(module)
    return [name for name in names if not name.startswith("_")]


def shaders_of(
    folder: Path,
    overrides: Mapping[str, str | Path],
    include: Sequence[Path] = (),
    renames: Mapping[str, str] | None = None,
) -> Shaders:
    """The shaders of the cases in `folder`: those of their project, and the shipped ones.

    Args:
        folder: where the case file is; a shipped case sees the shipped shaders alone.
        overrides: texts or files to take in a shader's place, by its name.
        include: further folders, which come after the project's own.
        renames: names in the files of `overrides`, and what they are called instead.

    Raises UsageError: the project's settings are wrong."""
    from shaderlab.compiler.sources import Shaders

    shipped = data_folder("shaders")
    inside = folder.resolve().is_relative_to(data_folder("cases").resolve())
    own = () if inside else (*load_settings(folder).shader_folders(folder), *include)
    return Shaders([*own, shipped], overrides=dict(overrides), renames=renames)
