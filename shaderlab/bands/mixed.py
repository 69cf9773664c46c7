"""A sharper bound of mix: in x·(1 - a) + y·a all three operands stand twice or count against each
other, which operations of intervals, one after the other, take for independent."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shaderlab.bands.compiled import use_kernel
from shaderlab.bands.rounding import LARGEST, RELATIVE_STEP, SMALLEST_NORMAL, Floats, outward
from shaderlab.bands.terms import Terms, reach_of

if TYPE_CHECKING:
    from shaderlab.bands.band import Band

_FLUSHED = 8.0  # operations of which each may flush a denormal


@use_kernel
def within_ends(found: Band, x: Band, y: Band, a: Band) -> Band:
    """The band `found` of mix(x, y, a) by its operations, cut to what it may be at most.

    Without roundings mix is linear in each of x, y and a, so it is greatest and least at ends of
    their bands. What roundings add is `_lost`.
    """
    terms = _terms(found, x, y, a)
    if found.lo is found.hi:
        return found.kept(found.lo, found.lo, terms=terms)
    lo, hi = _cut_to_ends(found, x, y, a, found.rules.flush)
    return found.kept(lo, hi, terms=terms)


@np.errstate(all="ignore")
def _cut_to_ends(found: Band, x: Band, y: Band, a: Band, flush: bool) -> tuple[Floats, Floats]:
    """The bounds of `found`, no wider than the ends of x, y and a allow."""
    sides = [_ends(x.settled(), y.settled(), end) for end in a.settled()]
    lost = _lost(found, x, y, a)
    least = np.minimum(sides[0][0], sides[1][0]) - lost
    most = np.maximum(sides[0][1], sides[1][1]) + lost
    lo, hi = outward(least, most, flush)
    # Where a bound is NaN, of infinity times 0, the operations' own stays.
    return np.fmax(found.lo, lo), np.fmin(found.hi, hi)


def _lost(found: Band, x: Band, y: Band, a: Band) -> Floats:
    """What the roundings of a mix may add up to, in whichever of its forms.

    x·(1 - a) + y·a rounds the difference, two products and a sum; x + (y - x)·a a difference, a
    product and a sum; x - x·a + y·a two products and two sums. Sums that x, y and a are themselves
    may be taken apart for it, and added in any order.
    """
    both = (x.mag + y.mag) * _size(*a.settled())
    sums = 3.0 * (x.mag + both) + (x.count + y.count - 2) * both
    weights = x.mag * (1.0 + a.mag) + y.mag * a.mag
    lost: Floats = np.maximum(RELATIVE_STEP * (sums + weights), _FLUSHED * SMALLEST_NORMAL)
    if found.terms is not None and found.terms.reach is not None:
        lost = np.maximum(lost, _FLUSHED * found.terms.step())
    return np.where(a.mag > 0.0, lost, 0.0)  # where a is 0, this is x


@np.errstate(all="ignore")
def _terms(found: Band, x: Band, y: Band, a: Band) -> Terms | None:
    """The terms of a mix: those of x, and products with the share. They may be added to others in
    any order. No compiler multiplies out a long chain of mixes, whose terms double with each; of
    four the roundings stay inside even so.
    """
    terms = found.terms
    if terms is None:
        return None
    near, far = (_size(*band.settled()) for band in (x, y))
    mag = x.mag + (near + far) * a.mag
    mag = np.minimum(np.maximum(mag, _size(found.lo, found.hi)), LARGEST)
    return Terms.of(mag, lambda: reach_of(terms.mag, terms), terms, count=x.count + 2)


def _size(low: Floats, high: Floats) -> Floats:
    """The largest absolute value between two bounds."""
    size: Floats = np.minimum(np.maximum(np.abs(low), np.abs(high)), LARGEST)
    return size


def _ends(x: tuple[Floats, Floats], y: tuple[Floats, Floats], a: Floats) -> tuple[Floats, Floats]:
    """The least and the greatest x·(1 - a) + y·a at one `a`."""
    of_x = x[0] * (1.0 - a), x[1] * (1.0 - a)
    of_y = y[0] * a, y[1] * a
    return np.minimum(*of_x) + np.minimum(*of_y), np.maximum(*of_x) + np.maximum(*of_y)
