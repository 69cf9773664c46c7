"""Sums, products and quotients of bands, with what rearranging them may add.

Every band carries `mag`, the sum of the absolute values of the terms it is made of. A compiler
that turns a·b + a·c into a·(b + c), or back, rounds at the size of the terms, not of their sum,
and rounds where the formula as written happens to be exact. So:

- one sum or product of plain values (inputs, constants, what functions return) is rounded once;
  nothing can be rearranged yet, but it has a `mag` from now on;
- a sum of two plain values remembers one step of `mag` as its `slack`, paid as soon as it is
  added to or multiplied with something (a·(b + c) may become a·b + a·c);
- each further sum, product or quotient rounds by a step of its `mag` more, a product of two such
  values by three (or as many as it has sums, once distributed);
- a sum of n terms may be added up in an order in which all n − 1 sums are as large as the largest
  of them, whatever they were as written.

A plain band has no `mag` of its own (None: its own absolute value), and pays nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands.rounding import (
    LARGEST,
    RELATIVE_STEP,
    SMALLEST_NORMAL,
    Flags,
    Floats,
    is_power_of_two,
    two_sum,
    widened_by_ulps,
)
from shaderlab.bands.terms import Terms, combined, is_tiny, reach_of

if TYPE_CHECKING:
    from shaderlab.bands.band import Band

DIVISION_ULPS = 2.5
LARGEST_DIVISOR = 2.0**126
# Terms whose sizes add up to the result's (but for roundings) have one sign, and keep it in any
# order.
UNCANCELLED = 1.0 - 2.0**-20


@np.errstate(all="ignore")
def add(a: Band, b: Band) -> Band:
    """a + b, correctly rounded in either direction."""
    a_lo, a_hi = a.settled()
    b_lo, b_hi = b.settled()
    lo, lost_lo = two_sum(a_lo, b_lo)
    if a_lo is a_hi and b_lo is b_hi:
        hi, lost_hi = lo, lost_lo
    else:
        hi, lost_hi = two_sum(a_hi, b_hi)
    nan = None
    if not (np.isfinite(lo).all() and np.isfinite(hi).all()):
        nan = ((a_hi == np.inf) & (b_lo == -np.inf)) | ((a_lo == -np.inf) & (b_hi == np.inf))
    if not a.rules.rearrange:
        return a.made(lo, hi, b, residue=(lost_lo, lost_hi), nan=nan)
    mag_a, mag_b = a.mag, b.mag
    mag = mag_a + mag_b
    reach = None
    if is_tiny(mag, a.terms, b.terms):
        reach = reach_of(mag_a, a.terms) + reach_of(mag_b, b.terms)
    terms = Terms(mag, None, a.count + b.count, reach)
    # Adding an exact zero is no sum: no compiler keeps it.
    step = np.where((mag_a > 0.0) & (mag_b > 0.0), terms.step(), 0.0)
    if a.is_plain and b.is_plain:
        terms = Terms(mag, step, terms.count, reach)
    else:
        if a.count > 1:
            step = step + (a.count - 1) * RELATIVE_STEP * mag_b
        if b.count > 1:
            step = step + (b.count - 1) * RELATIVE_STEP * mag_a
        uncancelled = mag * UNCANCELLED
        not_negative = (a.lo >= 0.0) & (b.lo >= 0.0) & ((a_lo + b_lo >= step) | (hi >= uncancelled))
        not_positive = (
            (a.hi <= 0.0) & (b.hi <= 0.0) & ((a_hi + b_hi <= -step) | (-lo >= uncancelled))
        )
        lo, hi = _moved_out(lo, hi, step, not_negative, not_positive)
    return a.made(lo, hi, b, residue=(lost_lo, lost_hi), nan=nan, terms=terms)


def _moved_out(
    lo: Floats, hi: Floats, step: Floats, not_negative: Flags, not_positive: Flags
) -> tuple[Floats, Floats]:
    """Bounds moved out by a step, which does not take a result past zero that can't have its sign.

    Operands of one sign, once settled, are further from zero than any rearrangement can err.
    """
    out_lo, out_hi = lo - step, hi + step
    return (
        np.where(not_negative, np.maximum(out_lo, 0.0), out_lo),
        np.where(not_positive, np.minimum(out_hi, 0.0), out_hi),
    )


def _signs(lo: Floats, hi: Floats, terms: Terms) -> tuple[Flags, Flags]:
    """Where a settled sum times or over a plain value keeps its sign, its terms distributed."""
    safe = terms.safe()
    return (lo >= 0.0) & safe, (hi <= 0.0) & safe


def _product_bounds(
    a_lo: Floats, a_hi: Floats, b_lo: Floats, b_hi: Floats
) -> tuple[Floats, Floats]:
    """The hull of the products of the ends. Exact: 24 + 24 bits fit into float64."""
    if b_lo is b_hi:
        a_lo, a_hi, b_lo, b_hi = b_lo, b_hi, a_lo, a_hi
    first = a_lo * b_lo
    if b_lo is b_hi:
        if a_lo is a_hi:
            return first, first
        second = a_hi * b_lo
        return np.fmin(first, second), np.fmax(first, second)
    second = a_lo * b_hi
    lo, hi = np.fmin(first, second), np.fmax(first, second)
    if a_lo is a_hi:
        return lo, hi
    third, fourth = a_hi * b_lo, a_hi * b_hi
    # fmin, fmax: 0·inf beside finite products adds a NaN, not a bound.
    return np.fmin(lo, np.fmin(third, fourth)), np.fmax(hi, np.fmax(third, fourth))


def _zero_times_infinity(a_lo: Floats, a_hi: Floats, b_lo: Floats, b_hi: Floats) -> Flags:
    a_zero = (a_lo <= 0.0) & (a_hi >= 0.0)
    b_zero = (b_lo <= 0.0) & (b_hi >= 0.0)
    a_infinite = np.isinf(a_lo) | np.isinf(a_hi)
    b_infinite = np.isinf(b_lo) | np.isinf(b_hi)
    found: Flags = (a_zero & b_infinite) | (b_zero & a_infinite)
    return found


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
            return _scaled(other, scale)
    a_lo, a_hi = a.settled()
    b_lo, b_hi = b.settled()
    lo, hi = _product_bounds(a_lo, a_hi, b_lo, b_hi)
    nan = None
    if not (np.isfinite(lo).all() and np.isfinite(hi).all()):
        nan = _zero_times_infinity(a_lo, a_hi, b_lo, b_hi)
    if not a.rules.rearrange:
        return a.made(lo, hi, b, nan=nan)
    mag_a, mag_b = a.mag, b.mag
    mag = mag_a * mag_b
    reach = None
    if is_tiny(mag, a.terms, b.terms):
        reach = np.maximum(reach_of(mag_a, a.terms) * reach_of(mag_b, b.terms), 1.0)
    terms = Terms(mag, None, a.count * b.count, reach)
    if a.is_plain and b.is_plain:
        return a.made(lo, hi, b, nan=nan, terms=terms)
    # (a + b)·(c + d) may become four products and three sums, each of the size of the terms.
    steps = 1 if a.is_plain or b.is_plain else max(3, terms.count - 1)
    not_negative, not_positive = _signs(lo, hi, terms)
    if steps > 1:
        not_negative &= hi >= mag * UNCANCELLED
        not_positive &= -lo >= mag * UNCANCELLED
    lo, hi = _moved_out(lo, hi, steps * terms.step(), not_negative, not_positive)
    return a.made(lo, hi, b, nan=nan, terms=terms)


def _scaled(a: Band, scale: Band) -> Band:
    """a · ±2^k: nothing is rounded, so a pending slack stays pending."""
    lo, hi = _product_bounds(a.lo, a.hi, scale.lo, scale.lo)
    nan = None
    if not (np.isfinite(lo).all() and np.isfinite(hi).all()):
        nan = _zero_times_infinity(a.lo, a.hi, scale.lo, scale.lo)
    return a.made(lo, hi, scale, nan=nan, terms=_scaled_terms(a, np.abs(scale.lo)))


def _scaled_terms(a: Band, factor: Floats) -> Terms | None:
    terms = a.terms
    if terms is None:
        if not a.rules.rearrange or not is_tiny(a.mag * factor):
            return None
        # Small times large: the small one may meet another small one first.
        large = np.maximum(a.mag, 1.0) * np.maximum(factor, 1.0)
        return Terms(a.mag * factor, reach=large) if (large > 1.0).any() else None
    slack = reach = None
    if terms.slack is not None:
        scaled = terms.slack * factor
        slack = np.where(scaled > 0.0, np.maximum(scaled, SMALLEST_NORMAL), 0.0)
    if terms.reach is not None:
        reach = terms.reach * np.maximum(factor, 1.0)
    return Terms(terms.mag * factor, slack, terms.count, reach)


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
    reach = None
    if is_tiny(mag, a.terms):
        reach = np.maximum(reach_of(a.mag, a.terms) ** 2, 1.0)
    return Terms(mag, reach=reach)


@np.errstate(all="ignore")
def divide(a: Band, b: Band) -> Band:
    """a / b within 2.5 ULP where 2^-126 ≤ |b| ≤ 2^126; anything elsewhere."""
    a_lo, a_hi = a.settled()
    smallest = np.minimum(np.abs(b.lo), np.abs(b.hi))
    outside = (
        (smallest < SMALLEST_NORMAL)
        | (np.maximum(np.abs(b.lo), np.abs(b.hi)) > LARGEST_DIVISOR)
        | ((b.lo <= 0.0) & (b.hi >= 0.0))
    )
    exact_divisor = b.lo is b.hi
    b_lo, b_hi = b.lo, b.hi
    if outside.any():
        b_lo = np.where(outside, 1.0, b_lo)
        b_hi = b_lo if exact_divisor else np.where(outside, 1.0, b_hi)
        smallest = np.where(outside, 1.0, smallest)
    low, high = a_lo / b_lo, a_hi / b_lo
    lo, hi = np.minimum(low, high), np.maximum(low, high)
    if not exact_divisor:
        low, high = a_lo / b_hi, a_hi / b_hi
        lo, hi = np.minimum(lo, np.minimum(low, high)), np.maximum(hi, np.maximum(low, high))
    lo, hi = widened_by_ulps(lo, hi, DIVISION_ULPS, DIVISION_ULPS)
    if a.terms is None:
        return a.made(lo, hi, b, anything=outside)
    mag = a.terms.mag / smallest
    reach = None
    if is_tiny(mag, a.terms):
        reach = reach_of(a.mag, a.terms) * np.maximum(1.0 / smallest, 1.0)
    terms = Terms(mag, None, a.count, reach)
    lo, hi = _moved_out(lo, hi, DIVISION_ULPS * terms.step(), *_signs(lo, hi, terms))
    return a.made(lo, hi, b, anything=outside, terms=terms)


@np.errstate(all="ignore")
def sum_last(a: Band) -> Band:
    """The sum over the last axis (kept, with size 1), its terms added in any order."""
    if a.shape[-1] == 1:
        return a
    a_lo, a_hi = a.settled()
    lo, lost_lo = _running_sum(a_lo)
    hi, lost_hi = (lo, lost_lo) if a_lo is a_hi else _running_sum(a_hi)
    nan = None
    if not (np.isfinite(lo).all() and np.isfinite(hi).all()):
        rises = (a_hi == np.inf).sum(axis=-1, keepdims=True)
        falls = (a_lo == -np.inf).sum(axis=-1, keepdims=True)
        both = ((a_hi == np.inf) & (a_lo == -np.inf)).sum(axis=-1, keepdims=True)
        nan = rises * falls > both
    sizes = a.mag
    mag = _total(sizes)
    reach = None
    if is_tiny(mag, a.terms):
        reach = _total(np.broadcast_to(reach_of(sizes, a.terms), sizes.shape))
    # The terms of the products are not counted: no compiler expands what a dot product is given.
    terms = Terms(mag, None, a.shape[-1], reach)
    count = _total((sizes > 0.0).astype(np.float64))
    step = terms.step()
    # All partial sums but the last, which `made` rounds, may each lose a step.
    between = np.maximum(count - 2.0, 0.0) * step
    lo, hi = _moved_out(lo, hi, between, _everywhere(a_lo >= 0.0), _everywhere(a_hi <= 0.0))
    slack = np.where(count >= 2.0, step, 0.0)
    return a.flags_over_last().made(
        lo,
        hi,
        residue=(lost_lo, lost_hi),
        nan=nan,
        terms=Terms(mag, slack, terms.count, reach) if a.rules.rearrange else None,
    )


def _components(values: Any) -> list[Any]:
    """The components along the last axis, which stays with size 1. Taken one by one, because
    NumPy's reductions of so few numbers spend their time between them."""
    return [values[..., j : j + 1] for j in range(values.shape[-1])]


def _total(values: Floats) -> Floats:
    """The sum over the last axis, from the first component to the last."""
    first, *rest = _components(values)
    total: Floats = first
    for one in rest:
        total = total + one
    return total


def _everywhere(found: Flags) -> Flags:
    """Where all components have it."""
    first, *rest = _components(found)
    every: Flags = first
    for one in rest:
        every = every & one
    return every


def _running_sum(values: Floats) -> tuple[Floats, Floats]:
    total = values[..., 0:1]
    lost = np.zeros(1)
    for j in range(1, values.shape[-1]):
        total, residue = two_sum(total, values[..., j : j + 1])
        lost = lost + residue
    return total, lost


@np.errstate(all="ignore")
def union(a: Band, b: Band) -> Band:
    """What either of two legal ways to compute one value may give."""
    lo, hi = np.minimum(a.lo, b.lo), np.maximum(a.hi, b.hi)

    def larger(values: list[Floats]) -> Floats:
        return np.maximum(*values)

    return a.made(lo, hi, b, terms=combined([(a.mag, a.terms), (b.mag, b.terms)], larger))
