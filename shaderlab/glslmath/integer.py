"""GLSL's conversions to and from integers (GLSL 4.60, 5.4), and what the functions of floats and
integers alike are for integers: exact.
"""

from __future__ import annotations

import builtins
from collections.abc import Sequence

import numpy as np

from shaderlab.bands import Band, Integer, Literal, Rules, Truth
from shaderlab.bands.exact import concatenated
from shaderlab.bands.truth import as_truth
from shaderlab.errors import FormulaError
from shaderlab.glslmath.dispatch import Condition, Value

_RANGES = {False: (-(2.0**31), 2.0**31 - 1.0), True: (0.0, 2.0**32 - 1.0)}


def int(x: Value) -> Integer:
    """GLSL's int(x): truncated towards zero, or the same bits of a `uint`; undefined beyond the
    range of 32 bits.

    >>> int(-1.75).lo.tolist()
    [-1]
    """
    return _integer(x, unsigned=False)


def uint(x: Value) -> Integer:
    """GLSL's uint(x): truncated, or the same bits of an `int`; undefined for floats below 0 and
    from 2³² on.

    >>> uint(Integer([-1])).lo.tolist()
    [4294967295]
    """
    return _integer(x, unsigned=True)


def float(x: Value) -> Value:
    """GLSL's float(x): rounded to a float32 next to it; 0 or 1 of a condition."""
    if isinstance(x, Integer):
        return x.to_float()
    if isinstance(x, Band | Literal):
        return x
    if isinstance(x, Truth):
        return Band.between(x.all_true, ~x.all_false, x.rules or Rules())
    return np.asarray(x, np.float64)[()]


def ivec2(*parts: Value) -> Integer:
    """Two signed integers from numbers and vectors, or one for both.

    >>> ivec2(7, -1).lo.tolist()
    [7, -1]
    """
    return _vector(2, parts, unsigned=False)


def ivec3(*parts: Value) -> Integer:
    """Three signed integers from numbers and vectors, or one for all."""
    return _vector(3, parts, unsigned=False)


def ivec4(*parts: Value) -> Integer:
    """Four signed integers from numbers and vectors, or one for all."""
    return _vector(4, parts, unsigned=False)


def uvec2(*parts: Value) -> Integer:
    """Two unsigned integers from numbers and vectors, or one for both."""
    return _vector(2, parts, unsigned=True)


def uvec3(*parts: Value) -> Integer:
    """Three unsigned integers from numbers and vectors, or one for all."""
    return _vector(3, parts, unsigned=True)


def uvec4(*parts: Value) -> Integer:
    """Four unsigned integers from numbers and vectors, or one for all."""
    return _vector(4, parts, unsigned=True)


def _integer(x: Value, *, unsigned: bool) -> Integer:
    if isinstance(x, Integer):
        return x.converted(unsigned)
    if isinstance(x, Truth):
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
    return found.made(usable[0], None if same else usable[1], anything=undefined)


def _vector(size: builtins.int, parts: Sequence[Value], *, unsigned: bool) -> Integer:
    if not parts:
        raise FormulaError("a vector of integers needs at least one value")
    whole = [_integer(part, unsigned=unsigned) for part in parts]
    joined = _joined(whole) if len(whole) > 1 else whole[0]
    got = joined.shape[-1]
    if got == 1:
        return joined[..., [0] * size]
    if got < size or got - whole[-1].shape[-1] >= size:
        raise FormulaError(f"{got} integers for a vector of {size}")
    return joined[..., :size]


def _joined(parts: Sequence[Integer]) -> Integer:
    known = all(part.known for part in parts)
    flags = [np.broadcast_to(part.anything, part.shape) for part in parts]
    return parts[0].made(
        concatenated([part.lo for part in parts], -1),
        None if known else concatenated([part.hi for part in parts], -1),
        *(Integer(0, rules=part.rules) for part in parts[1:]),
        anything=concatenated(flags, -1),
    )


def absolute(n: Integer) -> Integer:
    """|n|; the least integer stays what it is."""
    ends = np.abs(n.lo), np.abs(n.hi)
    low = np.where((n.lo < 0) & (n.hi > 0), 0, np.minimum(*ends))
    return n.made(low, None if n.known else np.maximum(*ends))


def sign(n: Integer) -> Integer:
    """-1, 0 or 1."""
    return n.made(np.sign(n.lo), None if n.known else np.sign(n.hi))


def smaller(a: Integer, b: Integer) -> Integer:
    """The smaller of two."""
    known = a.known and b.known
    return a.made(np.minimum(a.lo, b.lo), None if known else np.minimum(a.hi, b.hi), b)


def larger(a: Integer, b: Integer) -> Integer:
    """The larger of two."""
    known = a.known and b.known
    return a.made(np.maximum(a.lo, b.lo), None if known else np.maximum(a.hi, b.hi), b)


def clamped(n: Integer, minimum: Integer, maximum: Integer) -> Integer:
    """min(max(n, minimum), maximum); undefined where minimum may exceed maximum."""
    found = smaller(larger(n, minimum), maximum)
    undefined = minimum.hi > maximum.lo
    return found.made(found.lo, None if found.known else found.hi, anything=undefined)


def select(condition: Condition, a: Integer, b: Integer) -> Integer:
    """a where the condition holds, else b; the hull of both where it is undecided."""
    truth = as_truth(condition)
    low = np.where(truth.all_true, a.lo, np.where(truth.all_false, b.lo, np.minimum(a.lo, b.lo)))
    high = np.where(truth.all_true, a.hi, np.where(truth.all_false, b.hi, np.maximum(a.hi, b.hi)))
    flags = (a.anything & ~truth.all_false) | (b.anything & ~truth.all_true)
    plain = Integer(0, unsigned=a.unsigned, rules=a.rules or b.rules or truth.rules)
    return plain.made(low, None if np.array_equal(low, high) else high, anything=flags)
