"""Closed intervals that a measured array is judged against, whatever its units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from shaderlab.bands.compiled import compiled
from shaderlab.bands.rounding import Flags, Floats, ulp

# Float64 values that fit into a second-level cache with their bounds.
BLOCK = 16384


class Interval:
    """What bands and what their storage allows have in common: values between two bounds."""

    __slots__ = ()
    lo: Floats
    hi: Floats

    @property
    def shape(self) -> tuple[int, ...]:
        return self.lo.shape

    @property
    def ndim(self) -> int:
        return self.lo.ndim

    def contains(self: Any, measured: ArrayLike) -> Flags:
        """Whether each measured float32 is legal: NaN only where it may be, Inf only at an end."""
        return contains(self.lo, self.hi, self.nan, measured)

    def widths(self: Any, measured: ArrayLike) -> Floats:
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

    lo: Floats
    hi: Floats
    nan: Flags
    vacuous: Flags
    undecided: Flags
    unit: float = 0.0


@compiled
@np.errstate(invalid="ignore")  # a signalling NaN, read back, is converted like any other
def contains(lo: Any, hi: Any, nan: Any, measured: ArrayLike) -> Flags:
    """Where lo ≤ measured ≤ hi, or measured is NaN and may be.

    Goes through equal shapes in blocks that stay in the processor's cache; only the result has
    full size. Bounds are float64, or float32 where the measured values are.
    """
    values = np.asarray(measured)
    shape = np.broadcast_shapes(lo.shape, hi.shape, values.shape, np.shape(nan))
    inside = np.empty(shape, np.bool_)
    flat = inside.reshape(-1)
    rows = [_flat(array, shape) for array in (values, lo, hi)]
    legal = _flat(np.asarray(nan), shape) if np.any(nan) else None
    size = min(BLOCK, flat.size)
    alike = values.dtype == lo.dtype == hi.dtype
    number, below = np.empty(size), np.empty(size, np.bool_)
    for start in range(0, flat.size, BLOCK):
        block = slice(start, start + BLOCK)
        got, found = rows[0][block], flat[block]
        if not alike:
            got = number[: found.size]
            np.copyto(got, rows[0][block])
        np.greater_equal(got, rows[1][block], out=found)
        found &= np.less_equal(got, rows[2][block], out=below[: got.size])
        if legal is not None:
            found |= np.isnan(got) & legal[block]
    return inside


def _flat(array: Any, shape: tuple[int, ...]) -> Any:
    """The array broadcast to `shape`, as one row; copied only where necessary."""
    return np.broadcast_to(array, shape).reshape(-1)


@np.errstate(all="ignore")
def widths(lo: Floats, hi: Floats, nan: Any, measured: ArrayLike, unit: float = 0.0) -> Floats:
    """How far measured values are from the middle, in half widths (1 = on a bound)."""
    value = np.asarray(measured, dtype=np.float64)
    half = np.asarray((hi - lo) * 0.5)
    result: Floats = np.abs(value - (lo + half)) / half
    odd = ~((half > 0.0) & np.isfinite(half) & ~np.isnan(value))
    if odd.any():
        at = [np.broadcast_to(array, result.shape)[odd] for array in (lo, hi, nan, value)]
        result[odd] = _odd_widths(at[0], at[1], at[2], at[3], unit)
    return result


def _odd_widths(lo: Floats, hi: Floats, nan: Flags, value: Floats, unit: float) -> Floats:
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
    result: Floats = np.where(bounded, scaled, unbounded)
    return np.where(np.isnan(value), np.where(nan, 0.0, np.inf), result)
