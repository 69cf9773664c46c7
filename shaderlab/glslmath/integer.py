"""GLSL's integer functions (GLSL 4.60, 8.8): exact. Of an integer that is not known exactly,
what depends on its bits may be anything that the type holds.

What GLSL returns in `out` arguments stands in a tuple with the result, first things first.
"""

from __future__ import annotations

import builtins
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Literal, Rules, TriBool
from shaderlab.bands.band import WHOLE
from shaderlab.bands.exact import concatenate
from shaderlab.errors import FormulaError

from .dispatch import Value

__all__ = [
    "bitCount", "bitfieldExtract", "bitfieldInsert", "bitfieldReverse", "findLSB", "findMSB",
    "float", "imulExtended", "int", "ivec2", "ivec3", "ivec4", "uaddCarry", "uint",
    "umulExtended", "usubBorrow", "uvec2", "uvec3", "uvec4",
]  # fmt: skip

_RANGE = 2**32


def uaddCarry(x: Value, y: Value) -> tuple[Integer, Integer]:
    """(x + y modulo 2³², 1 where that wrapped else 0).

    >>> total, carry = uaddCarry(4294967295, 2)
    >>> total.lo.tolist(), carry.lo.tolist()
    ([1], [1])
    """
    a, b = _as_integer(x, unsigned=True), _as_integer(y, unsigned=True)
    carry = a.derive((a.lo + b.lo) >> 32, None if _all_known(a, b) else (a.hi + b.hi) >> 32, b)
    return a + b, carry  # type: ignore[operator]


def usubBorrow(x: Value, y: Value) -> tuple[Integer, Integer]:
    """(x - y modulo 2³², 1 where x < y else 0).

    >>> difference, borrow = usubBorrow(1, 2)
    >>> difference.lo.tolist(), borrow.lo.tolist()
    ([4294967295], [1])
    """
    a, b = _as_integer(x, unsigned=True), _as_integer(y, unsigned=True)
    borrow = a.derive(1 * (a.hi < b.lo), None if _all_known(a, b) else 1 * (a.lo < b.hi), b)
    return a - b, borrow  # type: ignore[operator]


def umulExtended(x: Value, y: Value) -> tuple[Integer, Integer]:
    """(the upper, the lower 32 bits of x · y), all unsigned.

    >>> msb, lsb = umulExtended(4294967295, 4294967295)
    >>> msb.lo.tolist(), lsb.lo.tolist()
    ([4294967294], [1])
    """
    return _multiply_extended(_as_integer(x, unsigned=True), _as_integer(y, unsigned=True))


def imulExtended(x: Value, y: Value) -> tuple[Integer, Integer]:
    """(the upper, the lower 32 bits of x · y), all signed.

    >>> msb, lsb = imulExtended(-2, 3)
    >>> msb.lo.tolist(), lsb.lo.tolist()
    ([-1], [-6])
    """
    return _multiply_extended(_as_integer(x, unsigned=False), _as_integer(y, unsigned=False))


def bitfieldExtract(value: Value, offset: Value, bits: Value) -> Integer:
    """`bits` bits from `offset` on, their uppermost the sign of signed ones; 0 of no bits;
    undefined where they are not inside 32.

    >>> bitfieldExtract(Integer([0xABCD]), 4, 8).lo.tolist() == [-0x44]
    True
    """
    whole, at, size = _as_integer(value), _as_integer(offset), _as_integer(bits)
    if not _all_known(whole, at, size):
        return whole.derive_unknown(at, size)
    start, count, undefined = _find_field(at, size)
    field = (whole.lo % _RANGE >> start) & ((np.int64(1) << count) - 1)
    if not whole.unsigned:
        negative = (count > 0) & (field >> np.maximum(count - 1, 0) & 1 > 0)
        field = np.where(negative, field - (np.int64(1) << count), field)
    return whole.derive(field, None, at, size, anything=undefined)


