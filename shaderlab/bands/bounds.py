"""Values between two bounds, their components by GLSL's names (`v.xyz`, `color.rgb`, `uv.st`), and
what a band holds besides: rules, flags and terms.

What a value is a sum of matters, because a compiler that turns a·b + a·c into a·(b + c), or back,
rounds at the size of the terms, not of their sum. And it may multiply two small factors first,
flush the denormal product to zero, and multiply by a large one then: so what a flushed product may
change is more than the smallest normal number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from shaderlab.bands.rounding import (
    LARGEST,
    RELATIVE_STEP,
    SMALLEST_NORMAL,
    Ends,
    Flags,
    Float64Array,
    Rules,
    round_outward,
    ulp,
)

# The letters that name components in GLSL.
SETS = ("xyzw", "rgba", "stpq")


@lru_cache(maxsize=256)
def components(names: str, size: int) -> list[int] | None:
    """The components that GLSL's letters name, of one set and of `size`; None for other words."""
    for letters in SETS:
        if names and set(names) <= set(letters[:size]):
            return [letters.index(name) for name in names]
    return None


class Swizzled:
    """A value whose components have GLSL's names: read-only, any order, repeated or not."""

    __slots__ = ()

    def __getattr__(self: Any, names: str) -> Any:
        # Words that can't be a swizzle don't ask for the shape, which may be what is missing.
        found = None if components(names, 4) is None else components(names, self.shape[-1])
        if found is None:
            raise AttributeError(self._without(names))
        return self[..., found]

    def _without(self: Any, names: str) -> str:
        """What to say of a word that is no swizzle of this value."""
        if components(names, 4) is None:
            return f"{type(self).__name__} has no attribute {names!r}"
        size = self.shape[-1] if self.shape else 1
        kind = f"a vec{size} has" if size > 1 else "a float has"
        return f"{kind} no .{names}"


class Vector(Swizzled, np.ndarray):
    """A float64 array whose last axis is a vector's components.

    >>> np.array([1.0, 2.0, 3.0]).view(Vector).zx.tolist()
    [3.0, 1.0]
    """


def as_vector(result: Any, *values: Any) -> Any:
    """The result of a function that forgets it, as a `Vector` if one of its values is one."""
    if isinstance(result, np.ndarray) and any(isinstance(value, Vector) for value in values):
        return result.view(Vector)
    return result


# Above this size no product of two terms is a denormal, and how terms were made is forgotten.
TINY = 2.0**-60


_MOST_TERMS = 1 << 1000  # still a float; loops that square a sum have more


