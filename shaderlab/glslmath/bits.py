"""The parts and the bits of floats (GLSL 4.60, 8.3), and GLSL's packing functions (8.4): floats in
[-1, 1] or halves as bits of a `uint`.

A code is `round(clamp(c) · largest)`, with the roundings of a multiplication; unpacking divides
by `largest`, within 2.5 ULP. A float that lies between two halves may become either. Where a
component may become either of two codes, the band is from the one number to the other, and says
little of the lower components.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Literal, Rules
from shaderlab.bands.formats import quantise
from shaderlab.bands.rounding import SMALLEST_NORMAL
from shaderlab.glslmath.dispatch import Value, apply, as_integers, mark_undefined
from shaderlab.glslmath.integer import float as to_float, int as to_int
from shaderlab.glslmath.scalar import clamp, round, trunc

__all__ = [
    "floatBitsToInt", "floatBitsToUint", "frexp", "intBitsToFloat", "ldexp", "modf",
    "packHalf2x16", "packSnorm2x16", "packSnorm4x8", "packUnorm2x16", "packUnorm4x8",
    "uintBitsToFloat", "unpackHalf2x16", "unpackSnorm2x16", "unpackSnorm4x8", "unpackUnorm2x16",
    "unpackUnorm4x8",
]  # fmt: skip

_SIGN_BIT = 2**31
_INFINITY = 0x7F80_0000


def modf(x: Value) -> tuple[Value, Value]:
    """(fraction, whole): x = whole + fraction, both of x's sign.

    >>> fraction, whole = modf(-1.75)
    >>> float(fraction), float(whole)
    (-0.75, -1.0)
    """

    def on_bands(x: Band) -> Band:
        low, high = np.trunc(x.lo), np.trunc(x.hi)
        # Across an integer the fraction may be anything of its sign.
        crosses = low != high
        lo = np.where(crosses, -1.0 * (x.lo < 0.0), x.lo - low)
        hi = np.where(crosses, 1.0 * (x.hi > 0.0), x.hi - high)
        return mark_undefined(x.derive(lo, hi), np.isinf(x.lo) | np.isinf(x.hi))

    return apply(lambda x: x - np.trunc(x), on_bands, x), trunc(x)


def frexp(x: Value) -> tuple[Value, Integer]:
    """(significand in [0.5, 1), exponent): x = significand · 2^exponent; both 0 for 0, undefined
    for infinities and NaN.

    >>> significand, exponent = frexp(-6.0)
    >>> float(significand), int(exponent.lo[0])
    (-0.75, 3)
    """
    band = _as_band(x)
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
    whole = Integer(0, rules=band.rules).derive(least, None if exact else most, anything=anything)
    return mark_undefined(band.derive(lo, hi), anything), whole


@np.errstate(all="ignore")
def ldexp(x: Value, exponent: Value) -> Value:
    """x · 2^exponent; undefined where that is too large, or the exponent is above 128; below
    -126 the result may be 0.

    >>> float(ldexp(0.75, Integer([3]))[0])
    6.0
    """
    whole = exponent if isinstance(exponent, Integer) else Integer(exponent)
    band = _as_band(x)
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
    return mark_undefined(band.derive(lo, hi), large)


def floatBitsToInt(x: Value) -> Integer:
    """The bits of a float32, as a signed integer; of 0 those of either sign.

    >>> floatBitsToInt(1.0).lo.tolist() == [0x3F800000]
    True
    """
    return _float_to_bits(x, unsigned=False)


def floatBitsToUint(x: Value) -> Integer:
    """The bits of a float32, as an unsigned integer; of 0 those of either sign.

    >>> floatBitsToUint(-2.0).lo.tolist() == [0xC0000000]
    True
    """
    return _float_to_bits(x, unsigned=True)


def intBitsToFloat(n: Value) -> Value:
    """The float32 of these bits; undefined for those of a NaN.

    >>> float(intBitsToFloat(0x40490FDB)[0])
    3.1415927410125732
    """
    return _bits_to_float(n)


def uintBitsToFloat(n: Value) -> Value:
    """The float32 of these bits; undefined for those of a NaN."""
    return _bits_to_float(n)


def _as_band(x: Value) -> Band | None:
    if isinstance(x, Integer):
        x = x.to_float()
    if isinstance(x, Literal):
        return x.band
    return x if isinstance(x, Band) else None


def _split_sign(x: Any) -> Any:
    """A float32's bits below the sign, and its sign, as int64."""
    bits = np.asarray(x, np.float32).view(np.uint32).astype(np.int64)
    return bits % _SIGN_BIT, bits >= _SIGN_BIT


