"""The functions that round nothing: signs, integers, comparison, and choosing or joining values.

Minimum, maximum and choice pass NaN on.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.bands.bounds import BandT, Bounds, combine_terms
from shaderlab.bands.rounding import Flags, Float64Array
from shaderlab.bands.tri_bool import TriBool


def negate(a: BandT) -> BandT:
    lo = -a.hi
    return a.derive_exact(lo, lo if a.lo is a.hi else -a.lo, terms=a.terms)


def absolute_value(a: BandT) -> BandT:
    low, high = np.abs(a.lo), np.abs(a.hi)
    if a.lo is a.hi:
        return a.derive_exact(low, low)
    straddles = (a.lo < 0.0) & (a.hi > 0.0)
    return a.derive_exact(np.where(straddles, 0.0, np.minimum(low, high)), np.maximum(low, high))


def apply_monotone(a: BandT, rounding: Any) -> BandT:
    """A non-decreasing exact function such as floor: its values at both ends."""
    lo: Float64Array = rounding(a.lo)
    return a.derive_exact(lo, lo if a.lo is a.hi else rounding(a.hi))


def round_either_way(a: BandT) -> BandT:
    """GLSL's round: a half may go either way."""
    return a.derive_exact(np.ceil(a.lo - 0.5), np.floor(a.hi + 0.5))


def minimum_of(a: BandT, b: BandT) -> BandT:
    """min(a, b); where one may be NaN either operand may come out."""
    return _hold_nan(np.minimum(a.lo, b.lo), np.minimum(a.hi, b.hi), a, b)


def maximum_of(a: BandT, b: BandT) -> BandT:
    """max(a, b); where one may be NaN either operand may come out."""
    return _hold_nan(np.maximum(a.lo, b.lo), np.maximum(a.hi, b.hi), a, b)


def _hold_nan(lo: Float64Array, hi: Float64Array, a: BandT, b: BandT) -> BandT:
    for maybe_nan, other in ((a, b), (b, a)):
        if maybe_nan.may_be_nan.ndim and maybe_nan.may_be_nan.any():
            lo = np.where(maybe_nan.may_be_nan, np.minimum(lo, other.lo), lo)
            hi = np.where(maybe_nan.may_be_nan, np.maximum(hi, other.hi), hi)
    return a.derive_exact(lo, hi, b)


def clamp(x: BandT, minimum: BandT, maximum: BandT) -> BandT:
    """min(max(x, minimum), maximum); anything where the minimum may exceed the maximum."""
    result = minimum_of(maximum_of(x, minimum), maximum)
    crossed = minimum.hi > maximum.lo
    if minimum is maximum or not crossed.any():
        return result
    return result.derive(result.lo, result.hi, anything=crossed)


def less(a: Bounds, b: Bounds) -> TriBool:
    """a < b, of the settled bounds: a compiler may move a term to the other side."""
    a_lo, a_hi = a.apply_slack()
    b_lo, b_hi = b.apply_slack()
    return _decide(a_hi < b_lo, a_lo >= b_hi, a, b)


def not_less(a: Bounds, b: Bounds) -> TriBool:
    """a ≥ b."""
    return ~less(a, b)


def equal(a: Bounds, b: Bounds) -> TriBool:
    """a == b: true only where both are one and the same single value."""
    a_lo, a_hi = a.apply_slack()
    b_lo, b_hi = b.apply_slack()
    same = (a_lo == b_lo) & (a_hi == b_hi) & (a_lo == a_hi)
    return _decide(same, (a_hi < b_lo) | (b_hi < a_lo), a, b)


def _decide(true: Flags, false: Flags, a: Bounds, b: Bounds) -> TriBool:
    """An answer where neither of the bands compared may be NaN."""
    if a.may_be_nan.ndim or b.may_be_nan.ndim:
        known = ~(a.may_be_nan | b.may_be_nan)
        true, false = true & known, false & known
    return TriBool(true, false, a.rules)


def select(condition: TriBool, a: BandT, b: BandT) -> BandT:
    """a where the condition holds, b where it does not, the hull of both where undecided.

    Flags follow the side taken.
    """
    yes, no, undecided = condition.all_true, condition.all_false, condition.undecided
    decided = not undecided.any()

    def choose(of_a: Float64Array, of_b: Float64Array, outer: Any) -> Float64Array:
        chosen = np.where(yes, of_a, of_b)
        return chosen if decided else np.where(undecided, outer(of_a, of_b), chosen)

    lo = choose(a.lo, b.lo, np.minimum)
    exact = decided and a.lo is a.hi and b.lo is b.hi
    hi = lo if exact else choose(a.hi, b.hi, np.maximum)
    nan, anything, either = (
        (of_a & ~no) | (of_b & ~yes) if of_a.ndim or of_b.ndim else of_a
        for of_a, of_b in zip(a.flags, b.flags, strict=True)
    )
    if not decided:
        either = either | undecided
    terms = combine_terms((a, b), lambda values: choose(values[0], values[1], np.maximum))
    return type(a)(lo, hi, a.rules, (nan, anything, either), terms)


@np.errstate(all="ignore")
def union(a: BandT, b: BandT) -> BandT:
    """What either of two legal ways to compute one value may give."""
    lo, hi = np.minimum(a.lo, b.lo), np.maximum(a.hi, b.hi)
    terms = combine_terms((a, b), lambda values: np.maximum(*values))
    return a.derive_exact(lo, hi, b, terms=terms)


def transpose(m: BandT) -> BandT:
    """The matrices (…, r, c) with rows and columns exchanged."""
    return m.map_arrays(lambda array: array.swapaxes(-1, -2))


def join(parts: Sequence[BandT], axis: int) -> BandT:
    """Bands of the same rules along a negative axis, the other axes broadcast."""

    def together(arrays: Sequence[Any]) -> Any:
        return concatenate(arrays, axis)

    first = parts[0]
    lo = together([part.lo for part in parts])
    exact = all(part.lo is part.hi for part in parts)
    hi = lo if exact else together([part.hi for part in parts])
    nan, anything, undecided = (
        together([np.broadcast_to(f, p.shape) for f, p in zip(column, parts, strict=True)])
        if any(flag.ndim for flag in column)
        else column[0]
        for column in zip(*(part.flags for part in parts), strict=True)
    )
    terms = combine_terms(parts, together)
    return type(first)(lo, hi, first.rules, (nan, anything, undecided), terms)


def concatenate(arrays: Sequence[Any], axis: int) -> Any:
    """NumPy's concatenate, along a negative axis, the axes other than that one broadcast.

    The result is contiguous: products of matrices depend on how these lie in memory, in float64's
    last bit.
    """
    ndim = max(-axis, *(array.ndim for array in arrays))
    rows = [array.reshape((1,) * (ndim - array.ndim) + array.shape) for array in arrays]
    before, after = slice(ndim + axis), slice(ndim + axis + 1, None)
    others = {(*row.shape[before], 1, *row.shape[after]) for row in rows}
    common = others.pop() if len(others) == 1 else np.broadcast_shapes(*others)
    length = sum(row.shape[axis] for row in rows)
    whole = np.empty((*common[before], length, *common[after]), np.result_type(*rows))
    places, start = whole.swapaxes(0, axis), 0
    for row in rows:
        end = start + row.shape[axis]
        places[start:end] = row.swapaxes(0, axis)
        start = end
    return whole
