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
- a product in which one value is a factor several times keeps it whole: x·x·x·x·x, (x·x)·(x·x)·x
  and any other order have the band of a power, of the size of the result; so it has between other
  factors, as in k·x·x·x;
- a sum of n terms may be added up in an order in which all n − 1 sums are as large as the largest
  of them, whatever they were as written.

A plain band has no `mag` of its own (None: its own absolute value), and pays nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np

from shaderlab.bands.bounds import NO, BandT, Bounds, Terms, find_least, flush_gain_of, may_be_tiny
from shaderlab.bands.exact import negate, transpose
from shaderlab.bands.rounding import (
    LARGEST,
    RELATIVE_STEP,
    SMALLEST_NORMAL,
    Ends,
    Flags,
    Float64Array,
    add_outward,
    is_finite,
    is_power_of_two,
    widen_by_ulps,
)
from shaderlab.errors import FormulaError

LARGEST_DIVISOR = 2.0**126
DIVISION_ULPS = 2.5
# Terms whose sizes add up to the result's (but for roundings) have one sign, and keep it in any
# order.
UNCANCELLED = 1.0 - 2.0**-20
_LARGE = 2.0**32  # the product of three such numbers is finite
_FACTORS = 4  # of a product are remembered


@np.errstate(all="ignore")
def add(a: BandT, b: BandT) -> BandT:
    """a + b, correctly rounded in either direction."""
    a_lo, a_hi = a.apply_slack()
    b_lo, b_hi = b.apply_slack()
    lo, hi = add_outward((a_lo, a_hi), (b_lo, b_hi))
    if a_lo is a_hi and b_lo is b_hi and (lo == hi).all():
        hi = lo
    nan = None
    if not is_finite(lo, hi):
        nan = ((a_hi == np.inf) & (b_lo == -np.inf)) | ((a_lo == -np.inf) & (b_hi == np.inf))
    if not a.rules.rearrange:
        return a.derive(lo, hi, b, nan=nan)
    mag_a, mag_b = a.abs_sum, b.abs_sum
    terms = Terms.of(
        mag_a + mag_b,
        lambda: flush_gain_of(mag_a, a.terms) + flush_gain_of(mag_b, b.terms),
        a.terms,
        b.terms,
        count=a.count + b.count,
        signed=a.signed_with(b),
    )
    step = terms.step()
    if a.least_abs_sum <= 0.0 or b.least_abs_sum <= 0.0:
        # Adding an exact zero is no sum: no compiler keeps it.
        step = np.where((mag_a > 0.0) & (mag_b > 0.0), step, 0.0)
    if a.is_plain and b.is_plain:
        terms.slack = step
        return a.derive(lo, hi, b, nan=nan, terms=terms)
    if a.count > 1:
        step = step + (a.count - 1) * RELATIVE_STEP * mag_b
    if b.count > 1:
        step = step + (b.count - 1) * RELATIVE_STEP * mag_a

    # Operands of one sign, once settled, are further from zero than any rearrangement can err.
    low, high = lo - step, hi + step
    positive = low < 0.0
    if np.count_nonzero(positive):
        positive &= np.minimum(a.lo, b.lo) >= 0.0
    if np.count_nonzero(positive):
        of_one_sign = hi >= terms.abs_sum * UNCANCELLED if terms.signed is None else ~terms.signed
        positive &= (a_lo + b_lo >= step) | of_one_sign
        low = np.where(positive, 0.0, low)
    if find_least(a.hi) <= 0.0 and find_least(b.hi) <= 0.0:
        negative = (np.maximum(a.hi, b.hi) <= 0.0) & (high > 0.0)
        of_one_sign = -lo >= terms.abs_sum * UNCANCELLED if terms.signed is None else NO
        negative &= (a_hi + b_hi <= -step) | of_one_sign
        high = np.where(negative, 0.0, high)
    return a.derive(low, high, b, nan=nan, anything=terms.overflow(), terms=terms)


def subtract(a: BandT, b: BandT) -> BandT:
    """a - b, correctly rounded in either direction."""
    return add(a, negate(b))