def _float_to_bits(x: Value, *, unsigned: bool) -> Integer:
    band = _as_band(x)
    negative = _SIGN_BIT if unsigned else -_SIGN_BIT
    if band is None:
        size, minus = _split_sign(np.atleast_1d(x))
        return Integer(size + minus * negative, unsigned=unsigned)
    (low, _), (high, _) = _split_sign(band.lo), _split_sign(band.hi)
    below, above = band.hi < 0.0, band.lo > 0.0
    # More negative floats have larger bits below the sign.
    first = np.where(below, high, np.where(above, low, 0))
    last = np.where(below, low, np.where(above, high, np.maximum(low, high)))
    both = ~(below | above)
    first = first + np.where(below | (both & (not unsigned)), negative, 0)
    last = last + np.where(below | (both & unsigned), negative, 0)
    exact = bool((first == last).all())
    whole = Integer(0, unsigned=unsigned, rules=band.rules)
    return whole.derive(first, None if exact else last, anything=band.nan)


def _bits_to_float(n: Value) -> Value:
    whole = n if isinstance(n, Integer) else as_integers(Integer(0), n)[1]  # type: ignore[index]
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
    return mark_undefined(Band.between(lo, hi, whole.rules), nan | torn)


def packUnorm2x16(v: Value) -> Integer:
    """Two components as codes 0…65535, the first in the lower bits.

    >>> packUnorm2x16(np.array([1.0, 0.0])).lo.tolist()
    [65535]
    """
    return _pack(v, 2, 0.0)


def packSnorm2x16(v: Value) -> Integer:
    """Two components as codes -32767…32767, the first in the lower bits.

    >>> packSnorm2x16(np.array([-1.0, 0.0])).lo.tolist() == [0x8001]
    True
    """
    return _pack(v, 2, -1.0)


def packUnorm4x8(v: Value) -> Integer:
    """Four components as codes 0…255, the first in the lowest bits.

    >>> packUnorm4x8(np.array([1.0, 0.0, 0.0, 1.0])).lo.tolist() == [0xFF0000FF]
    True
    """
    return _pack(v, 4, 0.0)


def packSnorm4x8(v: Value) -> Integer:
    """Four components as codes -127…127, the first in the lowest bits.

    >>> packSnorm4x8(np.array([1.0, 0.0, 0.0, -1.0])).lo.tolist() == [0x8100007F]
    True
    """
    return _pack(v, 4, -1.0)


def packHalf2x16(v: Value) -> Integer:
    """Two components as halves, the first in the lower bits; undefined beyond ±65504.

    >>> packHalf2x16(np.array([1.0, -2.0])).lo.tolist() == [0xC0003C00]
    True
    """
    if not isinstance(v, Band):
        bits = np.atleast_1d(np.asarray(v, np.float16)).view(np.uint16).astype(np.int64)
        return _join_codes(Integer(bits, unsigned=True), 2)
    allowed = quantise(v, "rgba16f")
    halves = (np.asarray(end, np.float16) for end in (allowed.lo, allowed.hi))
    ends = [half.view(np.uint16).astype(np.int64) for half in halves]
    # Of negative halves those further from zero have larger bits; zero may have either sign.
    zero = (allowed.lo <= 0.0) & (allowed.hi >= 0.0)
    low, high = np.minimum(*ends), np.maximum(*ends)
    low, high = np.where(zero, 0, low), np.where(zero, np.maximum(high, 0x8000), high)
    far = (np.maximum(np.abs(v.lo), np.abs(v.hi)) > 65504.0) | v.nan
    codes = Integer(low, None if (low == high).all() else high, unsigned=True, rules=v.rules)
    return _join_codes(codes, 2, far)


