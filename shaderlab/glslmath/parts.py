"""GLSL's functions of a float's parts and bits (GLSL 4.60, 8.3): exact, but for denormals, which
a device may flush.

What GLSL returns in an `out` argument stands behind the result, as a tuple.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Literal
from shaderlab.bands.rounding import SMALLEST_NORMAL
from shaderlab.glslmath.dispatch import Value, applied, integers, undefined
from shaderlab.glslmath.scalar import trunc

_SIGN_BIT = 2**31
_INFINITY = 0x7F80_0000


def modf(x: Value) -> tuple[Value, Value]:
    """(fraction, whole): x = whole + fraction, both of x's sign.

    >>> fraction, whole = modf(-1.75)
    >>> float(fraction), float(whole)
    (-0.75, -1.0)
    """

    def banded(x: Band) -> Band:
        low, high = np.trunc(x.lo), np.trunc(x.hi)
        # Across an integer the fraction may be anything of its sign.
        crosses = low != high
        lo = np.where(crosses, -1.0 * (x.lo < 0.0), x.lo - low)
        hi = np.where(crosses, 1.0 * (x.hi > 0.0), x.hi - high)
        return undefined(x.made(lo, hi), np.isinf(x.lo) | np.isinf(x.hi))

    return applied(lambda x: x - np.trunc(x), banded, x), trunc(x)


def frexp(x: Value) -> tuple[Value, Integer]:
    """(significand in [0.5, 1), exponent): x = significand · 2^exponent; both 0 for 0, undefined
    for infinities and NaN.

    >>> significand, exponent = frexp(-6.0)
    >>> float(significand), int(exponent.lo[0])
    (-0.75, 3)
    """
    band = _band(x)
    if band is None:
        significand, exponent = np.frexp(np.asarray(x, np.float64))
        return significand[()], Integer(exponent)
    (lo, low), (hi, high) = np.frexp(band.lo), np.frexp(band.hi)
    same = (low == high) & (np.sign(lo) == np.sign(hi))
    above, below = band.lo > 0.0, band.hi < 0.0
    lo = np.where(same, lo, np.where(above, 0.5, -1.0))
    hi = np.where(same, hi, np.where(below, -0.5, 1.0))
    least = np.where(above | below, np.minimum(low, high), -149)
    most = np.maximum(np.maximum(low, high), np.where(above | below, -200, 0))
    least = np.where(same, low, least)
    denormal = (np.maximum(np.abs(band.lo), np.abs(band.hi)) < SMALLEST_NORMAL) & (
        (band.lo != 0.0) | (band.hi != 0.0)
    )
    anything = np.isinf(band.lo) | np.isinf(band.hi) | band.nan | denormal
    exact = bool((least == most).all())
    whole = Integer(0, rules=band.rules).made(least, None if exact else most, anything=anything)
    return undefined(band.made(lo, hi), anything), whole


@np.errstate(all="ignore")
def ldexp(x: Value, exponent: Value) -> Value:
    """x · 2^exponent; undefined where that is too large, or the exponent is above 128; below
    -126 the result may be 0.

    >>> float(ldexp(0.75, Integer([3]))[0])
    6.0
    """
    whole = exponent if isinstance(exponent, Integer) else Integer(exponent)
    band = _band(x)
    if band is None and whole.rules is None:
        return np.ldexp(np.asarray(x, np.float64), whole.lo)
    if band is None:
        band = Band.literal(x, whole.rules)  # type: ignore[arg-type]
    ends: list[Any] = [np.ldexp(b, e) for b in (band.lo, band.hi) for e in (whole.lo, whole.hi)]
    lo: Any = np.minimum.reduce(ends)
    hi: Any = np.maximum.reduce(ends)
    small = whole.lo < -126
    lo = np.where(small, np.minimum(lo, 0.0), lo)
    hi = np.where(small, np.maximum(hi, 0.0), hi)
    large = (whole.hi > 128) | (np.maximum(np.abs(lo), np.abs(hi)) >= 2.0**128) | whole.anything
    return undefined(band.made(lo, hi), large)


def floatBitsToInt(x: Value) -> Integer:
    """The bits of a float32, as a signed integer; of 0 those of either sign.

    >>> floatBitsToInt(1.0).lo.tolist() == [0x3F800000]
    True
    """
    return _bits(x, unsigned=False)


def floatBitsToUint(x: Value) -> Integer:
    """The bits of a float32, as an unsigned integer; of 0 those of either sign.

    >>> floatBitsToUint(-2.0).lo.tolist() == [0xC0000000]
    True
    """
    return _bits(x, unsigned=True)


def intBitsToFloat(n: Value) -> Value:
    """The float32 of these bits; undefined for those of a NaN.

    >>> float(intBitsToFloat(0x40490FDB)[0])
    3.1415927410125732
    """
    return _float(n)


def uintBitsToFloat(n: Value) -> Value:
    """The float32 of these bits; undefined for those of a NaN."""
    return _float(n)


def _band(x: Value) -> Band | None:
    """The value as a band if it is made of bands, else None."""
    if isinstance(x, Integer):
        x = x.to_float()
    if isinstance(x, Literal):
        return x.band
    return x if isinstance(x, Band) else None


def _pattern(x: Any) -> Any:
    """A float32's bits below the sign, and its sign, as int64."""
    bits = np.asarray(x, np.float32).view(np.uint32).astype(np.int64)
    return bits % _SIGN_BIT, bits >= _SIGN_BIT


def _bits(x: Value, *, unsigned: bool) -> Integer:
    band = _band(x)
    negative = _SIGN_BIT if unsigned else -_SIGN_BIT
    if band is None:
        size, minus = _pattern(np.atleast_1d(x))
        return Integer(size + minus * negative, unsigned=unsigned)
    (low, _), (high, _) = _pattern(band.lo), _pattern(band.hi)
    below, above = band.hi < 0.0, band.lo > 0.0
    # More negative floats have larger bits below the sign.
    first = np.where(below, high, np.where(above, low, 0))
    last = np.where(below, low, np.where(above, high, np.maximum(low, high)))
    both = ~(below | above)
    first = first + np.where(below | (both & (not unsigned)), negative, 0)
    last = last + np.where(below | (both & unsigned), negative, 0)
    exact = bool((first == last).all())
    whole = Integer(0, unsigned=unsigned, rules=band.rules)
    return whole.made(first, None if exact else last, anything=band.nan)


def _float(n: Value) -> Value:
    whole = n if isinstance(n, Integer) else integers(Integer(0), n)[1]  # type: ignore[index]
    sizes = [bound % _SIGN_BIT for bound in (whole.lo, whole.hi)]
    signs = [(bound % 2**32) >= _SIGN_BIT for bound in (whole.lo, whole.hi)]
    ends = [
        np.where(sign, size + _SIGN_BIT, size).astype(np.uint32).view(np.float32).astype(np.float64)
        for size, sign in zip(sizes, signs, strict=True)
    ]
    if whole.rules is None:
        return ends[0]
    torn = (signs[0] != signs[1]) | whole.anything
    nan = np.maximum(*sizes) > _INFINITY
    lo, hi = (np.where(nan | torn, 0.0, end) for end in (np.minimum(*ends), np.maximum(*ends)))
    return undefined(Band.between(lo, hi, whole.rules), nan | torn)