def bitfieldInsert(base: Value, insert: Value, offset: Value, bits: Value) -> Integer:
    """`base` with `bits` bits from `offset` on taken from the lowest of `insert`; undefined where
    they are not inside 32.

    >>> bitfieldInsert(Integer([0xFFFF]), 0xA, 4, 4).lo.tolist() == [0xFFAF]
    True
    """
    whole, other, at, size = (_as_integer(value) for value in (base, insert, offset, bits))
    if not _all_known(whole, other, at, size):
        return whole.derive_unknown(other, at, size)
    start, count, undefined = _find_field(at, size)
    mask = ((np.int64(1) << count) - 1) << start
    merged = (whole.lo % _RANGE & ~mask) | ((other.lo % _RANGE << start) & mask)
    return whole.derive(merged, None, other, at, size, anything=undefined)


def bitfieldReverse(value: Value) -> Integer:
    """The bits in opposite order.

    >>> bitfieldReverse(Integer([1], unsigned=True)).lo.tolist()
    [2147483648]
    """

    def reverse(bits: Any) -> Any:
        return sum(((bits >> k) & 1) << (31 - k) for k in range(32))

    whole = _as_integer(value)
    return _map_bits(whole, reverse, unsigned=whole.unsigned)


def bitCount(value: Value) -> Integer:
    """How many bits are 1.

    >>> bitCount(Integer([-1])).lo.tolist()
    [32]
    """
    return _map_bits(_as_integer(value), lambda bits: sum((bits >> k) & 1 for k in range(32)))


def findLSB(value: Value) -> Integer:
    """The number of the lowest 1; -1 of 0.

    >>> findLSB(Integer([40])).lo.tolist()
    [3]
    """
    return _map_bits(_as_integer(value), lambda bits: _find_highest(bits & -bits))


def findMSB(value: Value) -> Integer:
    """The number of the highest 1, of negative ones the highest 0; -1 of 0 and -1.

    >>> findMSB(Integer([40, -2, -1])).lo.tolist()
    [5, 0, -1]
    """
    whole = _as_integer(value)
    if whole.unsigned:
        return _map_bits(whole, _find_highest)
    return _map_bits(whole, lambda n: _find_highest(np.where(n >> 31, _RANGE - 1 - n, n)))


def _find_highest(bits: Any) -> Any:
    """The number of the highest 1; frexp is exact below 2^53."""
    return np.frexp(bits.astype(np.float64))[1] - 1


def _as_integer(value: Value, *, unsigned: bool | None = None) -> Integer:
    if isinstance(value, Band | Literal):
        raise FormulaError("functions of bits take integers, not floats", remedy=WHOLE)
    whole = value if isinstance(value, Integer) else Integer(value)
    kind = whole.unsigned if unsigned is None else unsigned
    if not isinstance(value, Integer):
        whole = Integer(0, unsigned=kind).derive(whole.lo)
    return whole.convert(kind)


def _all_known(*values: Integer) -> bool:
    return all(value.known for value in values)


def _map_bits(whole: Integer, function: Callable[[Any], Any], *, unsigned: bool = False) -> Integer:
    if not whole.known:
        return whole.derive_unknown(unsigned=unsigned)
    return whole.derive(function(whole.lo % _RANGE), unsigned=unsigned)


def _multiply_extended(a: Integer, b: Integer) -> tuple[Integer, Integer]:
    if not _all_known(a, b):
        return a.derive_unknown(b), a.derive_unknown(b)
    # In two halves: the whole of unsigned products does not fit into int64.
    upper, lower = a.lo >> 16, a.lo & 0xFFFF
    middle = (lower * b.lo >> 16) + upper * b.lo
    return a.derive(middle >> 16, None, b), a.derive(a.lo * b.lo, None, b)


def _find_field(offset: Integer, bits: Integer) -> tuple[Any, Any, Any]:
    """Where a field starts and its size, 0 and 0 where it is not inside of 32 bits; and where."""
    undefined = (offset.lo < 0) | (bits.lo < 0) | (offset.lo + bits.lo > 32)
    return np.where(undefined, 0, offset.lo), np.where(undefined, 0, bits.lo), undefined


_RANGES = {False: (-(2.0**31), 2.0**31 - 1.0), True: (0.0, 2.0**32 - 1.0)}


