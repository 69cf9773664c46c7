"""Finding, importing and checking case files."""

from __future__ import annotations

import dataclasses
import importlib.util
import re
import sys
import traceback
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from shaderlab import model
from shaderlab.discovery import place, shipped_cases
from shaderlab.errors import CaseError, ShaderlabError, UsageError, nearest
from shaderlab.model import Case

_UNKNOWN_KEYWORD = re.compile(
    r"(\w+)(?:\.__init__)?\(\) got an unexpected keyword argument '(\w+)'"
)


@dataclass(frozen=True)
class Catalogue:
    """Cases in the order of the notes: by chapter, then section, then id."""

    cases: tuple[Case, ...]

    @classmethod
    def shipped(cls) -> Catalogue:
        """The cases that come with the lab."""
        return cls.of(shipped_cases())

    @classmethod
    def of(cls, files: Iterable[Path]) -> Catalogue:
        """The cases in these files.

        Raises:
            CaseError: a file is no case file, or two cases have one id.
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
        return cls(tuple(sorted(cases.values(), key=lambda case: place(case.section, case.id))))

    def find(self, case_id: str) -> Case:
        """The case with this id.

        Raises:
            UsageError: there is none; names the nearest ids.
        """
        for case in self.cases:
            if case.id == case_id:
                return case
        raise UsageError(
            f"there is no case {case_id!r}", remedy=nearest(case_id, [c.id for c in self.cases])
        )

    def __iter__(self) -> Iterator[Case]:
        return iter(self.cases)


def load_case(path: Path) -> Case:
    """Import one case file and check what can be checked without compiling.

    The id is the file's name with "_" as "-", the lesson its docstring.

    Raises:
        CaseError: the file can't be read, fails when imported, defines no `case`, or its data is
            wrong; with the file, the line and, for a misspelt word, the nearest right one.
    """
    if not path.is_file():
        what = "is a folder, not a case file" if path.is_dir() else "there is no such case file"
        raise CaseError(what, file=path)
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
    try:
        list(loaded.scenes())
    except CaseError as error:
        raise CaseError(error.message, file=path, remedy=error.remedy) from error
    return loaded


def _import(path: Path) -> object:
    name = f"shaderlab_case_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise CaseError("a case file is a Python file (.py)", file=path)
    module = importlib.util.module_from_spec(spec)
    # Case files import their neighbours, as scripts do.
    sys.path.insert(0, str(path.parent))
    try:
        spec.loader.exec_module(module)
    except ShaderlabError as error:
        line = error.line or _line_in(path, error)
        raise CaseError(error.message, file=path, line=line, remedy=error.remedy) from error
    except (Exception, SystemExit) as error:
        raise CaseError(
            f"{type(error).__name__}: {error}",
            file=path,
            line=error.lineno if isinstance(error, SyntaxError) else _line_in(path, error),
            remedy=_right_spelling(error),
        ) from error
    finally:
        sys.path.remove(str(path.parent))
    return module


def _line_in(path: Path, error: BaseException) -> int | None:
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    return frames[-1].lineno if frames else None


def _right_spelling(error: BaseException) -> str | None:
    """For a misspelt keyword or import, the names there are."""
    if isinstance(error, ImportError) and (error.name or "").startswith("shaderlab"):
        word = re.search(r"cannot import name '(\w+)'", str(error))
        return nearest(word.group(1), model.__all__) if word else None
    found = _UNKNOWN_KEYWORD.search(str(error))
    if not isinstance(error, TypeError) or found is None:
        return None
    owner = getattr(model, found.group(1), None)
    if owner is None:
        return None
    if dataclasses.is_dataclass(owner):
        names = [f.name for f in dataclasses.fields(owner) if f.init]
    else:
        code = owner.__code__
        names = list(code.co_varnames[: code.co_argcount + code.co_kwonlyargcount])
    return nearest(found.group(2), names)
