"""Tells case files from other Python files.

A folder of cases may be part of a larger project, so files are read, not run. A case file
takes `Case` from shaderlab, itself or by a module of its project, and assigns `case` at its top
level.
"""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from .trees import data_folder, files_below

_ASSIGNS = re.compile(rb"^case\s*(:[^=\n]*)?=", re.MULTILINE)
_MENTIONS = re.compile(rb"\bcase\b|\bCase\b")
_DEPTH = 4  # how many of a project's own modules may lie between a file and shaderlab
_NO_CASES = (
    ast.Constant, ast.JoinedStr, ast.List, ast.Tuple, ast.Set, ast.Dict, ast.ListComp, ast.SetComp,
    ast.DictComp, ast.GeneratorExp, ast.Lambda,
)  # fmt: skip


@dataclass(frozen=True)
class _Module:
    """A file's statements at module level, and the folder that it is in."""

    path: Path
    body: tuple[ast.stmt, ...]


def is_case_file(path: Path) -> bool:
    """Whether `path` is a case file; never raises."""
    return examined(path) == ""


def examined(path: Path) -> str | None:
    """ "" for a case file, the reason why a file is none that takes `Case` from shaderlab, None for
    all others; never raises."""
    source = _read(path) if path.suffix == ".py" else b""
    if not _MENTIONS.search(source):
        return None
    try:
        module = _Module(path, tuple(_statements(ast.parse(source).body)))
    except (SyntaxError, ValueError, RecursionError) as error:
        if b"shaderlab" not in source:
            return None
        if _ASSIGNS.search(source):
            return ""  # loading it reports the mistake
        line = f" in line {error.lineno}" if isinstance(error, SyntaxError) else ""
        return f"it has a syntax error{line}"
    values = [value for statement in module.body for value in _values(statement)]
    lab, takes = _imports_lab(module)
    literal = all(isinstance(value, _NO_CASES) for value in values)
    if not (takes or (values and not literal and (lab or _neighbours_take(module, _DEPTH)))):
        return None
    if path.name.startswith("_"):
        return "its name begins with _"
    if not values:
        return "it assigns no `case` at its top level: one case a file, case = Case(…)"
    return "its `case` is no Case(…)" if literal else ""


def case_files(folder: Path, skipped: Callable[[Path, str], None] | None = None) -> Iterator[Path]:
    """The case files of `files_below`; `skipped` gets each that takes `Case` and is none, with the
    reason."""
    for path in files_below(folder):
        reason = examined(path)
        if reason == "":
            yield path
        elif reason is not None and skipped is not None:
            skipped(path, reason)


def imported_files(path: Path) -> set[Path]:
    """The files of a project's own modules that a file imports at module level, and of those that
    these import; a file that can't be parsed imports none."""
    found: set[Path] = set()
    waiting = [Path(os.path.abspath(path))]
    while waiting:
        module = _parsed(waiting.pop())
        for imported in _imports(module) if module is not None else ():
            other = _neighbour(module.path, *imported) if module is not None else None
            if other is not None and other not in found:
                found.add(other)
                waiting.append(other)
    return found


def shipped_cases() -> Iterator[Path]:
    """The case files that come with the lab, sorted. Their text is matched, not parsed: parsing
    would take longer than loading them."""
    for path in files_below(data_folder("cases")):
        if path.suffix == ".py" and not path.name.startswith("_"):
            source = _read(path)
            if b"shaderlab" in source and _ASSIGNS.search(source):
                yield path


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes() if path.is_file() else b""
    except OSError:
        return b""


def _statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
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


def _values(statement: ast.stmt) -> Iterator[ast.expr | None]:
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
        case ast.ImportFrom(names=names):
            yield from (None for alias in names if (alias.asname or alias.name) == "case")


def _imports_lab(module: _Module) -> tuple[bool, bool]:
    """Whether a module imports from shaderlab, and whether it takes `Case` from there."""
    taken = [
        taken
        for level, name, taken in _imports(module)
        if level == 0 and name.split(".")[0] == "shaderlab"
    ]
    if not taken or {"Case", "*"} & set(taken):
        return bool(taken), bool(taken)
    nodes = (node for statement in module.body for node in ast.walk(statement))
    return True, any(isinstance(n, ast.Attribute) and n.attr == "Case" for n in nodes)


def _neighbours_take(module: _Module, depth: int) -> bool:
    """Whether a module of the same project takes `Case` that this one imports, directly or by way
    of up to `depth` others."""
    for imported in _imports(module):
        path = _neighbour(module.path, *imported)
        found = None if path is None else _parsed(path)
        if found is not None and (
            _imports_lab(found)[1] or (depth > 1 and _neighbours_take(found, depth - 1))
        ):
            return True
    return False


def _imports(module: _Module) -> Iterator[tuple[int, str, str]]:
    """All imports at module level: how many dots, the module, and what is taken from it."""
    for statement in module.body:
        match statement:
            case ast.Import(names=names):
                yield from ((0, alias.name, "") for alias in names)
            case ast.ImportFrom(module=name, names=names, level=level):
                yield from ((level, name or "", alias.name) for alias in names)


def _parsed(path: Path) -> _Module | None:
    try:
        return _Module(path, tuple(_statements(ast.parse(_read(path)).body)))
    except (SyntaxError, ValueError, RecursionError):
        return None


def _neighbour(path: Path, level: int, name: str, taken: str) -> Path | None:
    """The file of a module that a file imports from its own project."""
    folder = Path(os.path.abspath(path)).parent
    if level:
        folder = folder.joinpath(*[os.pardir] * (level - 1))
    parts = [part for part in name.split(".") if part]
    for candidate in ([*parts, taken] if taken else [], parts):
        if candidate:
            file = folder.joinpath(*candidate[:-1], f"{candidate[-1]}.py")
            if file.is_file():
                return file
    package = folder.joinpath(*parts, "__init__.py")
    return package if parts and package.is_file() else None
