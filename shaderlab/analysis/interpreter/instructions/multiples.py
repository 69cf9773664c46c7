"""Values known to be multiples of a power of two: their sums and products are exact, in any order.

`floor` and an integer give whole numbers; `floor(p.x) + floor(p.y) + 0.5` is a multiple of ½. A sum
of such values is rounded nowhere as long as the sizes of its terms stay below 2²⁴ units, and `mod`
and `fract` of it are exact too. Bands alone don't know that, and allow a rounding of each sum.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab import glslmath
from shaderlab.bands import Band
from shaderlab.bands.exact import monotone, negative
from shaderlab.bands.hulls import product_bounds
from shaderlab.bands.rounding import RELATIVE_STEP
from shaderlab.bands.terms import Terms

from ..memory import World
from ..program import Instruction
from .handler import Handler

if TYPE_CHECKING:
    from ..running import Run

_UNITS = 2.0**24  # as many of them as float32 counts exactly
_CONSTANTS = 16  # values at most of what is looked at: a constant's components
WHOLE = frozenset({"floor", "ceil", "trunc", "round", "roundEven", "sign"})
"""Functions whose results are whole numbers."""


def unit_of(run: Run, value: Any) -> float:
    """A power of two that all of a band's values are multiples of, 0 if none is known."""
    if not isinstance(value, Band):
        return 0.0
    known = run.units.get(id(value))
    if known is not None:
        return known[1]
    if value.lo is not value.hi or value.terms is not None or value.lo.size > _CONSTANTS:
        return 0.0
    unit = _unit(value.lo)
    run.note_unit(value, unit)
    return unit


def _unit(values: Any) -> float:
    """The largest power of two that divides all values; 1 if they are 0."""
    if not np.isfinite(values).all():
        return 0.0
    ratios = (float(v).as_integer_ratio() for v in values.flat if v)
    return min((float(n & -n) / d for n, d in ratios), default=1.0)


def exactly(function: str) -> Handler:
    """A handler of an operation: exact where it can't be rounded, else as the arithmetic has it."""

    def handler(run: Run, at: Instruction, world: World) -> Any:
        if run.arithmetic.rules is None:
            return run.repeated(at, function)
        return computed(run, function, run.values(at.operands))

    return handler


def computed(run: Run, function: str, values: list[Any]) -> Any:
    """A function of values, exact where all of them have a unit and it can't be rounded."""
    found = run.arithmetic.call(function, *values)
    if run.arithmetic.rules is None:
        return found
    exact = _EXACT.get(function)
    if exact is None:
        if function in WHOLE:
            run.note_unit(found, 1.0)
        return found
    units: list[float] = []
    for value in values:
        units.append(unit_of(run, value))
        if not units[-1]:  # as of most
            return found
    known = exact(*values, *units)
    if known is not None:
        if found.lo is not found.hi:
            found = known[0]
        run.note_unit(found, known[1])
    return found


Found = tuple[Band, float] | None
"""A result and its unit, None where it may be rounded."""


def _add(a: Band, b: Band, of_a: float, of_b: float) -> Found:
    return _made(a, b, a.lo + b.lo, a.hi + b.hi, a.mag + b.mag, a.count + b.count, min(of_a, of_b))


def _subtract(a: Band, b: Band, of_a: float, of_b: float) -> Found:
    return _add(a, negative(b), of_a, of_b)


def _multiply(a: Band, b: Band, of_a: float, of_b: float) -> Found:
    bounds = product_bounds(a.lo, a.hi, b.lo, b.hi)
    return _made(a, b, *bounds, a.mag * b.mag, a.count * b.count, of_a * of_b)


def _made(a: Band, b: Band, lo: Any, hi: Any, mag: Any, count: int, unit: float) -> Found:
    """The result of two bands, if none of its terms together are too large to be exact. What is no
    multiple may be added between them later, so each sum's rounding stays pending."""
    if not np.max(mag) < _UNITS * unit:
        return None
    terms = None
    if a.rules.rearrange:
        terms = Terms(mag, (count - 1) * RELATIVE_STEP * mag if count > 1 else None, count)
    return a.kept(lo, hi, b, terms=terms), unit


def _negate(a: Band, unit: float) -> Found:
    return negative(a), unit


def _mod(x: Band, y: Band, of_x: float, of_y: float) -> Found:
    """x - y·⌊x/y⌋, whose terms are those of x and one product."""
    turns = glslmath.floor(x.opaque() / y)
    product = _multiply(y, turns, of_y, 1.0)
    found = _subtract(x, product[0], of_x, product[1]) if product is not None else None
    inside = (y.lo > 0.0).all() or (y.hi < 0.0).all()
    return (found[0].opaque(), found[1]) if found is not None and inside else None


def _fract(x: Band, unit: float) -> Found:
    found = _subtract(x, monotone(x, np.floor), unit, 1.0)
    return None if found is None else (glslmath.clamp(found[0], 0.0, 1.0), found[1])


_EXACT: Mapping[str, Callable[..., Found]] = {
    "add": _add,
    "subtract": _subtract,
    "multiply": _multiply,
    "negate": _negate,
    "mod": _mod,
    "fract": _fract,
}
