"""What rounds nothing: signs, comparisons and their three-valued answers, choosing and joining.

A comparison of two bands is true, false, or undecided, value by value. Minimum, maximum and choice
pass NaN on.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextvars import ContextVar
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from shaderlab.bands.bounds import BandT, Bounds, combine_terms
from shaderlab.bands.rounding import Flags, Float64Array, Rules
from shaderlab.errors import FormulaError

DECIDING: ContextVar[bool] = ContextVar("DECIDING", default=False)
"""Whether a Python condition may take what is the same at all values; elsewhere it raises."""


class TriBool:
    """What a condition is at each value: true on every device, false on every device, or neither.

    `&`, `|`, `~` combine truths (and plain boolean arrays); `glslmath.where(truth, a, b)` chooses.
    `bool(truth)` raises `FormulaError`, because a Python `if` takes one side for all pixels.

    Attributes:
        all_true, all_false: boolean arrays of one shape; nowhere are both set.
        undecided: neither of them.
        rules: those of the bands compared; None if this came from plain booleans.
    """

    __slots__ = ("all_false", "all_true", "rules")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, all_true: Any, all_false: Any, rules: Rules | None = None) -> None:
        self.all_true: Flags
        self.all_false: Flags
        if all_true.shape != all_false.shape:
            all_true, all_false = np.broadcast_arrays(all_true, all_false)
        self.all_true, self.all_false = all_true, all_false
        self.rules = rules

    @classmethod
    def of(cls, values: Any) -> TriBool:
        """The truth of plain booleans."""
        flags = np.atleast_1d(np.asarray(values, dtype=np.bool_))
        return cls(flags, ~flags)

    @property
    def undecided(self) -> Flags:
        neither: Flags = ~(self.all_true | self.all_false)
        return neither

    @property
    def shape(self) -> tuple[int, ...]:
        return self.all_true.shape

    @property
    def ndim(self) -> int:
        return self.all_true.ndim

    def __getitem__(self, index: Any) -> TriBool:
        return TriBool(self.all_true[index], self.all_false[index], self.rules)

    def __and__(self, other: Any) -> TriBool:
        other = as_tri_bool(other)
        rules = self.rules or other.rules
        return TriBool(self.all_true & other.all_true, self.all_false | other.all_false, rules)

    def __or__(self, other: Any) -> TriBool:
        return ~(~self & ~as_tri_bool(other))

    __rand__ = __and__
    __ror__ = __or__

    def __invert__(self) -> TriBool:
        return TriBool(self.all_false, self.all_true, self.rules)

    def all(self) -> TriBool:
        """GLSL's `all`: over the last axis, which stays with size 1."""
        every = self.all_true.all(axis=-1, keepdims=True)
        return TriBool(every, self.all_false.any(axis=-1, keepdims=True), self.rules)

    def any(self) -> TriBool:
        """GLSL's `any`: over the last axis, which stays with size 1."""
        return ~(~self).all()

    def __bool__(self) -> bool:
        if DECIDING.get() and (self.all_true.all() or self.all_false.all()):
            return bool(self.all_true.all())
        raise FormulaError(
            "a comparison of bands has no single answer: it may differ from pixel to pixel",
            remedy="choose with glslmath.where(condition, a, b); combine conditions with & | ~",
        )

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any
    ) -> TriBool:
        if method == "__call__" and len(inputs) == 2 and not options:
            left, right = (as_tri_bool(value) for value in inputs)
            if ufunc in (np.bitwise_and, np.logical_and):
                return left & right
            if ufunc in (np.bitwise_or, np.logical_or):
                return left | right
        raise FormulaError(
            f"numpy.{ufunc.__name__} cannot take a comparison of bands",
            remedy="combine conditions with & | ~ and choose with glslmath.where",
        )

    def __repr__(self) -> str:
        return (
            f"TriBool(shape={self.shape}, true={int(self.all_true.sum())}, "
            f"false={int(self.all_false.sum())}, undecided={int(self.undecided.sum())})"
        )


def as_tri_bool(condition: Any) -> TriBool:
    """`condition` itself, or plain booleans as a truth."""
    return condition if isinstance(condition, TriBool) else TriBool.of(condition)


def negate(a: BandT) -> BandT:
    lo, terms = -a.hi, a.terms
    if terms is not None and terms.signed is not None:
        terms = replace(terms, signed=None)
    return a.derive_exact(lo, lo if a.lo is a.hi else -a.lo, terms=terms)


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
        return concatenate(arrays, axis, "F")

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


def concatenate(arrays: Sequence[Any], axis: int, order: Literal["C", "F"] = "C") -> Any:
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
    whole = np.empty((*common[before], length, *common[after]), np.result_type(*rows), order)
    places, start = whole.swapaxes(0, axis), 0
    for row in rows:
        end = start + row.shape[axis]
        places[start:end] = row.swapaxes(0, axis)
        start = end
    return whole