def unpackUnorm2x16(p: Value) -> Value:
    """Two components: codes / 65535.

    >>> unpackUnorm2x16(65535).tolist()
    [1.0, 0.0]
    """
    return _unpack(p, 2, signed=False)


def unpackSnorm2x16(p: Value) -> Value:
    """Two components: clamp(codes / 32767, -1, 1)."""
    return _unpack(p, 2, signed=True)


def unpackUnorm4x8(p: Value) -> Value:
    """Four components: codes / 255.

    >>> unpackUnorm4x8(0xFF0000FF).tolist()
    [1.0, 0.0, 0.0, 1.0]
    """
    return _unpack(p, 4, signed=False)


def unpackSnorm4x8(p: Value) -> Value:
    """Four components: clamp(codes / 127, -1, 1)."""
    return _unpack(p, 4, signed=True)


def unpackHalf2x16(p: Value) -> Value:
    """Two components from halves; a denormal half may become 0, a NaN anything.

    >>> unpackHalf2x16(0xC0003C00).tolist()
    [1.0, -2.0]
    """
    whole = _split(p, 2)
    values = whole.lo.astype(np.uint16).view(np.float16).astype(np.float64)
    if whole.rules is None:
        return values
    if not whole.known:
        return _any_float(whole, whole.rules)
    small = np.abs(values) < 2.0**-14
    lo = np.where(small, np.minimum(values, 0.0), values)
    hi = np.where(small, np.maximum(values, 0.0), values)
    nan = np.isnan(values) | whole.anything
    band = Band.between(np.where(nan, 0.0, lo), np.where(nan, 0.0, hi), whole.rules)
    return band.derive(band.lo, band.hi, anything=nan)


def _pack(v: Value, count: int, least: float) -> Integer:
    largest = 2.0 ** (32 // count - (least < 0.0)) - 1.0
    codes = to_int(round(clamp(v, least, 1.0) * largest))
    return _join_codes(codes, count)


def _join_codes(codes: Integer, count: int, anything: Any = None) -> Integer:
    """Codes along the last axis as the bits of one number, the first lowest."""
    size = 32 // count
    if not codes.known and (codes.lo < 0).any():
        # Bits of codes on either side of zero have nothing in common.
        mixed = (codes.lo < 0) & (codes.hi >= 0)
        low = np.where(mixed, 0, codes.lo % 2**size)
        high = np.where(mixed, 2**size - 1, codes.hi % 2**size)
    else:
        low, high = codes.lo % 2**size, codes.hi % 2**size
    weights = np.int64(1) << (size * np.arange(count))
    low, high = ((bound * weights).sum(axis=-1, keepdims=True) for bound in (low, high))
    flags = codes.anything if anything is None else codes.anything | anything
    if flags.ndim:
        flags = flags.any(axis=-1, keepdims=True)
    whole = Integer(0, unsigned=True, rules=codes.rules)
    return whole.derive(low, None if codes.known else high, anything=flags)


def _split(p: Value, count: int) -> Integer:
    """The bits of a number as unsigned numbers along the last axis, the lowest first."""
    whole = p if isinstance(p, Integer) else Integer(p, unsigned=True)
    size = 32 // count
    if not whole.known:
        low = np.zeros((*whole.shape[:-1], count), np.int64)
        found = Integer(low, low + 2**size - 1, unsigned=True, rules=whole.rules)
    else:
        shifted = (whole.lo % 2**32) >> (size * np.arange(count))
        found = Integer(shifted % 2**size, unsigned=True, rules=whole.rules)
    found.anything = whole.anything
    return found


def _unpack(p: Value, count: int, *, signed: bool) -> Value:
    whole = _split(p, count)
    size = 32 // count
    if not signed:
        return to_float(whole) / (2.0**size - 1.0)
    if not whole.known:
        return clamp(_any_float(whole, whole.rules or Rules()), -1.0, 1.0)
    negative = whole.lo >= 2 ** (size - 1)
    codes = Integer(np.where(negative, whole.lo - 2**size, whole.lo), rules=whole.rules)
    return clamp(to_float(codes) / (2.0 ** (size - 1) - 1.0), -1.0, 1.0)


def _any_float(whole: Integer, rules: Rules) -> Band:
    wide = np.full(whole.shape, np.inf)
    return Band.between(-wide, wide, rules)
