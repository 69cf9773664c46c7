"""GLSL's integer functions (GLSL 4.60, 8.8): exact. Of an integer that is not known exactly,
what depends on its bits may be anything that the type holds.

What GLSL returns in `out` arguments stands in a tuple with the result, first things first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Literal
from shaderlab.bands.integer_operators import WHOLE
from shaderlab.errors import FormulaError
from shaderlab.glslmath.dispatch import Value

_RANGE = 2**32


def uaddCarry(x: Value, y: Value) -> tuple[Integer, Integer]:
    """(x + y modulo 2³², 1 where that wrapped else 0).

    >>> total, carry = uaddCarry(4294967295, 2)
    >>> total.lo.tolist(), carry.lo.tolist()
    ([1], [1])
    """
    a, b = _whole(x, unsigned=True), _whole(y, unsigned=True)
    carry = a.made((a.lo + b.lo) >> 32, None if _known(a, b) else (a.hi + b.hi) >> 32, b)
    return a + b, carry  # type: ignore[operator]


def usubBorrow(x: Value, y: Value) -> tuple[Integer, Integer]:
    """(x - y modulo 2³², 1 where x < y else 0).

    >>> difference, borrow = usubBorrow(1, 2)
    >>> difference.lo.tolist(), borrow.lo.tolist()
    ([4294967295], [1])
    """
    a, b = _whole(x, unsigned=True), _whole(y, unsigned=True)
    borrow = a.made(1 * (a.hi < b.lo), None if _known(a, b) else 1 * (a.lo < b.hi), b)
    return a - b, borrow  # type: ignore[operator]


def umulExtended(x: Value, y: Value) -> tuple[Integer, Integer]:
    """(the upper, the lower 32 bits of x · y), all unsigned.

    >>> msb, lsb = umulExtended(4294967295, 4294967295)
    >>> msb.lo.tolist(), lsb.lo.tolist()
    ([4294967294], [1])
    """
    return _extended(_whole(x, unsigned=True), _whole(y, unsigned=True))


def imulExtended(x: Value, y: Value) -> tuple[Integer, Integer]:
    """(the upper, the lower 32 bits of x · y), all signed.

    >>> msb, lsb = imulExtended(-2, 3)
    >>> msb.lo.tolist(), lsb.lo.tolist()
    ([-1], [-6])
    """
    return _extended(_whole(x, unsigned=False), _whole(y, unsigned=False))


def bitfieldExtract(value: Value, offset: Value, bits: Value) -> Integer:
    """`bits` bits from `offset` on, their uppermost the sign of signed ones; 0 of no bits;
    undefined where they are not inside 32.

    >>> bitfieldExtract(Integer([0xABCD]), 4, 8).lo.tolist() == [-0x44]
    True
    """
    whole, at, size = _whole(value), _whole(offset), _whole(bits)
    if not _known(whole, at, size):
        return whole.unknown(at, size)
    start, count, undefined = _field(at, size)
    field = (whole.lo % _RANGE >> start) & ((np.int64(1) << count) - 1)
    if not whole.unsigned:
        negative = (count > 0) & (field >> np.maximum(count - 1, 0) & 1 > 0)
        field = np.where(negative, field - (np.int64(1) << count), field)
    return whole.made(field, None, at, size, anything=undefined)


def bitfieldInsert(base: Value, insert: Value, offset: Value, bits: Value) -> Integer:
    """`base` with `bits` bits from `offset` on taken from the lowest of `insert`; undefined where
    they are not inside 32.

    >>> bitfieldInsert(Integer([0xFFFF]), 0xA, 4, 4).lo.tolist() == [0xFFAF]
    True
    """
    whole, other, at, size = _whole(base), _whole(insert), _whole(offset), _whole(bits)
    if not _known(whole, other, at, size):
        return whole.unknown(other, at, size)
    start, count, undefined = _field(at, size)
    mask = ((np.int64(1) << count) - 1) << start
    merged = (whole.lo % _RANGE & ~mask) | ((other.lo % _RANGE << start) & mask)
    return whole.made(merged, None, other, at, size, anything=undefined)


def bitfieldReverse(value: Value) -> Integer:
    """The bits in opposite order.

    >>> bitfieldReverse(Integer([1], unsigned=True)).lo.tolist()
    [2147483648]
    """

    def reverse(bits: Any) -> Any:
        return sum(((bits >> k) & 1) << (31 - k) for k in range(32))

    whole = _whole(value)
    return _of_bits(whole, reverse, unsigned=whole.unsigned)


def bitCount(value: Value) -> Integer:
    """How many bits are 1.

    >>> bitCount(Integer([-1])).lo.tolist()
    [32]
    """
    return _of_bits(_whole(value), lambda bits: sum((bits >> k) & 1 for k in range(32)))


def findLSB(value: Value) -> Integer:
    """The number of the lowest 1; -1 of 0.

    >>> findLSB(Integer([40])).lo.tolist()
    [3]
    """
    return _of_bits(_whole(value), lambda bits: _highest(bits & -bits))


def findMSB(value: Value) -> Integer:
    """The number of the highest 1, of negative ones the highest 0; -1 of 0 and -1.

    >>> findMSB(Integer([40, -2, -1])).lo.tolist()
    [5, 0, -1]
    """
    whole = _whole(value)
    if whole.unsigned:
        return _of_bits(whole, _highest)
    return _of_bits(whole, lambda bits: _highest(np.where(bits >> 31, _RANGE - 1 - bits, bits)))


def _highest(bits: Any) -> Any:
    """The number of the highest 1; frexp is exact below 2^53."""
    return np.frexp(bits.astype(np.float64))[1] - 1


def _whole(value: Value, *, unsigned: bool | None = None) -> Integer:
    if isinstance(value, Band | Literal):
        raise FormulaError("functions of bits take integers, not floats", remedy=WHOLE)
    whole = value if isinstance(value, Integer) else Integer(value)
    kind = whole.unsigned if unsigned is None else unsigned
    if not isinstance(value, Integer):
        whole = Integer(0, unsigned=kind).made(whole.lo)
    return whole.converted(kind)


def _known(*values: Integer) -> bool:
    return all(value.known for value in values)


def _of_bits(whole: Integer, function: Callable[[Any], Any], *, unsigned: bool = False) -> Integer:
    if not whole.known:
        return whole.unknown(unsigned=unsigned)
    return whole.made(function(whole.lo % _RANGE), unsigned=unsigned)


def _extended(a: Integer, b: Integer) -> tuple[Integer, Integer]:
    if not _known(a, b):
        return a.unknown(b), a.unknown(b)
    # In two halves: the whole of unsigned products does not fit into int64.
    upper, lower = a.lo >> 16, a.lo & 0xFFFF
    middle = (lower * b.lo >> 16) + upper * b.lo
    return a.made(middle >> 16, None, b), a.made(a.lo * b.lo, None, b)


def _field(offset: Integer, bits: Integer) -> tuple[Any, Any, Any]:
    """Where a field starts and its size, 0 and 0 where it is not inside of 32 bits; and where."""
    undefined = (offset.lo < 0) | (bits.lo < 0) | (offset.lo + bits.lo > 32)
    return np.where(undefined, 0, offset.lo), np.where(undefined, 0, bits.lo), undefined