def _move_out_by_terms(
    lo: Float64Array, hi: Float64Array, steps: float, terms: Terms, least: Float64Array | float
) -> Ends:
    """Bounds moved out by some steps of the terms: a sum times or over a plain value, once settled,
    keeps its sign when its terms are distributed, if its size is at least `least`."""
    step = terms.step()
    if steps != 1:
        step = steps * step
    low, high = lo - step, hi + step
    if terms.signed is not None:
        # Some of the terms may be tiny: flushing one of them may leave the other's sign.
        give = steps * terms.flush_error() if np.ndim(least) == 0 else np.inf
        low = np.where(lo >= 0.0, np.maximum(low, np.where(terms.signed, -give, 0.0)), low)
        return low, np.where(hi <= 0.0, np.minimum(high, give), high)
    positive = low < 0.0
    if np.count_nonzero(positive):
        positive &= lo >= 0.0
    if np.count_nonzero(positive):
        low = np.where(positive & terms.safe() & (hi >= least), 0.0, low)
    negative = hi <= 0.0
    if np.count_nonzero(negative):
        negative &= high > 0.0
    if np.count_nonzero(negative):
        high = np.where(negative & terms.safe() & (-lo >= least), 0.0, high)
    return low, high


@np.errstate(all="ignore")
def multiply(a: BandT, b: BandT) -> BandT:
    """a · b, correctly rounded in either direction; powers of one value are multiplied as such."""
    if a.base is b.base:
        return _multiply_powers(a, b)
    if a.terms is not None and b.terms is not None:
        powers = _collect_powers(a, b)
        if powers is not None:
            product: BandT = reduce(multiply, powers)
            return product
    for factor, other in ((a, b), (b, a)):
        few = factor.lo is factor.hi and factor.is_plain and factor.lo.size <= 16
        if few and is_power_of_two(factor.lo):
            return scale(other, factor)
    a_lo, a_hi = a.apply_slack()
    b_lo, b_hi = b.apply_slack()
    lo, hi, nan = _product((a_lo, a_hi), (b_lo, b_hi))
    if not a.rules.rearrange:
        return a.derive(lo, hi, b, nan=nan)
    mag_a, mag_b = a.abs_sum, b.abs_sum
    mag = mag_a * mag_b
    terms = Terms.of(
        mag,
        lambda: np.maximum(flush_gain_of(mag_a, a.terms) * flush_gain_of(mag_b, b.terms), 1.0),
        a.terms,
        b.terms,
        count=a.count * b.count,
        signed=a.signed_with(b),
    )
    if a.is_plain and b.is_plain:
        return a.derive(lo, hi, b, nan=nan, terms=terms)
    # (a + b)·(c + d) may become four products and three sums, each of the size of the terms.
    steps = 1 if a.is_plain or b.is_plain else max(3, terms.count - 1)
    bounds = _move_out_by_terms(lo, hi, steps, terms, mag * UNCANCELLED if steps > 1 else 0.0)
    made = a.derive(*bounds, b, nan=nan, anything=terms.overflow(), terms=terms)
    return _remember_factors(made, a, b)


@np.errstate(all="ignore")
def scale(a: BandT, scale: BandT) -> BandT:
    """a · 0 or a · ±2^k: nothing is rounded, so a pending slack stays pending."""
    lo, hi, nan = _product((a.lo, a.hi), (scale.lo, scale.lo))
    terms = _scale_terms(a, np.abs(scale.lo))
    if terms is not None:
        terms.signed = a.signed_with(scale)
    return _remember_factors(a.derive(lo, hi, scale, nan=nan, terms=terms), a, scale)


