"""Narrower bands of sums whose terms share inputs: f + n − z·(f − n) is 2n where z is 1, however
wide f is.

Interval arithmetic forgets that both f are the same number. The mean-value form remembers: a
polynomial lies within its value in the middle of a box, give or take each input's half width times
its steepest slope in the box (R. E. Moore, "Interval Analysis", 1966).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from shaderlab.bands import Band
from shaderlab.bands.rounding import RELATIVE_STEP, SMALLEST_NORMAL
from shaderlab.compiler.spirv import Op
from shaderlab.model.frame import Array

_SUMS = (Op.FAdd, Op.FSub)
STEPS = (*_SUMS, Op.FMul, Op.FNegate, Op.VectorTimesScalar)
_MOST = 64  # products that a polynomial is the sum of, multiplied out
_KEPT = 512  # values that are remembered


@dataclass(frozen=True, eq=False)
class _Polynomial:
    """A number that is read, or what a step makes of others: `count` products in the numbers
    `read`, multiplied out."""

    band: Band
    op: int = 0
    parts: tuple[_Polynomial, ...] = ()
    read: frozenset[int] = frozenset()
    count: int = 1
    degree: int = 1


class _Form(NamedTuple):
    """In each box: a polynomial's value in the middle, the sum of its products' sizes, and between
    which ends its slope lies along each number that is read, by its id."""

    middle: Array
    size: Array
    slopes: Mapping[int, Any]


class Enclosures:
    """What values are polynomials in what is read, as a program is run on boxes."""

    def __init__(self) -> None:
        self._known: dict[int, _Polynomial] = {}

    def add_read(self, value: Any) -> None:
        """Note a value that is read, or a constant."""
        if isinstance(value, Band) and id(value) not in self._known:
            self._note(_Polynomial(value, read=frozenset([id(value)])))

    def narrow(self, op: int, values: Sequence[Any], result: Any) -> Any:
        """The result of one of STEPS; a sum of terms that share what they read may get narrower."""
        parts = tuple(self._known.get(id(value)) for value in values)
        if not isinstance(result, Band) or None in parts:
            return result
        known = tuple(part for part in parts if part is not None)
        counts = [part.count for part in known]
        count = sum(counts) if op in _SUMS else int(np.prod(counts))
        degrees = [part.degree for part in known]
        degree = max(degrees) if op in _SUMS else sum(degrees)
        if count > _MOST:
            return result
        shared = len(known) > 1 and known[0].read & known[1].read
        made = _Polynomial(
            result, op, known, frozenset().union(*(p.read for p in known)), count, degree
        )
        if op in _SUMS and shared:
            made = _Polynomial(_narrow(made), op, known, made.read, count, degree)
        self._note(made)
        return made.band

    def _note(self, made: _Polynomial) -> None:
        if len(self._known) > _KEPT:
            self._known.clear()
        self._known[id(made.band)] = made


def _narrow(made: _Polynomial) -> Band:
    """A polynomial's band, cut to what the mean-value form allows and all roundings change."""
    band, halves = made.band, dict[int, Array]()
    with np.errstate(all="ignore"):
        form = _find_form(made, {}, halves)
        flushed = SMALLEST_NORMAL if band.terms is None else band.terms.flush_error()
        reach = 2.0 * (made.count + made.degree) * (RELATIVE_STEP * form.size + flushed)
        for key, (least, most) in form.slopes.items():
            reach = reach + np.fmax(np.abs(least), np.abs(most)) * halves[key]
        low, high = np.fmax(band.lo, form.middle - reach), np.fmin(band.hi, form.middle + reach)
    # An infinite bound says that something may overflow, which the form knows nothing of.
    kept = ~(low <= high) | ~np.isfinite(band.hi - band.lo)
    low, high = np.where(kept, band.lo, low), np.where(kept, band.hi, high)
    return Band(low, high, band.rules, band.flags, band.terms)


def _find_form(one: _Polynomial, known: dict[int, _Form], halves: dict[int, Array]) -> _Form:
    """A polynomial's form; `halves` gets half of the width of each number that is read."""
    if id(one) in known:
        return known[id(one)]
    if not one.parts:
        low, high = one.band.apply_slack()
        halves[id(one.band)] = 0.5 * (high - low)
        slopes: dict[int, Any] = {id(one.band): (np.ones_like(low),) * 2}
        form = _Form(0.5 * (low + high), one.band.abs_sum, slopes)
    else:
        parts = [_find_form(part, known, halves) for part in one.parts]
        first, other = parts[0], parts[-1]
        sign, slopes = 1.0 if one.op == Op.FAdd else -1.0, {}
        weights: list[Any]
        if one.op == Op.FNegate:
            middle, size, weights = -first.middle, first.size, [(sign, sign)]
        elif one.op in _SUMS:
            middle, size = first.middle + sign * other.middle, first.size + other.size
            weights = [(1.0, 1.0), (sign, sign)]
        else:
            middle, size = first.middle * other.middle, first.size * other.size
            weights = [part.band.apply_slack() for part in reversed(one.parts)]
        for part, weight in zip(parts, weights, strict=True):
            for key, slope in part.slopes.items():
                ends = [a * b for a, b in itertools.product(slope, weight)]
                least, most = slopes.get(key, (0.0, 0.0))
                slopes[key] = least + np.minimum.reduce(ends), most + np.maximum.reduce(ends)
        form = _Form(middle, size, slopes)
    known[id(one)] = form
    return form