@dataclass(slots=True, eq=False)
class Terms:
    """The terms of a value that is a sum or a product.

    Attributes:
        abs_sum: the sum of the terms' absolute values.
        slack: an error still to be added before the value is added to or multiplied with another.
        count: how many terms there may be, once all is distributed.
        flush_gain: the factor by which a flushed partial product may be multiplied, which no
            partial sum or product exceeds; None where no term is tiny.
        signed: of ranges, where a term may be negative somewhere; None if that is unknown.
        base: the value that this is a power of, if it is one.
        factors: the powers that the value with the lower bounds `product` is a product of, by the
            id of what they are powers of.
    """

    abs_sum: Float64Array
    slack: Float64Array | None = None
    count: int = 1
    flush_gain: Float64Array | None = None
    signed: Flags | None = None
    _least: float | None = None
    base: Bounds | None = None
    factors: dict[int, Any] | None = None
    product: Float64Array | None = None

    @property
    def least(self) -> float:
        """The smallest `abs_sum`."""
        if self._least is None:
            self._least = find_least(self.abs_sum)
        return self._least

    @classmethod
    def of(
        cls,
        abs_sum: Float64Array,
        flush_gain: Callable[[], Float64Array],
        *parts: Terms | None,
        count: int = 1,
        signed: Flags | None = None,
    ) -> Terms:
        """Terms of these sizes, made from `parts`; `flush_gain` is computed where one is tiny, and
        of ranges, whose sizes are the largest."""
        least = find_least(abs_sum)
        tiny = signed is not None or may_be_tiny(abs_sum, least, *parts)
        count = min(count, _MOST_TERMS)
        return cls(abs_sum, None, count, flush_gain() if tiny else None, signed, least)

    def step(self) -> Float64Array:
        """What one rounding among these terms may change."""
        size: Float64Array = RELATIVE_STEP * self.abs_sum
        if self.flush_gain is None:
            if self.least >= TINY:
                return size
            if not may_be_tiny(self.abs_sum, self.least):
                return np.fmax(size, 0.0)  # 0 for NaN
        size = np.maximum(size, self.flush_error())
        return size if self.least > 0.0 else np.where(self.abs_sum > 0.0, size, 0.0)

    def safe(self) -> Flags:
        """Where the sum of these terms, settled, keeps its sign in any order: not among
        denormals, where flushing one of two terms of opposite signs may leave the other's."""
        if self.flush_gain is None and self.least >= TINY:
            return ~NO
        found: Flags = (RELATIVE_STEP * self.abs_sum >= self.flush_error()) | (self.abs_sum == 0.0)
        return found

    def flush_error(self) -> Float64Array | float:
        """What flushed products may change, all terms together."""
        if self.flush_gain is None:
            return SMALLEST_NORMAL
        return SMALLEST_NORMAL * self.count * self.flush_gain

    def overflow(self) -> Flags | None:
        """Of ranges, where a partial sum or product may overflow in another order, and meet 0 or
        another infinity then; None if nowhere."""
        if self.signed is None or self.flush_gain is None:
            return None
        found: Flags = self.flush_gain > LARGEST
        return found if found.any() else None

    def map_arrays(self, rearrange: Callable[[Any], Any]) -> Terms:
        """The same terms, their arrays rearranged by `rearrange`."""
        return Terms(
            rearrange(self.abs_sum),
            None if self.slack is None else rearrange(self.slack),
            self.count,
            None if self.flush_gain is None else rearrange(self.flush_gain),
            None if self.signed is None else rearrange(self.signed),
        )


def flush_gain_of(abs_sum: Float64Array, terms: Terms | None) -> Float64Array:
    """`Terms.flush_gain`, or for terms that are not tiny their own size, at least 1."""
    if terms is not None and terms.flush_gain is not None:
        return terms.flush_gain
    size: Float64Array = np.maximum(abs_sum, 1.0)
    return size


def find_least(abs_sum: Float64Array) -> float:
    """The smallest size; infinite for an empty array."""
    return float(np.minimum.reduce(abs_sum, axis=None)) if abs_sum.size else np.inf


def may_be_tiny(abs_sum: Float64Array, least: float, *parts: Terms | None) -> bool:
    """Whether products of terms of these sizes, the smallest of them `least`, may be denormal
    somewhere."""
    if any(part is not None and part.flush_gain is not None for part in parts):
        return True
    return least < TINY and bool(np.count_nonzero((abs_sum > 0.0) & (abs_sum < TINY)))


class Interval:
    """What bands and what their storage allows have in common: values between two bounds."""

    __slots__ = ()
    lo: Float64Array
    hi: Float64Array

    @property
    def shape(self) -> tuple[int, ...]:
        return self.lo.shape

    @property
    def ndim(self) -> int:
        return self.lo.ndim

    def contains(self: Any, measured: ArrayLike) -> Flags:
        """Whether each measured float32 is legal: NaN only where it may be, Inf only at an end."""
        return contains(self.lo, self.hi, self.nan, measured)

    def widths(self: Any, measured: ArrayLike) -> Float64Array:
        """How far each measured value is from the middle, in half widths: at most 1 inside.

        Where both bounds are equal, half an ULP (or half a code of the format) is the half width
        outside, and the distance inside is 0. A band without an end has no middle: 0 inside,
        1 + the distance in ULP beyond its other end. NaN is 0 where it is legal, else inf.
        """
        return widths(self.lo, self.hi, self.nan, measured, getattr(self, "unit", 0.0))