def _scale_terms(a: Bounds, factor: Float64Array) -> Terms | None:
    terms = a.terms
    if terms is None:
        scaled = a.abs_sum * factor
        # Small times large: each may meet another one of its kind first.
        large = np.maximum(a.abs_sum, 1.0) * np.maximum(factor, 1.0)
        may_overflow = a.rules.ranges and bool((large > _LARGE).any())
        if not a.rules.rearrange or not (may_overflow or may_be_tiny(scaled, find_least(scaled))):
            return None
        return Terms(scaled, flush_gain=large) if (large > 1.0).any() else None
    slack = flush_gain = None
    if terms.slack is not None:
        scaled = terms.slack * factor
        slack = np.where(scaled > 0.0, np.maximum(scaled, SMALLEST_NORMAL), 0.0)
    if terms.flush_gain is not None:
        flush_gain = terms.flush_gain * np.maximum(factor, 1.0)
    return Terms(terms.abs_sum * factor, slack, terms.count, flush_gain)


def _remember_factors(product: BandT, a: Bounds, b: Bounds) -> BandT:
    own, other = a.factors, b.factors
    few = len(own) + len(other) <= _FACTORS and own.keys().isdisjoint(other)
    if product.terms is not None and few:
        product.terms.factors, product.terms.product = own | other, product.lo
    return product


def _collect_powers(a: Bounds, b: Bounds) -> list[Any] | None:
    """The factors of a · b, powers of one value as one; None where the two share no value, or a
    power overflows: then the order counts."""
    found = dict(a.factors)
    for base, power in b.factors.items():
        found[base] = _multiply_powers(found[base], power) if base in found else power
    shared = len(found) < len(a.factors) + len(b.factors)
    finite = shared and all(is_finite(power.lo, power.hi) for power in found.values())
    return list(found.values()) if finite else None


@np.errstate(all="ignore")
def _multiply_powers(a: BandT, b: BandT) -> BandT:
    """a · b for two powers of one value, the same in whatever order they are multiplied: no
    compiler expands (b + c)², so no slack is paid, and 0 never meets infinity."""
    lo, hi = product_bounds(a.lo, a.hi, b.lo, b.hi, np.fmin, np.fmax)
    if a is b and lo is not hi:
        lo = np.maximum(lo, 0.0)
    if not a.rules.rearrange:
        return a.derive(lo, hi, b)
    mag_a, mag_b = a.abs_sum, b.abs_sum
    terms = Terms.of(
        np.minimum(np.maximum(-lo, hi), LARGEST),
        lambda: np.maximum(flush_gain_of(mag_a, a.terms) * flush_gain_of(mag_b, b.terms), 1.0),
        a.terms,
        b.terms,
        signed=lo < 0.0 if a.rules.ranges else None,
    )
    terms.base = a.base
    if a is b is a.base and (a.is_plain or lo is hi):
        return a.derive(lo, hi, terms=terms)
    low, high = lo - terms.step(), hi + terms.step()
    low, high = np.where(lo >= 0.0, np.maximum(low, 0.0), low), np.where(hi > 0.0, high, 0.0)
    return a.derive(low, high, b, terms=terms)


@np.errstate(all="ignore")
def divide(a: BandT, b: BandT) -> BandT:
    """a / b within 2.5 ULP where 2^-126 ≤ |b| ≤ 2^126; anything elsewhere."""
    a_lo, a_hi = a.apply_slack()
    b_lo, b_hi, smallest, outside = _usable_divisor(b.lo, b.hi)
    lo, hi = _quotient_bounds(a_lo, a_hi, b_lo, b_hi)
    lo, hi = widen_by_ulps(lo, hi, DIVISION_ULPS, DIVISION_ULPS)
    if a.terms is None:
        return a.derive(lo, hi, b, anything=outside)
    terms = Terms.of(
        a.terms.abs_sum / smallest,
        lambda: flush_gain_of(a.abs_sum, a.terms) * np.maximum(1.0 / smallest, 1.0),
        a.terms,
        count=a.count,
        signed=a.signed_with(b),
    )
    bounds = _move_out_by_terms(lo, hi, DIVISION_ULPS, terms, 0.0)
    overflow = terms.overflow()
    anything = outside if overflow is None else outside | overflow
    return a.derive(*bounds, b, anything=anything, terms=terms)


