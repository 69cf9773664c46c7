"""Roots, exponentials and trigonometry of bands, with the errors that the tables allow.

Source: the OpenGL Shading Language 4.60 (Khronos), 4.7.1 "Range and Precision"; the Vulkan
specification (Khronos), "Precision and Operation of SPIR-V Instructions".
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np

from shaderlab.bands import arithmetic, exact
from shaderlab.bands.band import Band
from shaderlab.bands.bounds import Terms, flush_gain_of
from shaderlab.bands.rounding import (
    FLOAT64_ERROR,
    LARGEST,
    RELATIVE_STEP,
    SMALLEST_DENORMAL,
    SMALLEST_NORMAL,
    Ends,
    Flags,
    Float64Array,
    round_down,
    round_outward,
    round_up,
    ulp,
    widen_by_ulps,
)

INVERSESQRT_ULPS = 2.0
ARC_ULPS = 4096.0
TRIG_ERROR = 2.0**-11
# asin and acos may err as much as sin and cos: Vulkan's 4096 ULP shrink with the angle, but GLSL
# alone promises nothing, and Mesa's polynomial for OpenGL is off by 2^-12 around ½.
ARC_ERROR = TRIG_ERROR
LOG_ERROR_NEAR_ONE = 2.0**-21
LOG_ULPS = 3.0
# How many operations of a mix may each flush a denormal.
_MIX_FLUSHED = 8.0
# float32(π) lies above π; a formula that says π means the range to include it.
_PI_32 = float(np.float32(np.pi))


def _evaluate(a: Band, function: Any) -> Ends:
    lo: Float64Array = function(a.lo)
    return lo, lo if a.lo is a.hi else function(a.hi)


@np.errstate(all="ignore")
def inversesqrt(a: Band) -> Band:
    """1/√a within 2 ULP; a ≤ 0 is undefined."""
    lo, hi = _inversesqrt_bounds(a.lo, a.hi)
    return a.derive(lo, hi, anything=a.lo <= 0.0)


def _inversesqrt_bounds(a_lo: Float64Array, a_hi: Float64Array) -> Ends:
    lo = 1.0 / np.sqrt(np.maximum(a_hi, 0.0))
    hi = lo if a_lo is a_hi else 1.0 / np.sqrt(np.maximum(a_lo, 0.0))
    return widen_by_ulps(lo, hi, INVERSESQRT_ULPS, INVERSESQRT_ULPS)


@np.errstate(all="ignore")
def sqrt(a: Band) -> Band:
    """√a as 1/inversesqrt(a), so 2 ULP and then 2.5; a < 0 is undefined, and √0 is 0."""
    root_lo, root_hi = _inversesqrt_bounds(a.lo, a.hi)
    lo, hi = 1.0 / round_up(root_hi), 1.0 / round_down(root_lo)
    ulps = arithmetic.DIVISION_ULPS
    lo, hi = widen_by_ulps(lo, np.minimum(hi, LARGEST), ulps, ulps)
    hi = np.where(a.hi <= 0.0, 0.0, np.where(a.hi == np.inf, np.inf, hi))
    return a.derive(lo, hi, anything=a.lo < 0.0)


@np.errstate(all="ignore")
def exponential(a: Band, function: Any) -> Band:
    """exp or exp2 within (3 + 2·|a|) ULP, and not negative."""
    lo, hi = _evaluate(a, function)
    lo = np.minimum(lo, LARGEST)  # a compiler that takes log(exp(x)) for x never overflows
    ulps_lo = 3.0 + 2.0 * np.minimum(np.abs(a.lo), LARGEST)
    ulps_hi = 3.0 + 2.0 * np.minimum(np.abs(a.hi), LARGEST)
    # Subnormal results have one ULP, so the least of them may err most.
    least = np.where(lo > 0.0, lo + ulps_lo * ulp(lo), 0.0)
    lo, hi = widen_by_ulps(lo, hi, ulps_lo, ulps_hi)
    hi = np.maximum(hi, least)
    # The true value is positive however small: the last step above zero stays legal.
    return a.derive(np.maximum(lo, 0.0), np.maximum(hi, SMALLEST_DENORMAL))


@np.errstate(all="ignore")
def logarithm(a: Band, function: Any) -> Band:
    """log or log2: 2^-21 absolute where ½ ≤ a ≤ 2, 3 ULP elsewhere; a ≤ 0 is undefined."""
    low = np.maximum(a.lo, 0.0)
    lo, hi = _log_bounds(low, low if a.lo is a.hi else np.maximum(a.hi, 0.0), function)
    return a.derive(lo, hi, anything=a.lo <= 0.0)


def _log_bounds(a_lo: Float64Array, a_hi: Float64Array, function: Any) -> Ends:
    lo: Float64Array = function(a_lo)
    hi: Float64Array = lo if a_lo is a_hi else function(a_hi)
    error_lo = np.where((a_lo >= 0.5) & (a_lo <= 2.0), LOG_ERROR_NEAR_ONE, LOG_ULPS * ulp(lo))
    if a_lo is a_hi:
        error = error_lo
    else:
        error_hi = np.where((a_hi >= 0.5) & (a_hi <= 2.0), LOG_ERROR_NEAR_ONE, LOG_ULPS * ulp(hi))
        error = np.maximum(error_lo, error_hi)
        # Just inside ½ and 2 more is allowed than just outside.
        crosses = ((a_lo < 0.5) & (a_hi >= 0.5)) | ((a_lo <= 2.0) & (a_hi > 2.0))
        error = np.where(crosses, np.maximum(error, LOG_ERROR_NEAR_ONE), error)
    most = error + FLOAT64_ERROR * np.minimum(np.maximum(np.abs(lo), np.abs(hi)), LARGEST)
    return lo - most, hi + most


@np.errstate(all="ignore")
def power(x: Band, y: Band) -> Band:
    """x^y as exp2(y·log2 x). Undefined for x < 0, and for x = 0 with y ≤ 0.

    At x = 0, y > 0 the result is exp2(-inf) = 0; because a denormal x is as good as zero, all of
    x in [0, 2^-126] is taken together. SwiftShader's log2(0) is some -139: no end, but far below.
    """
    x_lo = np.maximum(x.lo, SMALLEST_NORMAL)
    x_hi = x_lo if x.lo is x.hi else np.maximum(x.hi, SMALLEST_NORMAL)
    logarithms = x.derive(*_log_bounds(x_lo, x_hi, np.log2))
    result = exponential(arithmetic.multiply(y, logarithms), np.exp2)
    reaches_zero = x.lo < SMALLEST_NORMAL
    if not reaches_zero.any():
        return result
    undefined = (x.lo < 0.0) | (reaches_zero & (y.lo <= 0.0))
    lo = np.where(reaches_zero, 0.0, result.lo)
    if not undefined.any():
        return result.derive_exact(lo, result.hi)
    return result.derive(lo, result.hi, anything=undefined)


def _contains_turn(lo: Float64Array, hi: Float64Array, phase: float) -> Flags:
    """Whether phase + 2πk lies between the bounds for some integer k."""
    turns: Flags = np.floor((hi - phase) / (2 * np.pi)) >= np.ceil((lo - phase) / (2 * np.pi))
    return turns


@np.errstate(all="ignore")
def wave(a: Band, function: Any, crest: float) -> Band:
    """sin (crest π/2) or cos (crest 0): 2^-11 absolute in [-π, π], beyond as the rules say."""
    first, last = _evaluate(a, function)
    lo, hi = np.minimum(first, last), np.maximum(first, last)
    if a.lo is not a.hi:
        hi = np.where(_contains_turn(a.lo, a.hi, crest), 1.0, hi)
        lo = np.where(_contains_turn(a.lo, a.hi, crest + np.pi), -1.0, lo)
    size = np.maximum(np.abs(a.lo), np.abs(a.hi))
    outside = ~(size <= _PI_32)
    error: Any = TRIG_ERROR
    if a.rules.trig_outside == "scaled":
        error = np.where(outside, size * 2.0**-12, TRIG_ERROR)
        outside = ~np.isfinite(size)
    return a.derive(lo - error, hi + error, anything=outside)


@np.errstate(all="ignore")
def arctangent(a: Band) -> Band:
    """atan(a) within 4096 ULP."""
    lo, hi = widen_by_ulps(*_evaluate(a, np.arctan), ARC_ULPS, ARC_ULPS)
    return a.derive(lo, hi)


@np.errstate(all="ignore")
def arctangent2(y: Band, x: Band) -> Band:
    """atan(y, x) within 4096 ULP; undefined at the origin. On the cut either ±π is legal."""
    lo, hi = _angle_bounds(y.lo, y.hi, x.lo, x.hi)
    on_cut = (y.lo <= 0.0) & (y.hi >= 0.0) & (x.lo < 0.0)
    lo, hi = np.where(on_cut, -np.pi, lo), np.where(on_cut, np.pi, hi)
    lo, hi = widen_by_ulps(lo, hi, ARC_ULPS, ARC_ULPS)
    origin = (y.lo <= 0.0) & (y.hi >= 0.0) & (x.lo <= 0.0) & (x.hi >= 0.0)
    return y.derive(lo, hi, x, anything=origin)


def _angle_bounds(
    y_lo: Float64Array, y_hi: Float64Array, x_lo: Float64Array, x_hi: Float64Array
) -> Ends:
    """The angles of a box that the cut does not cross: monotone along each edge."""
    corners = [np.arctan2(y + 0.0, x) for y in (y_lo, y_hi) for x in (x_lo, x_hi)]
    return reduce(np.minimum, corners), reduce(np.maximum, corners)


def _arc(a: Band, angles: Callable[[Band], Ends]) -> Band:
    """An angle in a right triangle, made of the leg a and the other one, √(1 - a²)."""
    rest = arithmetic.add(a.lift(1.0), exact.negate(arithmetic.multiply(a, a)))
    lo, hi = angles(sqrt(exact.maximum_of(rest, a.lift(0.0))))
    wide_lo, wide_hi = widen_by_ulps(lo, hi, ARC_ULPS, ARC_ULPS)
    lo, hi = np.minimum(wide_lo, lo - ARC_ERROR), np.maximum(wide_hi, hi + ARC_ERROR)
    return a.derive(lo, hi, anything=(a.lo < -1.0) | (a.hi > 1.0))


@np.errstate(all="ignore")
def arcsine(a: Band) -> Band:
    """asin(a): as atan(a, √(1 - a²)), 4096 ULP or 2^-11 absolute; undefined for |a| > 1."""
    return _arc(a, lambda leg: _angle_bounds(a.lo, a.hi, leg.lo, leg.hi))


@np.errstate(all="ignore")
def arccosine(a: Band) -> Band:
    """acos(a): as atan(√(1 - a²), a), 4096 ULP or 2^-11 absolute; undefined for |a| > 1."""
    return _arc(a, lambda leg: _angle_bounds(leg.lo, leg.hi, a.lo, a.hi))


@np.errstate(all="ignore")
def cut_to_ends(found: Band, x: Band, y: Band, a: Band) -> Band:
    """The band `found` of mix(x, y, a) by its operations, cut to what it may be at most.

    Without roundings mix is linear in each of x, y and a, so it is greatest and least at ends of
    their bands. What roundings add is `_rounding_loss`.
    """
    terms = _mix_terms(found, x, y, a)
    if found.lo is found.hi:
        return found.derive_exact(found.lo, found.lo, terms=terms)
    sides = [_mix_at(x.apply_slack(), y.apply_slack(), end) for end in a.apply_slack()]
    lost = _rounding_loss(found, x, y, a)
    least = np.minimum(sides[0][0], sides[1][0]) - lost
    most = np.maximum(sides[0][1], sides[1][1]) + lost
    lo, hi = round_outward(least, most, found.rules.flush)
    # Where a bound is NaN, of infinity times 0, the operations' own stays.
    return found.derive_exact(np.fmax(found.lo, lo), np.fmin(found.hi, hi), terms=terms)


def _rounding_loss(found: Band, x: Band, y: Band, a: Band) -> Float64Array:
    """What the roundings of a mix may add up to, in whichever of its forms.

    x·(1 - a) + y·a rounds the difference, two products and a sum; x + (y - x)·a a difference, a
    product and a sum; x - x·a + y·a two products and two sums. Sums that x, y and a are themselves
    may be taken apart for it, and added in any order.
    """
    both = (x.abs_sum + y.abs_sum) * _largest_size(*a.apply_slack())
    sums = 3.0 * (x.abs_sum + both) + (x.count + y.count - 2) * both
    weights = x.abs_sum * (1.0 + a.abs_sum) + y.abs_sum * a.abs_sum
    lost: Float64Array = np.maximum(
        RELATIVE_STEP * (sums + weights), _MIX_FLUSHED * SMALLEST_NORMAL
    )
    if found.terms is not None and found.terms.flush_gain is not None:
        lost = np.maximum(lost, _MIX_FLUSHED * found.terms.step())
    return np.where(a.abs_sum > 0.0, lost, 0.0)  # where a is 0, this is x


@np.errstate(all="ignore")
def _mix_terms(found: Band, x: Band, y: Band, a: Band) -> Terms | None:
    """The terms of a mix: those of x, and products with the share. They may be added to others in
    any order. No compiler multiplies out a long chain of mixes, whose terms double with each; of
    four the roundings stay inside even so.
    """
    terms = found.terms
    if terms is None:
        return None
    near, far = (_largest_size(*band.apply_slack()) for band in (x, y))
    mag = x.abs_sum + (near + far) * a.abs_sum
    mag = np.minimum(np.maximum(mag, _largest_size(found.lo, found.hi)), LARGEST)
    gain = lambda: flush_gain_of(terms.abs_sum, terms)  # noqa: E731
    return Terms.of(mag, gain, terms, count=x.count + 2, signed=terms.signed)


def _largest_size(low: Float64Array, high: Float64Array) -> Float64Array:
    size: Float64Array = np.minimum(np.maximum(np.abs(low), np.abs(high)), LARGEST)
    return size


def _mix_at(x: Ends, y: Ends, a: Float64Array) -> Ends:
    """The least and the greatest x·(1 - a) + y·a at one `a`."""
    of_x = x[0] * (1.0 - a), x[1] * (1.0 - a)
    of_y = y[0] * a, y[1] * a
    return np.minimum(*of_x) + np.minimum(*of_y), np.maximum(*of_x) + np.maximum(*of_y)
