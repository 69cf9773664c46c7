"""The functions that round nothing: signs, integers, comparison, and choosing or joining values.

Minimum, maximum and choice pass NaN on.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands.rounding import Flags, Floats
from shaderlab.bands.terms import combined
from shaderlab.bands.truth import Truth

if TYPE_CHECKING:
    from shaderlab.bands.band import Band


def negative(a: Band) -> Band:
    lo = -a.hi
    return a.kept(lo, lo if a.lo is a.hi else -a.lo, terms=a.terms)


def absolute(a: Band) -> Band:
    low, high = np.abs(a.lo), np.abs(a.hi)
    if a.lo is a.hi:
        return a.kept(low, low)
    straddles = (a.lo < 0.0) & (a.hi > 0.0)
    return a.kept(np.where(straddles, 0.0, np.minimum(low, high)), np.maximum(low, high))


def monotone(a: Band, rounding: Any) -> Band:
    """A non-decreasing exact function such as floor: its values at both ends."""
    lo: Floats = rounding(a.lo)
    return a.kept(lo, lo if a.lo is a.hi else rounding(a.hi))


def rounded(a: Band) -> Band:
    """GLSL's round: a half may go either way."""
    return a.kept(np.ceil(a.lo - 0.5), np.floor(a.hi + 0.5))


def smaller(a: Band, b: Band) -> Band:
    """min(a, b); where one may be NaN either operand may come out."""
    return _chosen(np.minimum(a.lo, b.lo), np.minimum(a.hi, b.hi), a, b)


def larger(a: Band, b: Band) -> Band:
    """max(a, b); where one may be NaN either operand may come out."""
    return _chosen(np.maximum(a.lo, b.lo), np.maximum(a.hi, b.hi), a, b)


def _chosen(lo: Floats, hi: Floats, a: Band, b: Band) -> Band:
    for maybe_nan, other in ((a, b), (b, a)):
        if maybe_nan.may_be_nan.ndim and maybe_nan.may_be_nan.any():
            lo = np.where(maybe_nan.may_be_nan, np.minimum(lo, other.lo), lo)
            hi = np.where(maybe_nan.may_be_nan, np.maximum(hi, other.hi), hi)
    return a.kept(lo, hi, b)


def clamped(x: Band, minimum: Band, maximum: Band) -> Band:
    """min(max(x, minimum), maximum); anything where the minimum may exceed the maximum."""
    result = smaller(larger(x, minimum), maximum)
    crossed = minimum.hi > maximum.lo
    if minimum is maximum or not crossed.any():
        return result
    return result.made(result.lo, result.hi, anything=crossed)


def less(a: Band, b: Band) -> Truth:
    """a < b, of the settled bounds: a compiler may move a term to the other side."""
    a_lo, a_hi = a.settled()
    b_lo, b_hi = b.settled()
    return _known(a_hi < b_lo, a_lo >= b_hi, a, b)


def not_less(a: Band, b: Band) -> Truth:
    """a ≥ b."""
    return ~less(a, b)


def equal(a: Band, b: Band) -> Truth:
    """a == b: true only where both are one and the same single value."""
    a_lo, a_hi = a.settled()
    b_lo, b_hi = b.settled()
    same = (a_lo == b_lo) & (a_hi == b_hi) & (a_lo == a_hi)
    return _known(same, (a_hi < b_lo) | (b_hi < a_lo), a, b)


def _known(true: Flags, false: Flags, a: Band, b: Band) -> Truth:
    """An answer where neither of the bands compared may be NaN."""
    if a.may_be_nan.ndim or b.may_be_nan.ndim:
        known = ~(a.may_be_nan | b.may_be_nan)
        true, false = true & known, false & known
    return Truth(true, false, a.rules)


def select(condition: Truth, a: Band, b: Band) -> Band:
    """a where the condition holds, b where it does not, the hull of both where undecided.

    Flags follow the side taken.
    """
    yes, no, undecided = condition.all_true, condition.all_false, condition.undecided
    decided = not undecided.any()
    side = (yes.view(np.int8) - no.view(np.int8)).astype(np.float64)
    lo = taken(side, a.lo, b.lo, False)
    exact = decided and a.lo is a.hi and b.lo is b.hi
    hi = lo if exact else taken(side, a.hi, b.hi, True)
    nan, anything, either = (
        (of_a & ~no) | (of_b & ~yes) if of_a.ndim or of_b.ndim else of_a
        for of_a, of_b in zip(a.flags, b.flags, strict=True)
    )
    if not decided:
        either = either | undecided
    terms = combined((a, b), lambda values: taken(side, values[0], values[1], True))
    return type(a)(lo, hi, a.rules, (nan, anything, either), terms)


def taken(side: Floats, of_a: Floats, of_b: Floats, greater: bool) -> Floats:
    """`of_a` where the side is 1, `of_b` where it is -1, elsewhere the greater or the lesser."""
    hull = np.maximum(of_a, of_b) if greater else np.minimum(of_a, of_b)
    return np.where(side > 0.0, of_a, np.where(side < 0.0, of_b, hull))


@np.errstate(all="ignore")
def union(a: Band, b: Band) -> Band:
    """What either of two legal ways to compute one value may give."""
    lo, hi = np.minimum(a.lo, b.lo), np.maximum(a.hi, b.hi)
    terms = combined((a, b), lambda values: np.maximum(*values))
    return a.kept(lo, hi, b, terms=terms)


def transposed(m: Band) -> Band:
    """The matrices (…, r, c) with rows and columns exchanged."""
    return m.mapped(lambda array: array.swapaxes(-1, -2))


def joined(parts: Sequence[Band], axis: int) -> Band:
    """Bands of the same rules along a negative axis, the other axes broadcast."""

    def together(arrays: Sequence[Any]) -> Any:
        return concatenated(arrays, axis)

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
    terms = combined(parts, together)
    return type(first)(lo, hi, first.rules, (nan, anything, undecided), terms)


def concatenated(arrays: Sequence[Any], axis: int) -> Any:
    """NumPy's concatenate, along a negative axis, the axes other than that one broadcast.

    The result is contiguous: products of matrices depend on how these lie in memory, in float64's
    last bit.
    """
    return joined_last(list(arrays)) if axis == -1 else _joined(arrays, axis)


def joined_last(arrays: list[Any]) -> Any:
    """`concatenated` along the last axis."""
    return _joined(arrays, -1)


def _joined(arrays: Sequence[Any], axis: int) -> Any:
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