@dataclass(frozen=True, eq=False)
class Allowed(Interval):
    """The values that reading a format back may give: lo ≤ measured ≤ hi, in the format's units.

    Attributes:
        lo, hi: float64 bounds, both legal.
        nan: where NaN is legal too.
        vacuous: where the rules allowed anything before the format clamped it.
        undecided: where a branch went both ways.
        unit: the size of one code; 0 for float formats.
    """

    lo: Float64Array
    hi: Float64Array
    nan: Flags
    vacuous: Flags
    undecided: Flags
    unit: float = 0.0


NO = np.zeros((), dtype=np.bool_)
NOWHERE = (NO, NO, NO)

Flagged = tuple[Any, Any, Any]
"""Where a value may be NaN, where it may be anything, where it is undecided; 0-d for nowhere."""


class Bounds(Interval):
    """What a band holds, without its operators: bounds on the float32 grid, rounded outward.

    Attributes:
        lo, hi: float64 arrays; -inf and inf where the value may be infinite.
        flags: where a value may be NaN, where it may be anything, where a branch that led to it
            took both sides; each is 0-d if it is so nowhere.
        terms: what the value is a sum of, or None.
        direction: the cached result of `glslmath.normalize`, or None; formulas normalise the same
            few vectors repeatedly.
    """

    __slots__ = ("_size", "direction", "flags", "hi", "lo", "rules", "terms")

    def __init__(
        self,
        lo: Float64Array,
        hi: Float64Array,
        rules: Rules,
        flags: Flagged = NOWHERE,
        terms: Terms | None = None,
    ) -> None:
        # `lo is hi` marks exact values, and halves the arithmetic's work.
        self.lo = lo
        self.hi = hi
        self.rules = rules
        self.flags = flags
        self.terms = terms
        self.direction: Self | None = None
        self._size: Float64Array | None = None

    def derive(
        self,
        lo: Float64Array,
        hi: Float64Array,
        *others: Bounds,
        nan: Any = None,
        anything: Any = None,
        terms: Terms | None = None,
    ) -> Self:
        """A result of this band (and others) with real bounds lo, hi: rounded outward, flagged.

        For functions that compute with bands, not for formulas.
        """
        rounded_lo, rounded_hi = round_outward(lo, hi, self.rules.flush)
        flags = self._join_flags(others)
        if nan is not None and nan.any():
            flags = flags[0] | nan, flags[1], flags[2]
            rounded_lo = np.where(np.isnan(rounded_lo), -np.inf, rounded_lo)
            rounded_hi = np.where(np.isnan(rounded_hi), np.inf, rounded_hi)
        if anything is not None and anything.any():
            flags = flags[0] | anything, flags[1] | anything, flags[2]
            rounded_lo = np.where(anything, -np.inf, rounded_lo)
            rounded_hi = np.where(anything, np.inf, rounded_hi)
        return type(self)(rounded_lo, rounded_hi, self.rules, flags, terms)

    def derive_exact(
        self, lo: Float64Array, hi: Float64Array, *others: Bounds, terms: Terms | None = None
    ) -> Self:
        """`derive` from bounds that are on the float32 grid: nothing is left to round or flush."""
        return type(self)(lo, hi, self.rules, self._join_flags(others), terms)

    def _join_flags(self, others: tuple[Bounds, ...]) -> Flagged:
        flags = self.flags
        for other in others:
            a, b = flags, other.flags
            if b is not NOWHERE and not all(flag is NO for flag in b):
                flags = a[0] | b[0], a[1] | b[1], a[2] | b[2]
        return flags

    def join_flags_over_last(self) -> Self:
        """A band that only carries this one's flags, each joined over the last axis."""
        nothing = self.lo[..., 0:1]
        return type(self)(
            nothing, nothing, self.rules, self._map_flags(lambda a: a.any(-1, keepdims=True))
        )

    def _map_flags(self, function: Callable[[Any], Any]) -> Flagged:
        if self.flags is NOWHERE:
            return NOWHERE
        nan, anything, undecided = (
            flag if flag.ndim == 0 else function(np.broadcast_to(flag, self.shape))
            for flag in self.flags
        )
        return nan, anything, undecided

    def apply_slack(self) -> Ends:
        """The bounds once a pending slack is paid (see `arithmetic`)."""
        slack = None if self.terms is None else self.terms.slack
        if slack is None:
            return self.lo, self.hi
        return self.lo - slack, self.hi + slack

    def copy_independent(self) -> Self:
        """An equal but independent value: the product of the two is no square."""
        terms = self.terms and replace(self.terms, base=None, product=None)
        return type(self)(self.lo, self.hi, self.rules, self.flags, terms)

    def without_terms(self) -> Self:
        """The same values without their terms: nothing distributes over them."""
        return type(self)(self.lo, self.hi, self.rules, self.flags)

    @property
    def is_plain(self) -> bool:
        """Whether this is no sum, so that there is nothing to rearrange."""
        return self.terms is None

    @property
    def base(self) -> Bounds:
        """The value that this is a power of: itself, if of no other."""
        return self if self.terms is None or self.terms.base is None else self.terms.base

    @property
    def factors(self) -> dict[int, Any]:
        """The powers whose product this is, by their values' id: itself, if it is none."""
        known = self.terms if self.terms and self.terms.product is self.lo else None
        return (known and known.factors) or {id(self.base): self}

    @property
    def count(self) -> int:
        """How many terms this value may be the sum of, once all is distributed."""
        return 1 if self.terms is None else self.terms.count

    @property
    def abs_sum(self) -> Float64Array:
        """The sum of the absolute values of the terms that this value is made of."""
        if self.terms is not None:
            return self.terms.abs_sum
        if self._size is None:
            size = np.abs(self.lo) if self.lo is self.hi else np.maximum(-self.lo, self.hi)
            self._size = np.minimum(size, LARGEST)
        return self._size

    @property
    def signed(self) -> Flags:
        """Of a range, where a term may be negative."""
        if self.terms is None:
            found: Flags = self.lo < 0.0
            return found
        return ~NO if self.terms.signed is None else self.terms.signed

    def signed_with(self, other: Bounds) -> Flags | None:
        """Where a term of two ranges may be negative; None of bands that are no ranges."""
        return self.signed | other.signed if self.rules.ranges else None

    @property
    def least_abs_sum(self) -> float:
        """The smallest `abs_sum`."""
        return find_least(self.abs_sum) if self.terms is None else self.terms.least

    @property
    def nan(self) -> Flags:
        """Where the value may be NaN."""
        return np.broadcast_to(self.flags[0], self.shape)

    @property
    def may_be_nan(self) -> Flags:
        """`nan`, 0-d for nowhere."""
        found: Flags = self.flags[0]
        return found

    @property
    def undecided(self) -> Flags:
        """Where a branch that led here took both sides."""
        return np.broadcast_to(self.flags[2], self.shape)

    @property
    def vacuous(self) -> Flags:
        """Where anything is legal, here or in something that this value was computed from."""
        everything: Flags = self.flags[1] | ((self.lo == -np.inf) & (self.hi == np.inf))
        return np.broadcast_to(everything, self.shape)

    def __getitem__(self, index: Any) -> Self:
        return self.map_arrays(lambda array: np.asarray(array[index]))

    def map_arrays(self, function: Callable[[Any], Any]) -> Self:
        """The same values rearranged by `function`, such as indexing or a transposition."""

        def rearrange(array: Any) -> Any:
            same = array.shape == shape
            return function(array if same else np.broadcast_to(array, shape))

        shape = self.shape
        lo = rearrange(self.lo)
        hi = lo if self.lo is self.hi else rearrange(self.hi)
        terms = None if self.terms is None else self.terms.map_arrays(rearrange)
        return type(self)(lo, hi, self.rules, self._map_flags(function), terms)


