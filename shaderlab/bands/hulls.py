"""What the ends of two intervals make of a product or a quotient, before anything is rounded."""

from __future__ import annotations

import numpy as np

from shaderlab.bands.rounding import SMALLEST_NORMAL, Flags, Floats, finite
from shaderlab.bands.terms import least_of

LARGEST_DIVISOR = 2.0**126


def product_bounds(a_lo: Floats, a_hi: Floats, b_lo: Floats, b_hi: Floats) -> tuple[Floats, Floats]:
    """The hull of the products of the ends. Exact: 24 + 24 bits fit into float64."""
    if b_lo is b_hi:
        a_lo, a_hi, b_lo, b_hi = b_lo, b_hi, a_lo, a_hi
    if a_lo is a_hi:
        first = a_lo * b_lo
        if b_lo is b_hi:
            return first, first
        second = a_lo * b_hi
        return np.fmin(first, second), np.fmax(first, second)
    if least_of(a_lo) >= 0.0:
        a_lo, a_hi, b_lo, b_hi = b_lo, b_hi, a_lo, a_hi
    if least_of(b_lo) >= 0.0:
        if least_of(a_lo) >= 0.0:
            lo, hi = a_lo * b_lo, a_hi * b_hi
        else:
            lo = np.minimum(a_lo * b_lo, a_lo * b_hi)
            hi = np.maximum(a_hi * b_lo, a_hi * b_hi)
        # Where 0·inf adds a NaN, not a bound, all four products are looked at.
        if finite(lo, hi):
            return lo, hi
    first, second, third, fourth = a_lo * b_lo, a_lo * b_hi, a_hi * b_lo, a_hi * b_hi
    return (
        np.fmin(np.fmin(first, second), np.fmin(third, fourth)),
        np.fmax(np.fmax(first, second), np.fmax(third, fourth)),
    )


def zero_times_infinity(a_lo: Floats, a_hi: Floats, b_lo: Floats, b_hi: Floats) -> Flags:
    a_zero = (a_lo <= 0.0) & (a_hi >= 0.0)
    b_zero = (b_lo <= 0.0) & (b_hi >= 0.0)
    a_infinite = np.isinf(a_lo) | np.isinf(a_hi)
    b_infinite = np.isinf(b_lo) | np.isinf(b_hi)
    found: Flags = (a_zero & b_infinite) | (b_zero & a_infinite)
    return found


def usable_divisor(b_lo: Floats, b_hi: Floats) -> tuple[Floats, Floats, Floats, Flags]:
    """The divisor's bounds and its smallest absolute value, 1 where it is outside the range that
    has a precision; and where that is."""
    low, high = np.abs(b_lo), np.abs(b_hi)
    smallest = np.minimum(low, high)
    outside = (
        (smallest < SMALLEST_NORMAL)
        | (np.maximum(low, high) > LARGEST_DIVISOR)
        | ((b_lo <= 0.0) & (b_hi >= 0.0))
    )
    if not outside.any():
        return b_lo, b_hi, smallest, outside
    usable_lo = np.where(outside, 1.0, b_lo)
    usable_hi = usable_lo if b_lo is b_hi else np.where(outside, 1.0, b_hi)
    return usable_lo, usable_hi, np.where(outside, 1.0, smallest), outside


def quotient_bounds(
    a_lo: Floats, a_hi: Floats, b_lo: Floats, b_hi: Floats
) -> tuple[Floats, Floats]:
    """The hull of the quotients of the ends; no divisor is zero."""
    if a_lo is a_hi and b_lo is b_hi:
        quotient = a_lo / b_lo
        return quotient, quotient
    if least_of(a_lo) >= 0.0 and least_of(b_lo) > 0.0:
        return a_lo / b_hi, a_hi / b_lo
    low, high = a_lo / b_lo, a_hi / b_lo
    lo, hi = np.minimum(low, high), np.maximum(low, high)
    if b_lo is not b_hi:
        low, high = a_lo / b_hi, a_hi / b_hi
        lo, hi = np.minimum(lo, np.minimum(low, high)), np.maximum(hi, np.maximum(low, high))
    return lo, hi
