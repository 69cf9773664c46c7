"""A sharper bound of mix: in x·(1 - a) + y·a all three operands stand twice or count against each
other, which operations of intervals, one after the other, take for independent."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shaderlab.bands.compiled import compiled_arrays
from shaderlab.bands.rounding import RELATIVE_STEP, SMALLEST_NORMAL, Floats, outward

if TYPE_CHECKING:
    from shaderlab.bands.band import Band

# Roundings: of x·(1 - a) + y·a four, of x + (y - x)·a three; distributed, two products and three
# sums more.
_STEPS = 8.0


def within_ends(found: Band, x: Band, y: Band, a: Band) -> Band:
    """The band `found` of mix(x, y, a) by its operations, cut to what it may be at most.

    Without roundings mix is linear in each of x, y and a, so it is greatest and least at ends of
    their bands. All roundings, in whatever order, are of values no larger than the terms together.
    """
    if found.lo is found.hi:
        return found
    lo, hi = cut_to_ends(found, x, y, a, found.rules.flush)
    return found.kept(lo, hi, terms=found.terms)


@compiled_arrays
@np.errstate(all="ignore")
def cut_to_ends(found: Band, x: Band, y: Band, a: Band, flush: bool) -> tuple[Floats, Floats]:
    """The bounds of `found`, no wider than the ends of x, y and a allow."""
    sides = [_ends(x.settled(), y.settled(), end) for end in a.settled()]
    size = (x.mag + y.mag) * (1.0 + a.mag)
    lost: Floats = _STEPS * np.maximum(RELATIVE_STEP * size, SMALLEST_NORMAL)
    if found.terms is not None:
        lost = np.maximum(lost, _STEPS * found.terms.step())
    least = np.minimum(sides[0][0], sides[1][0]) - lost
    most = np.maximum(sides[0][1], sides[1][1]) + lost
    lo, hi = outward(least, most, flush)
    # Where a bound is NaN, of infinity times 0, the operations' own stays.
    return np.fmax(found.lo, lo), np.fmin(found.hi, hi)


def _ends(x: tuple[Floats, Floats], y: tuple[Floats, Floats], a: Floats) -> tuple[Floats, Floats]:
    """The least and the greatest x·(1 - a) + y·a at one `a`."""
    of_x = x[0] * (1.0 - a), x[1] * (1.0 - a)
    of_y = y[0] * a, y[1] * a
    return np.minimum(*of_x) + np.minimum(*of_y), np.maximum(*of_x) + np.maximum(*of_y)
