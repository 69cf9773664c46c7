"""Narrower bands of sums whose terms share inputs: f + n − z·(f − n) is 2n where z is 1, however
wide f is.

Interval arithmetic forgets that both f are the same number. The mean-value form remembers: a
polynomial lies within its value in the middle of a box, give or take each input's half width times
its steepest slope in the box (R. E. Moore, "Interval Analysis", 1966).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.bands.rounding import RELATIVE_STEP, SMALLEST_NORMAL, Ends
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


@dataclass(frozen=True)
class _Enclosure:
    """In each box: the value in its middle, the ends, the sum of all products' sizes, and between
    which ends the slope lies along each number that is read, by its id."""

    middle: Array
    low: Array
    high: Array
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
        if count > _MOST:
            return result
        shared = len(known) > 1 and known[0].read & known[1].read
        made = _Polynomial(result, op, known, frozenset().union(*(p.read for p in known)), count)
        if op in _SUMS and shared:
            made = _Polynomial(_narrow(made), op, known, made.read, count)
        self._note(made)
        return made.band

    def _note(self, made: _Polynomial) -> None:
        if len(self._known) > _KEPT:
            self._known.clear()
        self._known[id(made.band)] = made


def _narrow(made: _Polynomial) -> Band:
    """A polynomial's band, cut to what the mean-value form allows and all roundings change."""
    band = made.band
    with np.errstate(all="ignore"):
        found = _enclose(made, {}, {})
        give = (made.count + 2.0) * (RELATIVE_STEP * found.size + SMALLEST_NORMAL)
        low, high = np.fmax(band.lo, found.low - give), np.fmin(band.hi, found.high + give)
    crossed = ~(low <= high)
    low, high = np.where(crossed, band.lo, low), np.where(crossed, band.hi, high)
    return Band(low, high, band.rules, band.flags, band.terms)


def _enclose(
    one: _Polynomial, known: dict[int, _Enclosure], halves: dict[int, Array]
) -> _Enclosure:
    """The mean-value form; `halves` gets half of the width of each number that is read."""
    if id(one) in known:
        return known[id(one)]
    if one.parts:
        parts = [_enclose(part, known, halves) for part in one.parts]
        weights, found = _combine(one.op, parts[0], parts[-1])
        slopes: dict[int, Any] = {}
        for part, weight in zip(parts, weights, strict=True):
            for key, slope in part.slopes.items():
                ends, before = _multiply(slope, weight), slopes.get(key, (0.0, 0.0))
                slopes[key] = before[0] + ends[0], before[1] + ends[1]
        reach = sum(np.fmax(np.abs(a), np.abs(b)) * halves[k] for k, (a, b) in slopes.items())
        low, high = found.middle - reach, found.middle + reach
        low, high = np.fmax(found.low, low), np.fmin(found.high, high)
        found = replace(found, low=low, high=high, slopes=slopes)
    else:
        low, high = one.band.apply_slack()
        halves[id(one.band)] = 0.5 * (high - low)
        slope = {id(one.band): (np.ones_like(low),) * 2}
        found = _Enclosure(0.5 * (low + high), low, high, one.band.abs_sum, slope)
    known[id(one)] = found
    return found


def _combine(op: int, one: _Enclosure, other: _Enclosure) -> tuple[list[Any], _Enclosure]:
    """A step of interval arithmetic, and between what its slopes along both operands lie."""
    if op not in _SUMS and op != Op.FNegate:
        ends = (other.low, other.high), (one.low, one.high)
        low, high = _multiply(*ends)
        made = _Enclosure(one.middle * other.middle, low, high, one.size * other.size, {})
        return list(ends), made
    sign = 1.0 if op == Op.FAdd else -1.0
    low, high = _multiply((other.low, other.high), (sign, sign))
    if op == Op.FNegate:
        return [(sign, sign)], _Enclosure(-one.middle, low, high, one.size, {})
    middle, size = one.middle + sign * other.middle, one.size + other.size
    made = _Enclosure(middle, one.low + low, one.high + high, size, {})
    return [(1.0, 1.0), (sign, sign)], made


def _multiply(one: Any, other: Any) -> Ends:
    ends = [a * b for a, b in itertools.product(one, other)]
    return np.minimum.reduce(ends), np.maximum.reduce(ends)
