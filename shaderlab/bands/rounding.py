"""Rounding float64 bounds outward to the float32 grid, and the size of a float32 ULP."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SMALLEST_NORMAL = 2.0**-126
SMALLEST_DENORMAL = 2.0**-149
LARGEST = (2.0 - 2.0**-23) * 2.0**127

# The largest relative error of one rounding, in either direction. The added 2^-20 of it pays for
# the float64 rounding of the bound itself.
RELATIVE_STEP = 2.0**-23 * (1.0 + 2.0**-20)

# More than float64's own relative error in a quotient, a root or an elementary function.
FLOAT64_ERROR = 2.0**-50

_EXPONENT_BITS = np.int64(0x7FF0_0000_0000_0000)
_FRACTION_BITS = np.int64(0x000F_FFFF_FFFF_FFFF)


def ulp(x: Floats) -> Floats:
    """The float32 ULP at `x`; at a power of two the smaller neighbour's.

    >>> [float(u * 2**24) for u in ulp(np.array([1.0, 1.5, 2.0, 3.0]))]
    [1.0, 2.0, 2.0, 4.0]
    """
    size = np.asarray(np.abs(x))
    np.clip(size, SMALLEST_DENORMAL, LARGEST, out=size)
    # One less than a power of two's bits lies in the octave below: no special case is left.
    bits = size.view(np.int64)
    bits -= 1
    bits &= _EXPONENT_BITS
    size *= 2.0**-23
    step: Floats = np.maximum(size, SMALLEST_DENORMAL, out=size)
    return step


def _stepped(nearest: NDArray[np.float32], found: Floats, past: Flags, direction: int) -> Floats:
    """`nearest`, which as float64 is `found`, moved to the next float32 in `direction` wherever it
    lies `past` the bound; may write to both."""
    # The integers behind floats of one sign are in the floats' order.
    bits = nearest.view(np.int32)
    step = bits >> 31
    step |= 1
    step *= past.view(np.int8)
    if direction > 0:
        bits += step
    else:
        bits -= step
    np.copyto(found, nearest)
    return found


def down(x: Floats, residue: Floats | None = None) -> Floats:
    """The largest float32 not above `x + residue`, where the residue is below x's own last bit."""
    nearest = np.asarray(x).astype(np.float32)
    found = nearest.astype(np.float64)
    past = np.asarray(found > x)
    if residue is not None:
        past |= (found == x) & (residue < 0.0)
    return _stepped(nearest, found, past, -1)


def up(x: Floats, residue: Floats | None = None) -> Floats:
    """The smallest float32 not below `x + residue`, where the residue is below x's own last bit."""
    nearest = np.asarray(x).astype(np.float32)
    found = nearest.astype(np.float64)
    past = np.asarray(found < x)
    if residue is not None:
        past |= (found == x) & (residue > 0.0)
    return _stepped(nearest, found, past, 1)


def flushed(lo: Floats, hi: Floats) -> tuple[Floats, Floats]:
    """The same bounds, but those that touch denormals include zero."""
    small_lo = lo < SMALLEST_NORMAL
    small_lo &= lo > 0.0
    small_hi = hi > -SMALLEST_NORMAL
    small_hi &= hi < 0.0
    if small_lo.any() or small_hi.any():
        return np.where(small_lo, 0.0, lo), np.where(small_hi, 0.0, hi)
    return lo, hi


def two_sum(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """a + b rounded to float64, and what the rounding lost (Knuth, TAOCP 2, 4.2.2 theorem B)."""
    total = a + b
    b_part = np.asarray(total - a)
    # (a - (total - b_part)) + (b - b_part), without an array for each step.
    lost = np.asarray(total - b_part)
    np.subtract(a, lost, out=lost)
    np.subtract(b, b_part, out=b_part)
    np.add(lost, b_part, out=lost)
    return total, lost


def is_power_of_two(x: Floats) -> bool:
    """Whether each of `x` is zero or ±2^k, so that multiplying by it rounds nothing."""
    return not (x.view(np.int64) & _FRACTION_BITS).any()


def widened_by_ulps(
    lo: Floats, hi: Floats, ulps_lo: Floats | float, ulps_hi: Floats | float
) -> tuple[Floats, Floats]:
    """Bounds moved out by so many ULP; a bound does not move past zero, and zero stays zero."""
    out_lo = ulps_lo * ulp(lo) + FLOAT64_ERROR * np.minimum(np.abs(lo), LARGEST)
    out_hi = ulps_hi * ulp(hi) + FLOAT64_ERROR * np.minimum(np.abs(hi), LARGEST)
    # An ULP doubles past a power of two: a value above `lo`, just past one, may err further
    # below than `lo` itself.
    down_lo = lo - np.where(lo > 0.0, np.clip(out_hi, out_lo, 2.0 * out_lo), out_lo)
    up_hi = hi + np.where(hi < 0.0, np.clip(out_lo, out_hi, 2.0 * out_hi), out_hi)
    new_lo = np.where(lo >= 0.0, np.maximum(down_lo, 0.0), down_lo)
    new_hi = np.where(hi <= 0.0, np.minimum(up_hi, 0.0), up_hi)
    return new_lo, new_hi
