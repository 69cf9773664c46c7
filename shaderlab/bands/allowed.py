"""Closed intervals that a measured array is judged against, whatever its units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from shaderlab.bands.rounding import Flags, Floats, ulp


@dataclass(frozen=True, slots=True, eq=False)
class Allowed:
    """The values that reading a format back may give: lo ≤ measured ≤ hi, in the format's units.

    Attributes:
        lo, hi: float64 bounds, both legal.
        nan: where NaN is legal too.
        vacuous: where the rules allowed anything before the format clamped it.
        undecided: where a branch went both ways.
        unit: the size of one code, for "so many codes off"; 0 where the format is a float's.
    """

    lo: Floats
    hi: Floats
    nan: Flags
    vacuous: Flags
    undecided: Flags
    unit: float = 0.0

    @property
    def shape(self) -> tuple[int, ...]:
        return self.lo.shape

    @property
    def ndim(self) -> int:
        return self.lo.ndim

    def contains(self, measured: ArrayLike) -> Flags:
        """Whether each measured value is legal."""
        return contains(self.lo, self.hi, self.nan, measured)

    def widths(self, measured: ArrayLike) -> Floats:
        """Distance from the middle in half widths: at most 1 inside; see `Band.widths`."""
        return widths(self.lo, self.hi, self.nan, measured, self.unit)


def contains(lo: Floats, hi: Floats, nan: Any, measured: ArrayLike) -> Flags:
    """Where lo ≤ measured ≤ hi, or measured is NaN and may be."""
    value = np.asarray(measured, dtype=np.float64)
    inside: Flags = ((value >= lo) & (value <= hi)) | (np.isnan(value) & nan)
    return inside


@np.errstate(all="ignore")
def widths(lo: Floats, hi: Floats, nan: Any, measured: ArrayLike, unit: float = 0.0) -> Floats:
    """How far measured values are from the middle, in half widths (1 = on a bound)."""
    value = np.asarray(measured, dtype=np.float64)
    bounded = np.isfinite(lo) & np.isfinite(hi)
    half = (hi - lo) / 2.0
    # A band without width has the last bit (or one code) as its unit outside, and 0 inside.
    smallest = unit or ulp(np.where(bounded, lo, 1.0))
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