def _product(a: Ends, b: Ends) -> tuple[Float64Array, Float64Array, Flags | None]:
    """The bounds of a product, and where it may be NaN, if anywhere: of 0 times infinity."""
    lo, hi = product_bounds(*a, *b)
    if is_finite(lo, hi):
        return lo, hi, None
    return *product_bounds(*a, *b, np.fmin, np.fmax), _zero_times_infinity(*a, *b)


def product_bounds(
    a_lo: Float64Array,
    a_hi: Float64Array,
    b_lo: Float64Array,
    b_hi: Float64Array,
    least: np.ufunc = np.minimum,
    greatest: np.ufunc = np.maximum,
) -> Ends:
    """The hull of the products of the ends, NaN where 0 meets infinity, unless `least` and
    `greatest` leave it out. Exact: 24 + 24 bits fit into float64."""
    if a_lo is a_hi:
        a_lo, a_hi, b_lo, b_hi = b_lo, b_hi, a_lo, a_hi
    if a_lo is a_hi:
        lo = a_lo * b_lo
        return lo, lo
    if find_least(a_lo) >= 0.0 and find_least(b_lo) >= 0.0:
        lo, hi = a_lo * b_lo, a_hi * b_hi
        if is_finite(lo, hi):
            return lo, hi
    ends = (b_lo,) if b_lo is b_hi else (b_lo, b_hi)
    products = [x * y for x in (a_lo, a_hi) for y in ends]
    return reduce(least, products), reduce(greatest, products)


def _zero_times_infinity(
    a_lo: Float64Array, a_hi: Float64Array, b_lo: Float64Array, b_hi: Float64Array
) -> Flags:
    a_zero = (a_lo <= 0.0) & (a_hi >= 0.0)
    b_zero = (b_lo <= 0.0) & (b_hi >= 0.0)
    a_infinite = np.isinf(a_lo) | np.isinf(a_hi)
    b_infinite = np.isinf(b_lo) | np.isinf(b_hi)
    found: Flags = (a_zero & b_infinite) | (b_zero & a_infinite)
    return found


def _usable_divisor(
    b_lo: Float64Array, b_hi: Float64Array
) -> tuple[Float64Array, Float64Array, Float64Array, Flags]:
    """The divisor's bounds and its smallest absolute value, 1 where it is outside the range that
    has a precision; and where that is."""
    if find_least(b_lo) >= SMALLEST_NORMAL and b_hi.max(initial=0.0) <= LARGEST_DIVISOR:
        return b_lo, b_hi, b_lo, NO
    low, high = np.abs(b_lo), np.abs(b_hi)
    smallest = np.minimum(low, high)
    far = (smallest < SMALLEST_NORMAL) | (np.maximum(low, high) > LARGEST_DIVISOR)
    outside = far | ((b_lo <= 0.0) & (b_hi >= 0.0))
    if not outside.any():
        return b_lo, b_hi, smallest, outside
    usable_lo = np.where(outside, 1.0, b_lo)
    usable_hi = usable_lo if b_lo is b_hi else np.where(outside, 1.0, b_hi)
    return usable_lo, usable_hi, np.where(outside, 1.0, smallest), outside


def _quotient_bounds(
    a_lo: Float64Array, a_hi: Float64Array, b_lo: Float64Array, b_hi: Float64Array
) -> Ends:
    """The hull of the quotients of the ends; no divisor is zero."""
    if a_lo is a_hi and b_lo is b_hi:
        lo = a_lo / b_lo
        return lo, lo
    if find_least(a_lo) >= 0.0 and find_least(b_lo) >= 0.0:
        return a_lo / b_hi, a_hi / b_lo
    ends = (a_lo,) if a_lo is a_hi else (a_lo, a_hi), (b_lo,) if b_lo is b_hi else (b_lo, b_hi)
    quotients = [x / y for x in ends[0] for y in ends[1]]
    return reduce(np.minimum, quotients), reduce(np.maximum, quotients)


