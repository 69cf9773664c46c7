"""Sums, products and quotients of bands, with what rearranging them may add.

Every band carries `mag`, the sum of the absolute values of the terms it is made of. A compiler
that turns a·b + a·c into a·(b + c), or back, rounds at the size of the terms, not of their sum,
and rounds where the formula as written happens to be exact. So:

- one sum or product of plain values (inputs, constants, what functions return) is rounded once;
  nothing can be rearranged yet, but the result has a `mag`;
- a sum of two plain values remembers one step of `mag` as its `slack`, paid as soon as it is
  added to or multiplied with something (a·(b + c) may become a·b + a·c);
- each further sum, product or quotient rounds by a step of its `mag` more, a product of two such
  values by three (or by the number of its sums, once distributed);
- a sum of n terms may be added up in an order in which all n − 1 sums are as large as the largest
  of them, whatever they were as written.

A plain band has no `mag` of its own (None: its own absolute value), and pays nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from shaderlab.bands.compiled import use_kernel
from shaderlab.bands.exact import negative
from shaderlab.bands.hulls import (
    LARGEST_DIVISOR,
    product_bounds,
    quotient_bounds,
    usable_divisor,
    zero_times_infinity,
)
from shaderlab.bands.rounding import (
    LARGEST,
    RELATIVE_STEP,
    SMALLEST_NORMAL,
    Flags,
    Floats,
    add_above,
    add_below,
    finite,
    is_power_of_two,
    widened_by_ulps,
)
from shaderlab.bands.terms import Terms, is_tiny, least_of, reach_of

if TYPE_CHECKING:
    from shaderlab.bands.band import Band

DIVISION_ULPS = 2.5
# Terms whose sizes add up to the result's (but for roundings) have one sign, and keep it in any
# order.
UNCANCELLED = 1.0 - 2.0**-20


@use_kernel
@np.errstate(all="ignore")
def add(a: Band, b: Band) -> Band:
    """a + b, correctly rounded in either direction."""
    a_lo, a_hi = a.settled()
    b_lo, b_hi = b.settled()
    lo, hi = add_below(a_lo, b_lo), add_above(a_hi, b_hi)
    if a_lo is a_hi and b_lo is b_hi and (lo == hi).all():
        hi = lo
    nan = None
    if not finite(lo, hi):
        nan = ((a_hi == np.inf) & (b_lo == -np.inf)) | ((a_lo == -np.inf) & (b_hi == np.inf))
    if not a.rules.rearrange:
        return a.made(lo, hi, b, nan=nan)
    mag_a, mag_b = a.mag, b.mag
    mag = mag_a + mag_b
    terms = Terms.of(
        mag,
        lambda: reach_of(mag_a, a.terms) + reach_of(mag_b, b.terms),
        a.terms,
        b.terms,
        count=a.count + b.count,
    )
    step = terms.step()
    if least_of(mag_a) <= 0.0 or least_of(mag_b) <= 0.0:
        # Adding an exact zero is no sum: no compiler keeps it.
        step = np.where((mag_a > 0.0) & (mag_b > 0.0), step, 0.0)
    if a.is_plain and b.is_plain:
        terms.slack = step
        return a.made(lo, hi, b, nan=nan, terms=terms)
    if a.count > 1:
        step = step + (a.count - 1) * RELATIVE_STEP * mag_b
    if b.count > 1:
        step = step + (b.count - 1) * RELATIVE_STEP * mag_a

    def not_negative(crossed: Flags) -> Flags:
        found: Flags = crossed & (a.lo >= 0.0) & (b.lo >= 0.0)
        if found.any():
            found &= (a_lo + b_lo >= step) | (hi >= mag * UNCANCELLED)
        return found

    def not_positive(crossed: Flags) -> Flags:
        found: Flags = crossed & (a.hi <= 0.0) & (b.hi <= 0.0)
        if found.any():
            found &= (a_hi + b_hi <= -step) | (-lo >= mag * UNCANCELLED)
        return found

    moved = moved_out(lo, hi, step, not_negative, not_positive)
    return a.made(*moved, b, nan=nan, terms=terms)


@use_kernel
def subtract(a: Band, b: Band) -> Band:
    """a - b, correctly rounded in either direction."""
    return add(a, negative(b))


def moved_out(
    lo: Floats,
    hi: Floats,
    step: Floats,
    not_negative: Callable[[Flags], Flags],
    not_positive: Callable[[Flags], Flags],
) -> tuple[Floats, Floats]:
    """Bounds moved out by a step, which does not take a result past zero that can't have its sign.

    Operands of one sign, once settled, are further from zero than any rearrangement can err.
    `not_negative` and `not_positive` say which of the results that crossed zero can't have.
    """
    out_lo, out_hi = lo - step, hi + step
    crossed = out_lo < 0.0
    if crossed.any():
        np.copyto(out_lo, 0.0, where=not_negative(crossed))
    crossed = out_hi > 0.0
    if crossed.any():
        np.copyto(out_hi, 0.0, where=not_positive(crossed))
    return out_lo, out_hi


def _safe_signs(
    lo: Floats, hi: Floats, terms: Terms, least: Floats | None = None
) -> tuple[Callable[[Flags], Flags], Callable[[Flags], Flags]]:
    """For `moved_out`: where a settled sum times or over a plain value keeps its sign, its terms
    distributed; and where its size is at least `least`, if given."""

    def kept(crossed: Flags, sided: Flags, size: Floats) -> Flags:
        found: Flags = crossed & sided
        if found.any():
            found &= terms.safe()
            if least is not None:
                found &= size >= least
        return found

    return (
        lambda crossed: kept(crossed, lo >= 0.0, hi),
        lambda crossed: kept(crossed, hi <= 0.0, -lo),
    )


@use_kernel
@np.errstate(all="ignore")
def multiply(a: Band, b: Band) -> Band:
    """a · b, correctly rounded in either direction; a value times itself is not negative."""
    if a is b:
        return square(a)
    for scale, other in ((a, b), (b, a)):
        if (
            scale.lo is scale.hi
            and scale.is_plain
            and scale.lo.size <= 16
            and is_power_of_two(scale.lo)
        ):
            return scaled(other, scale)
    a_lo, a_hi = a.settled()
    b_lo, b_hi = b.settled()
    lo, hi = product_bounds(a_lo, a_hi, b_lo, b_hi)
    nan = None
    if not finite(lo, hi):
        nan = zero_times_infinity(a_lo, a_hi, b_lo, b_hi)
    if not a.rules.rearrange:
        return a.made(lo, hi, b, nan=nan)
    mag_a, mag_b = a.mag, b.mag
    mag = mag_a * mag_b
    terms = Terms.of(
        mag,
        lambda: np.maximum(reach_of(mag_a, a.terms) * reach_of(mag_b, b.terms), 1.0),
        a.terms,
        b.terms,
        count=a.count * b.count,
    )
    if a.is_plain and b.is_plain:
        return a.made(lo, hi, b, nan=nan, terms=terms)
    # (a + b)·(c + d) may become four products and three sums, each of the size of the terms.
    steps = 1 if a.is_plain or b.is_plain else max(3, terms.count - 1)
    keeps = _safe_signs(lo, hi, terms, mag * UNCANCELLED if steps > 1 else None)
    moved = moved_out(lo, hi, steps * terms.step() if steps > 1 else terms.step(), *keeps)
    return a.made(*moved, b, nan=nan, terms=terms)


@np.errstate(all="ignore")
def scaled(a: Band, scale: Band) -> Band:
    """a · 0 or a · ±2^k: nothing is rounded, so a pending slack stays pending."""
    lo, hi = product_bounds(a.lo, a.hi, scale.lo, scale.lo)
    nan = None
    if not finite(lo, hi):
        nan = zero_times_infinity(a.lo, a.hi, scale.lo, scale.lo)
    return a.made(lo, hi, scale, nan=nan, terms=_scaled_terms(a, np.abs(scale.lo)))


def _scaled_terms(a: Band, factor: Floats) -> Terms | None:
    terms = a.terms
    if terms is None:
        scaled = a.mag * factor
        if not a.rules.rearrange or not is_tiny(scaled, least_of(scaled)):
            return None
        # Small times large: the small one may meet another small one first.
        large = np.maximum(a.mag, 1.0) * np.maximum(factor, 1.0)
        return Terms(scaled, reach=large) if (large > 1.0).any() else None
    slack = reach = None
    if terms.slack is not None:
        scaled = terms.slack * factor
        slack = np.where(scaled > 0.0, np.maximum(scaled, SMALLEST_NORMAL), 0.0)
    if terms.reach is not None:
        reach = terms.reach * np.maximum(factor, 1.0)
    return Terms(terms.mag * factor, slack, terms.count, reach)


@use_kernel
@np.errstate(all="ignore")
def square(a: Band) -> Band:
    """a · a for one and the same value: never negative, and no compiler expands (b + c)²."""
    if a.lo is a.hi:
        product = a.lo * a.lo
        return a.made(product, product, terms=_squared(a, product) if a.rules.rearrange else None)
    low, high = a.lo * a.lo, a.hi * a.hi
    straddles = (a.lo < 0.0) & (a.hi > 0.0)
    lo, hi = np.where(straddles, 0.0, np.minimum(low, high)), np.maximum(low, high)
    if not a.rules.rearrange:
        return a.made(lo, hi)
    terms = _squared(a, hi)
    step = 0.0 if a.is_plain else terms.step()
    return a.made(np.maximum(lo - step, 0.0), hi + step, terms=terms)


def _squared(a: Band, product: Floats) -> Terms:
    mag = np.minimum(product, LARGEST)
    return Terms.of(mag, lambda: np.maximum(reach_of(a.mag, a.terms) ** 2, 1.0), a.terms)


@use_kernel
@np.errstate(all="ignore")
def divide(a: Band, b: Band) -> Band:
    """a / b within 2.5 ULP where 2^-126 ≤ |b| ≤ 2^126; anything elsewhere."""
    a_lo, a_hi = a.settled()
    b_lo, b_hi = b.lo, b.hi
    outside = None
    if least_of(b_lo) >= SMALLEST_NORMAL and b_hi.size and b_hi.max() <= LARGEST_DIVISOR:
        smallest = b_lo
    else:
        b_lo, b_hi, smallest, outside = usable_divisor(b_lo, b_hi)
    lo, hi = quotient_bounds(a_lo, a_hi, b_lo, b_hi)
    lo, hi = widened_by_ulps(lo, hi, DIVISION_ULPS, DIVISION_ULPS)
    if a.terms is None:
        return a.made(lo, hi, b, anything=outside)
    terms = Terms.of(
        a.terms.mag / smallest,
        lambda: reach_of(a.mag, a.terms) * np.maximum(1.0 / smallest, 1.0),
        a.terms,
        count=a.count,
    )
    moved = moved_out(lo, hi, DIVISION_ULPS * terms.step(), *_safe_signs(lo, hi, terms))
    return a.made(*moved, b, anything=outside, terms=terms)
