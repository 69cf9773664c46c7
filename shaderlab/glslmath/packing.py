"""GLSL's packing functions (GLSL 4.60, 8.4): floats in [-1, 1] or halves as bits of a `uint`.

A code is `round(clamp(c) · largest)`, with the roundings of a multiplication; unpacking divides
by `largest`, within 2.5 ULP. A float that lies between two halves may become either.
Where a component may become either of two codes, the band is from the one number to the other, and
says little of the lower components.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Rules
from shaderlab.bands.formats import quantise
from shaderlab.glslmath.dispatch import Value
from shaderlab.glslmath.integer import float as to_float, int as to_int
from shaderlab.glslmath.scalar import clamp, round

__all__ = [
    "packHalf2x16", "packSnorm2x16", "packSnorm4x8", "packUnorm2x16", "packUnorm4x8",
    "unpackHalf2x16", "unpackSnorm2x16", "unpackSnorm4x8", "unpackUnorm2x16", "unpackUnorm4x8",
]  # fmt: skip


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
    ends = [np.asarray(end, np.float16).view(np.uint16).astype(np.int64) for end in
            (allowed.lo, allowed.hi)]  # fmt: skip
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