@np.errstate(all="ignore")
def sum_last(a: BandT) -> BandT:
    """The sum over the last axis (kept, with size 1), its terms added in any order."""
    if a.shape[-1] == 1:
        return a
    a_lo, a_hi = a.apply_slack()
    lo, hi = reduce(
        add_outward, ((a_lo[..., j, None], a_hi[..., j, None]) for j in range(a.shape[-1]))
    )
    nan = None
    if not is_finite(lo, hi):
        rises = (a_hi == np.inf).sum(axis=-1, keepdims=True)
        falls = (a_lo == -np.inf).sum(axis=-1, keepdims=True)
        both = ((a_hi == np.inf) & (a_lo == -np.inf)).sum(axis=-1, keepdims=True)
        nan = rises * falls > both
    sizes = a.abs_sum
    mag = _over_last(sizes, np.add)
    # The terms of the products are not counted: no compiler expands a dot product's arguments.
    terms = Terms.of(
        mag,
        lambda: _over_last(np.broadcast_to(flush_gain_of(sizes, a.terms), sizes.shape), np.add),
        a.terms,
        count=a.shape[-1],
        signed=_over_last(a.signed | np.zeros(a.shape, np.bool_), np.logical_or)
        if a.rules.ranges
        else None,
    )
    step = terms.step()
    count: Any = float(a.shape[-1])
    no_zeros = a.least_abs_sum > 0.0
    if not no_zeros:
        count = _over_last((sizes > 0.0).astype(np.float64), np.add)
    # Each partial sum may lose a step, but the last one, which `derive` rounds, only where a factor
    # that all products have is taken out.
    rounded = 1.0 if a.rules.rearrange and not a.is_plain else 2.0
    if a.shape[-1] > rounded:
        between = np.maximum(count - rounded, 0.0) * step
        low, high = lo - between, hi + between
        positive, negative = (low < 0.0), (high > 0.0)
        if np.count_nonzero(positive):
            low = np.where(positive & _over_last(a_lo >= 0.0, np.logical_and), 0.0, low)
        if np.count_nonzero(negative):
            high = np.where(negative & _over_last(a_hi <= 0.0, np.logical_and), 0.0, high)
        lo, hi = low, high
    if not a.rules.rearrange:
        return a.join_flags_over_last().derive(lo, hi, nan=nan)
    if a.is_plain:
        terms.slack = step if no_zeros else np.where(count >= 2.0, step, 0.0)
    joined = a.join_flags_over_last()
    return joined.derive(lo, hi, nan=nan, anything=terms.overflow(), terms=terms)


def _over_last(values: Any, join: Callable[[Any, Any], Any]) -> Any:
    """The components along the last axis, which stays with size 1, joined from first to last.

    They are taken one by one, because NumPy's reductions of so few numbers spend their time
    between them.
    """
    total = values[..., 0:1]
    for j in range(1, values.shape[-1]):
        total = join(total, values[..., j : j + 1])
    return total


def dot(a: BandT, b: BandT) -> BandT:
    """The sum of the products over the last axis (kept, with size 1), in any order."""
    return sum_last(multiply(a, b))


def times_vector(m: BandT, v: BandT) -> BandT:
    """m · v for matrices (…, r, c) and vectors (…, c): vectors (…, r)."""
    if m.ndim < 2 or v.shape[-1] != m.shape[-1]:
        raise FormulaError(f"no product of a matrix {m.shape} and a vector {v.shape}")
    products = multiply(m, v[..., None, :])
    return sum_last(products)[..., 0]


def times_matrix(a: BandT, b: BandT) -> BandT:
    """a · b for matrices (…, r, k) and (…, k, c): matrices (…, r, c)."""
    if a.ndim < 2 or b.ndim < 2 or a.shape[-1] != b.shape[-2]:
        raise FormulaError(f"no product of matrices {a.shape} and {b.shape}")
    products = multiply(a[..., :, None, :], transpose(b)[..., None, :, :])
    return sum_last(products)[..., 0]


def matmul(a: BandT, b: BandT) -> BandT:
    """NumPy's `a @ b`: b is a vector if it has one axis, or if its rows don't fit a's columns."""
    if b.ndim == 1 or (b.shape[-1] == a.shape[-1] != b.shape[-2]):
        return times_vector(a, b)
    if a.ndim == 1:
        return times_vector(transpose(b), a)
    return times_matrix(a, b)