BandT = TypeVar("BandT", bound=Bounds)
"""A band, for functions that compute with bands and know no operators."""


def combine_terms(parts: Sequence[Bounds], choose: Callable[[list[Any]], Any]) -> Terms | None:
    """The terms of bands put together by `choose` (joined, or chosen from); None if none has."""
    known = [band.terms for band in parts if band.terms is not None]
    if not known:
        return None
    sizes = [(band.abs_sum, band.terms) for band in parts]
    slack = flush_gain = None
    if any(terms.slack is not None for terms in known):
        slack = choose(
            [np.zeros(mag.shape) if t is None or t.slack is None else t.slack for mag, t in sizes]
        )
    if any(terms.flush_gain is not None for terms in known):
        flush_gain = choose([np.broadcast_to(flush_gain_of(mag, t), mag.shape) for mag, t in sizes])
    signed = None
    if parts[0].rules.ranges:  # of which the larger is chosen, too: true
        signed = choose([np.broadcast_to(p.signed, p.shape) for p in parts])
    count = max(terms.count for terms in known)
    return Terms(choose([mag for mag, _ in sizes]), slack, count, flush_gain, signed)


@np.errstate(invalid="ignore")  # a signalling NaN, read back, is converted like any other
def contains(lo: Any, hi: Any, nan: Any, measured: ArrayLike) -> Flags:
    """Where lo ≤ measured ≤ hi, or measured is NaN and may be."""
    values = np.asarray(measured)
    inside: Flags = (values >= lo) & (values <= hi)
    return inside | (np.isnan(values) & nan) if np.any(nan) else inside


