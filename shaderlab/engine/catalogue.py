"""Imports case files and checks them."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import re
import sys
import traceback
from collections.abc import Iterable
from dataclasses import replace
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from shaderlab.errors import CaseError, ShaderlabError, nearest
from shaderlab.files import search_folder
from shaderlab.model.case import Case

from .discovery import TREE_FILE, chapter_title, place, tree_of

_PACKAGE = "shaderlab_cases_"
_FOR_CASES = ("shaderlab", "shaderlab.glslmath", "shaderlab.glslmath.sampling", "shaderlab.assets")
"""The modules whose names case files import."""
_MISSING = re.compile(r"missing \d+ required (?:positional |keyword-only )?arguments?: (.+)")
_UNKNOWN_KEYWORD = re.compile(
    r"(\w+)(?:\.__init__)?\(\) got an unexpected keyword argument '(\w+)'"
)

_NAMELESS = re.compile(r"(\w+)(?:\.__init__)?\(\) takes 1 positional argument but \d+")


def load_cases(files: Iterable[Path]) -> dict[str, Case]:
    """The cases in these files by id, ordered by chapter, then section, then id.

    Raises:
        CaseError: a file is no case file, or two cases have the same id.
    """
    cases: dict[str, Case] = {}
    for file in files:
        case = load_case(file)
        if case.id in cases:
            raise CaseError(
                f"the id {case.id!r} is taken by {cases[case.id].file}",
                file=file,
                remedy="rename one of the two files: a case's id is its file's name",
            )
        cases[case.id] = case
    return dict(sorted(cases.items(), key=lambda item: place(item[1].section, item[0])))


def load_case(path: Path) -> Case:
    """Import a case file and check all that needs no compiler.

    The id is the file's name with "_" as "-", the lesson its docstring.

    Raises:
        CaseError: the file can't be read or imported, defines no `case`, or its data is wrong;
            names the file, the line and, for a misspelt word, the nearest correct one.
    """
    if not path.is_file():
        what = "is a folder, not a case file" if path.is_dir() else "is no regular file"
        raise CaseError(what if path.exists() else "there is no such case file", file=path)
    module = _import(path)
    case = getattr(module, "case", None)
    if not isinstance(case, Case):
        raise CaseError(
            "the file defines no case", file=path, remedy="assign one: case = Case(title=…, …)"
        )
    loaded = replace(
        case,
        id=path.stem.replace("_", "-"),
        file=str(path),
        lesson=(module.__doc__ or "").strip(),
    )
    chapter_title(path, loaded.section)
    try:
        list(loaded.scenes())
    except CaseError as error:
        raise CaseError(error.message, file=path, remedy=error.remedy) from error
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
            name = f"{_package(file.parent, tree)}.{file.stem.replace('.', '_')}"
            return _run(spec_from_file_location(name, path))
    except ShaderlabError as error:
        line = error.line or _line_in(path, error)
        raise CaseError(error.message, file=path, line=line, remedy=error.remedy) from error
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # SystemExit too
        raise CaseError(
            f"{type(error).__name__}: {error}".rstrip(": "),
            file=path,
            line=error.lineno if isinstance(error, SyntaxError) else _line_in(path, error),
            remedy=_above_the_tree(error, tree)
            or _named_like_pythons(error, file.parent)
            or _right_spelling(error),
        ) from error
    finally:
        _forget_scripts(sorted(set(sys.modules) - known, reverse=True), file.parent)


def _package(folder: Path, tree: Path) -> str:
    """The package that stands for a folder of a tree; its name is made of the tree's whole path,
    so that folders of equal name are different packages."""
    if folder == tree:
        digest = hashlib.blake2b(os.fsencode(tree), digest_size=6).hexdigest()
        name = f"{_PACKAGE}{digest}"
    else:
        name = f"{_package(folder.parent, tree)}.{folder.name.replace('.', '_')}"
    if name not in sys.modules:
        init = folder / "__init__.py"
        if init.is_file():
            _run(spec_from_file_location(name, init, submodule_search_locations=[str(folder)]))
        else:
            spec = ModuleSpec(name, None, is_package=True)
            spec.submodule_search_locations = [str(folder)]
            sys.modules[name] = module_from_spec(spec)
    return name


def _run(spec: ModuleSpec | None) -> ModuleType:
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
    """Drop modules imported by their bare name from beside a case: another folder may hold one of
    the same name."""
    for name in names:
        spec = getattr(sys.modules.get(name.partition(".")[0]), "__spec__", None)
        places = list(spec.submodule_search_locations or [spec.origin or ""]) if spec else []
        if any(Path(place).parent == folder for place in places):
            del sys.modules[name]


def _above_the_tree(error: BaseException, tree: Path) -> str | None:
    if not isinstance(error, ImportError) or "beyond top-level package" not in str(error):
        return None
    return (
        f"the tree of cases begins at {tree}; to share modules between folders, put an empty "
        f"{TREE_FILE} into the folder that holds them all"
    )


def _named_like_pythons(error: BaseException, folder: Path) -> str | None:
    name = error.name if isinstance(error, ImportError) else None
    if name not in sys.stdlib_module_names or not (folder / f"{name}.py").is_file():
        return None
    return f"{name} is a module of Python's own; the file beside the case is .{name}"


def _line_in(path: Path, error: BaseException) -> int | None:
    file = os.path.abspath(path)
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == file]
    return frames[-1].lineno if frames else None


def _has_default(field: dataclasses.Field[object]) -> bool:
    missing = dataclasses.MISSING
    return field.default is not missing or field.default_factory is not missing


def _right_import(name: str, module: str) -> str:
    """For a name that a module of the lab lacks: which other has it, or the nearest names."""
    for other in _FOR_CASES:
        if name in _public(import_module(other)):
            return f"it is elsewhere: from {other} import {name}"
    return nearest(name, _public(sys.modules[module]))


def _public(module: ModuleType) -> list[str]:
    names: list[str] = getattr(module, "__all__", None) or dir(module)
    return [name for name in names if not name.startswith("_")]


def _right_spelling(error: BaseException) -> str | None:
    """For a misspelt keyword or import, the nearest names."""
    if isinstance(error, ImportError) and (error.name or "").startswith("shaderlab"):
        word = re.search(r"cannot import name '(\w+)'", str(error))
        return _right_import(word.group(1), error.name or "") if word else None
    if missing := _MISSING.search(str(error)):
        return f"give it {missing.group(1)}"
    found = _UNKNOWN_KEYWORD.search(str(error)) or _NAMELESS.search(str(error))
    if not isinstance(error, TypeError) or found is None:
        return None
    *_, (frame, _) = traceback.walk_tb(error.__traceback__)  # the one that calls
    places = (frame.f_locals, frame.f_globals, vars(sys.modules["shaderlab"]))
    known = (each for place in places for each in place.values())
    owner = next((each for each in known if getattr(each, "__name__", "") == found.group(1)), None)
    if owner is None:
        return None
    if dataclasses.is_dataclass(owner):
        given = [f for f in dataclasses.fields(owner) if f.init]
        names = [f.name for f in sorted(given, key=_has_default)]  # stable
    else:
        code = owner.__code__
        names = list(code.co_varnames[: code.co_argcount + code.co_kwonlyargcount])
    if found.re is _NAMELESS:
        return f"write the names, as in {owner.__name__}({names[0]}=…)" if names else None
    return nearest(found.group(2), names)
