"""Imports case files and checks them; finds the shaders of cases."""

from __future__ import annotations

import hashlib
import os
import re
import sys
import traceback
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from shaderlab.compiler.sources import Shaders
from shaderlab.engine.settings import load_settings
from shaderlab.errors import CaseError, ShaderlabError, suggest
from shaderlab.files import search_folder
from shaderlab.model.case import Case

from .discovery import TREE_FILE, chapter_title, data_folder, sort_key, tree_of

_PACKAGE = "shaderlab_cases_"
_FOR_CASES = ("shaderlab", "shaderlab.glslmath", "shaderlab.glslmath.sampling", "shaderlab.assets")
"""The modules whose names case files import."""
_MOVED = {
    "shaderlab.sampling": "shaderlab.glslmath.sampling",
    "shaderlab.expectations": "shaderlab.engine.expectations",
    "OfOutput": "OutputExpectation",
    "OfDraw": "DrawExpectation",
}
"""Modules and names that earlier versions had, and what they are called now."""


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
    return dict(sorted(cases.items(), key=lambda item: sort_key(item[1].section, item[0])))


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
            name = f"{_ensure_package(file.parent, tree)}.{file.stem.replace('.', '_')}"
            return _execute(spec_from_file_location(name, path))
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
            remedy=_import_hint(error, file, tree) if isinstance(error, ImportError) else None,
        ) from error
    finally:
        _forget_scripts(sorted(set(sys.modules) - known, reverse=True), file.parent)


def _ensure_package(folder: Path, tree: Path) -> str:
    """The package that stands for a folder of a tree; its name is made of the tree's whole path,
    so that folders of equal name are different packages."""
    if folder == tree:
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
    """Drop modules imported by their bare name from beside a case: another folder may hold one of
    the same name."""
    for name in names:
        spec = getattr(sys.modules.get(name.partition(".")[0]), "__spec__", None)
        places = list(spec.submodule_search_locations or [spec.origin or ""]) if spec else []
        if any(Path(place).parent == folder for place in places):
            del sys.modules[name]


def _line_in(path: Path, error: BaseException) -> int | None:
    file = os.path.abspath(path)
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == file]
    return frames[-1].lineno if frames else None


def _import_hint(error: ImportError, file: Path, tree: Path) -> str | None:
    """What to do about an import that fails."""
    name = error.name or ""
    if "beyond top-level package" in str(error):
        return (
            f"the tree of cases begins at {tree}; to share modules between folders, put an empty "
            f"{TREE_FILE} into the folder that holds them all"
        )
    if name in sys.stdlib_module_names and (file.parent / f"{name}.py").is_file():
        return f"{name} is a module of Python's own; the file beside the case is .{name}"
    word = re.search(r"cannot import name '(\w+)'", str(error))
    for old, new in _MOVED.items():
        if old == (word.group(1) if word else name) or name.startswith(f"{old}."):
            return f"{old} is called {new} now"
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

    Raises:
        UsageError: the project's settings are wrong.
    """
    shipped = data_folder("shaders")
    inside = folder.resolve().is_relative_to(data_folder("cases").resolve())
    own = () if inside else (*load_settings(folder).shader_folders(folder), *include)
    return Shaders([*own, shipped], overrides=dict(overrides), renames=renames)