@np.errstate(all="ignore")
def widths(
    lo: Float64Array, hi: Float64Array, nan: Any, measured: ArrayLike, unit: float = 0.0
) -> Float64Array:
    """How far measured values are from the middle, in half widths (1 = on a bound)."""
    value = np.asarray(measured, dtype=np.float64)
    half = np.asarray((hi - lo) * 0.5)
    result: Float64Array = np.abs(value - (lo + half)) / half
    odd = ~((half > 0.0) & np.isfinite(half) & ~np.isnan(value))
    if odd.any():
        at = [np.broadcast_to(array, result.shape)[odd] for array in (lo, hi, nan, value)]
        result[odd] = _odd_widths(at[0], at[1], at[2], at[3], unit)
    return result


def _odd_widths(
    lo: Float64Array, hi: Float64Array, nan: Flags, value: Float64Array, unit: float
) -> Float64Array:
    """`widths` of bands without width or without an end, and of NaN."""
    bounded = np.isfinite(lo) & np.isfinite(hi)
    # A band without width has the last bit (or one code) as its unit outside, and 0 inside.
    smallest = unit or ulp(np.where(bounded, lo, 1.0))
    half = (hi - lo) / 2.0
    scaled = np.where(
        half > 0.0, np.abs(value - (lo + half)) / half, np.abs(value - lo) / smallest * 2.0
    )
    # A band without an end has no middle: 0 inside, beyond the other end 1 + ULP past it.
    overshoot = np.maximum(
        np.where(value < lo, (lo - value) / ulp(np.nan_to_num(lo)), 0.0),
        np.where(value > hi, (value - hi) / ulp(np.nan_to_num(hi)), 0.0),
    )
    unbounded = np.where(overshoot > 0.0, 1.0 + overshoot, 0.0)
    result: Float64Array = np.where(bounded, scaled, unbounded)
    return np.where(np.isnan(value), np.where(nan, 0.0, np.inf), result)
