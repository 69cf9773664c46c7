"""What a formula is called, where it stands, and what is written there."""

from __future__ import annotations

import inspect
import linecache
from collections.abc import Callable
from types import FunctionType
from typing import Any
from weakref import WeakKeyDictionary

from shaderlab.errors import FormulaError
from shaderlab.model.records import SourceText

_SOURCES: WeakKeyDictionary[FunctionType, SourceText] = WeakKeyDictionary()


def name_of(reference: Callable[..., Any]) -> str:
    """What a formula is called; an object that can be called has its type's name."""
    target = inspect.unwrap(reference)
    target = getattr(target, "func", target)
    return str(getattr(target, "__name__", type(target).__name__))


def source_of(reference: Callable[..., Any]) -> SourceText:
    """Where a formula stands, and its text."""
    target = inspect.unwrap(reference)
    while hasattr(target, "func"):
        target = target.func
    if not isinstance(target, FunctionType):
        return _source_of(target, reference)
    if target not in _SOURCES:  # a formula is asked for it once a variant
        _SOURCES[target] = _source_of(target, reference)
    return _SOURCES[target]


def _source_of(target: Any, reference: Callable[..., Any]) -> SourceText:
    try:
        lines, line = _lines_of(target) or inspect.getsourcelines(target)
        file = inspect.getsourcefile(target) or "?"
    except (OSError, TypeError):
        return SourceText(file="?", line=0, language="python", text=repr(reference))
    return SourceText(file=file, line=max(line, 1), language="python", text="".join(lines))


def _lines_of(target: Any) -> tuple[list[str], int] | None:
    """As `inspect.getsourcelines`, which splits a file into words, of a function at the top level
    of its file, whose code says where it ends; None of others."""
    code = getattr(target, "__code__", None)
    if code is None:
        return None
    linecache.checkcache(code.co_filename)
    lines, first = linecache.getlines(code.co_filename), code.co_firstlineno
    ends, inside = [0], [code]
    while inside:
        code = inside.pop()
        ends += (last for _, last, _, _ in code.co_positions() if last)
        inside += filter(inspect.iscode, code.co_consts)
    end = max(ends)
    after = next(filter(str.strip, lines[end:]), "def")
    # What is indented, or a comment, may belong to it, and so may a bracket.
    whole = "".join(lines[first - 1 : end]).startswith("def ") and after[0] not in " \t#)]}"
    return (lines[first - 1 : end], first) if whole else None


def located(reference: Callable[..., Any], error: Exception, remedy: str) -> FormulaError:
    """The foreign error with the line of the formula's own file where it happened."""
    place = source_of(reference)
    line, trace = place.line, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == place.file:
            line = trace.tb_lineno
        trace = trace.tb_next
    return FormulaError(
        f"{name_of(reference)}() fails: {type(error).__name__}: {error}",
        file=place.file,
        line=line,
        remedy=remedy,
    )
