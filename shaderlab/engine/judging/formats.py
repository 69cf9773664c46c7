"""What bands and references become in an attachment of some format."""

from __future__ import annotations

import inspect
import linecache
from collections.abc import Callable
from types import FunctionType
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from shaderlab.bands import Allowed, Band, Integer, Rules
from shaderlab.bands.allowed import srgb_encode
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array
from shaderlab.model.records import SourceText

FLOAT_FORMATS = ("r32f", "rg32f", "rgba32f")
_UNORM_FORMATS = ("r8", "rg8", "rgb8", "rgba8")


INTEGER_FORMATS = tuple(f"{c}32{kind}" for c in ("r", "rg", "rgba") for kind in ("i", "ui"))


def as_result(value: Any, format: str, rules: Rules) -> Band | Integer:
    """What a formula gives, as an attachment of this format takes it: GLSL converts integers to
    floats by itself, and not back."""
    if format in INTEGER_FORMATS:
        whole = Integer(0, unsigned=format.endswith("ui"), rules=rules).lift(value)
        if whole is not None:
            return whole
    return Band.exact(0.0, rules).lift(value)


def stored(band: Band | Integer, format: str, components: int) -> Band | Allowed:
    """What may come back from an attachment of this format.

    Raises:
        FormulaError: a formula of floats for integers, or the other way round.
    """
    if format in INTEGER_FORMATS:
        return _stored_integers(band, format)
    assert isinstance(band, Band)
    if format in FLOAT_FORMATS:
        return band
    if format.startswith("depth"):
        return band.quantise(format.removesuffix("_stencil8"))
    if format.endswith("16f"):
        return band.quantise("rgba16f")
    if format in _UNORM_FORMATS:
        return band.quantise("rgba8")
    if format != "srgb8_alpha8":
        raise FormulaError(f"no formula can be judged over a {format} attachment")
    color, alpha = band.quantise("srgb8"), band.quantise("rgba8")
    # Alpha is not encoded (OpenGL 4.5, §17.3.7): the last component keeps its own rule.
    is_alpha = np.arange(components) == 3
    names = ("lo", "hi", "nan", "vacuous", "undecided")
    picked = {n: np.where(is_alpha, getattr(alpha, n), getattr(color, n)) for n in names}
    return Allowed(**picked, unit=1.0)


def _stored_integers(whole: Band | Integer, format: str) -> Allowed:
    unsigned = format.endswith("ui")
    if not isinstance(whole, Integer) or whole.unsigned != unsigned:
        number, vector = ("uint", "uvec2") if unsigned else ("int", "ivec2")
        raise FormulaError(
            f"gives {whole!r}, the attachment holds {format}",
            remedy=f"use glslmath.{number}(…), or {vector}(…) and its like",
        )
    nowhere = np.zeros(whole.shape, np.bool_)
    anything = np.broadcast_to(whole.anything, whole.shape)
    low, high = whole.lo.astype(np.float64), whole.hi.astype(np.float64)
    return Allowed(low, high, nowhere, anything, nowhere, unit=1.0)


def in_format(values: Array, format: str) -> Array:
    """A float64 reference as it would be read back from `format`, unrounded."""
    if format in _UNORM_FORMATS:
        return np.clip(values, 0.0, 1.0) * 255.0
    if format.startswith("depth"):
        return np.clip(values, 0.0, 1.0)
    if format == "srgb8_alpha8":
        linear = np.clip(values, 0.0, 1.0)
        encoded = srgb_encode(linear)
        encoded[..., 3:] = linear[..., 3:]
        return encoded * 255.0
    return values


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