def int(x: Value) -> Integer:
    """GLSL's int(x): truncated towards zero, or the same bits of a `uint`; undefined beyond the
    range of 32 bits.

    >>> int(-1.75).lo.tolist()
    [-1]
    """
    return _truncate(x, unsigned=False)


def uint(x: Value) -> Integer:
    """GLSL's uint(x): truncated, or the same bits of an `int`; undefined for floats below 0 and
    from 2³² on.

    >>> uint(Integer([-1])).lo.tolist()
    [4294967295]
    """
    return _truncate(x, unsigned=True)


def float(x: Value) -> Value:
    """GLSL's float(x): rounded to a float32 next to it; 0 or 1 of a condition."""
    if isinstance(x, Integer):
        return x.to_float()
    if isinstance(x, Band | Literal):
        return x
    if isinstance(x, TriBool):
        return Band.between(x.all_true, ~x.all_false, x.rules or Rules())
    return np.asarray(x, np.float64)[()]


def ivec2(*parts: Value) -> Integer:
    """Two signed integers from numbers and vectors, or one for both.

    >>> ivec2(7, -1).lo.tolist()
    [7, -1]
    """
    return _make_vector(2, parts, unsigned=False)


def ivec3(*parts: Value) -> Integer:
    """Three signed integers from numbers and vectors, or one for all."""
    return _make_vector(3, parts, unsigned=False)


def ivec4(*parts: Value) -> Integer:
    """Four signed integers from numbers and vectors, or one for all."""
    return _make_vector(4, parts, unsigned=False)


def uvec2(*parts: Value) -> Integer:
    """Two unsigned integers from numbers and vectors, or one for both."""
    return _make_vector(2, parts, unsigned=True)


def uvec3(*parts: Value) -> Integer:
    """Three unsigned integers from numbers and vectors, or one for all."""
    return _make_vector(3, parts, unsigned=True)


def uvec4(*parts: Value) -> Integer:
    """Four unsigned integers from numbers and vectors, or one for all."""
    return _make_vector(4, parts, unsigned=True)


def _truncate(x: Value, *, unsigned: bool) -> Integer:
    if isinstance(x, Integer):
        return x.convert(unsigned)
    if isinstance(x, TriBool):
        return Integer(x.all_true, ~x.all_false, unsigned=unsigned, rules=x.rules)
    least, most = _RANGES[unsigned]
    if isinstance(x, Band | Literal):
        band = x if isinstance(x, Band) else x.band
        low, high = np.trunc(band.lo), np.trunc(band.hi)
        undefined = band.nan | (low < least) | (high > most)
        rules = band.rules
    else:
        low = high = np.trunc(np.asarray(x, np.float64))
        undefined = ~((low >= least) & (low <= most))
        rules = None
    found = Integer(0, unsigned=unsigned, rules=rules)
    usable = [np.where(undefined, least, bound).astype(np.int64) for bound in (low, high)]
    same = np.array_equal(usable[0], usable[1])
    return found.derive(usable[0], None if same else usable[1], anything=undefined)


def _make_vector(size: builtins.int, parts: Sequence[Value], *, unsigned: bool) -> Integer:
    if not parts:
        raise FormulaError("a vector of integers needs at least one value")
    whole = [_truncate(part, unsigned=unsigned) for part in parts]
    joined = _join(whole) if len(whole) > 1 else whole[0]
    got = joined.shape[-1]
    if got == 1:
        return joined[..., [0] * size]
    if got < size or got - whole[-1].shape[-1] >= size:
        raise FormulaError(f"{got} integers for a vector of {size}")
    return joined[..., :size]


def _join(parts: Sequence[Integer]) -> Integer:
    known = all(part.known for part in parts)
    flags = [np.broadcast_to(part.anything, part.shape) for part in parts]
    return parts[0].derive(
        concatenate([part.lo for part in parts], -1),
        None if known else concatenate([part.hi for part in parts], -1),
        *(Integer(0, rules=part.rules) for part in parts[1:]),
        anything=concatenate(flags, -1),
    )
