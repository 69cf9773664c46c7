"""Building and taking apart vectors and matrices: GLSL's constructors and swizzles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Literal
from shaderlab.bands.bounds import SETS, as_vector, components
from shaderlab.bands.exact import concatenate, join
from shaderlab.bands.rounding import SMALLEST_NORMAL
from shaderlab.errors import FormulaError

from .choice import equal, where
from .dispatch import Value, apply, as_bands, as_integers, mark_undefined
from .scalar import trunc

__all__ = [
    "array", "floatBitsToInt", "floatBitsToUint", "frexp", "intBitsToFloat", "ldexp", "mat2",
    "mat3", "mat4", "modf", "swizzle", "uintBitsToFloat", "vec2", "vec3", "vec4",
]  # fmt: skip


def stack(parts: Sequence[Value], axis: int) -> Value:
    """Values one after the other along an axis, the other axes broadcast."""
    lifted = as_bands(*parts)
    if lifted is not None:
        return join(lifted, axis)
    arrays = [np.atleast_1d(np.asarray(part, np.float64)) for part in parts]
    return as_vector(concatenate(arrays, axis), *parts)


def _take_components(name: str, size: int, parts: Sequence[Value]) -> Value:
    """`size` components of the parts, one after the other. GLSL takes what it needs of the last
    part, but no part may be left over."""
    together = stack(parts, -1) if parts else np.empty(0)
    got = together.shape[-1]
    last = (_shape(parts[-1])[-1:] or (1,))[0] if parts else 0
    if got < size or got - last >= size:
        raise FormulaError(
            f"{name} of {got} components in {len(parts)} arguments",
            remedy=f"give it {size} components, or one number for all of them",
        )
    return together[..., :size]


def _shape(value: Value) -> tuple[int, ...]:
    return tuple(value.shape if hasattr(value, "shape") else np.shape(value))


def _vector(size: int, parts: Sequence[Value]) -> Value:
    if len(parts) == 1 and (_shape(parts[0])[-1:] or (1,))[0] == 1:
        return stack(parts, -1)[..., [0] * size]
    return _take_components(f"vec{size}", size, parts)


def vec2(*parts: Value) -> Value:
    """Two components from numbers and vectors, or one number for both.

    >>> vec2(1.0, 2.0)
    array([1., 2.])
    """
    return _vector(2, parts)


def vec3(*parts: Value) -> Value:
    """Three components from numbers and vectors, or one number for all; the rest broadcasts.

    >>> vec3(np.array([1.0, 2.0]), 3.0)
    array([1., 2., 3.])
    """
    return _vector(3, parts)


def vec4(*parts: Value) -> Value:
    """Four components from numbers and vectors, or one number for all; the rest broadcasts.

    >>> vec4(np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), 1.0)
    array([[1., 2., 3., 1.],
           [4., 5., 6., 1.]])
    """
    return _vector(4, parts)


def swizzle(v: Value, names: str) -> Value:
    """Components by GLSL's names: xyzw, rgba or stpq, of one set, any order, repeated or not;
    the values that a reference gets have them as attributes, too: `v.yxx`.

    >>> swizzle(np.array([1.0, 2.0]), "yxx")
    array([2., 1., 1.])
    """
    size = _shape(v)[-1]
    found = components(names, size)
    if found is None:
        raise FormulaError(
            f"no swizzle {names!r} of {size} components",
            remedy=f"use the letters of one of {', '.join(s[:size] for s in SETS)}",
        )
    return v[..., found]


def _matrix(size: int, parts: Sequence[Value]) -> Value:
    name = f"mat{size}"
    if len(parts) == 1:
        (m,) = parts
        shape = _shape(m)
        if len(shape) >= 2 and min(shape[-2:]) >= size:
            return m[..., :size, :size]
        if shape[-1:] in ((), (1,)):
            # Of one number the diagonal.
            parts = [m if row == column else 0.0 for column in range(size) for row in range(size)]
        else:
            raise FormulaError(
                f"{name} of an array of shape {shape}",
                remedy=f"give it one number, a larger matrix, or {size * size} components",
            )
    together = _take_components(name, size * size, parts)
    columns = [together[..., n * size : (n + 1) * size, None] for n in range(size)]
    return stack(columns, -1)


def mat2(*parts: Value) -> Value:
    """Two columns, or their four components; one number on the diagonal; or the upper left of a
    larger matrix."""
    return _matrix(2, parts)


def mat3(*parts: Value) -> Value:
    """Three columns (tangent, bitangent, …), or their nine components; one number on the diagonal;
    or the upper left of a larger matrix."""
    return _matrix(3, parts)


def mat4(*parts: Value) -> Value:
    """Four columns, or their sixteen components; one number on the diagonal.

    >>> mat4(1.0)[2]
    array([0., 0., 1., 0.])
    """
    return _matrix(4, parts)


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
    """The value as a band if it is made of bands, else None."""
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


class Elements(list[Any]):
    """An array's elements: a list that integers of a shader choose from, too.

    An index that is not known exactly gives the hull of all elements that it may choose; one
    outside of the array anything, as GLSL leaves it undefined.
    """

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, Integer):
            return self._choose(index)
        if isinstance(index, Band | np.ndarray | float):
            raise FormulaError("an array's index is a float", remedy="index by int(x)")
        return super().__getitem__(index)

    def _choose(self, index: Integer) -> Any:
        outside = (index.lo < 0) | (index.hi >= len(self)) | index.anything
        if index.known and index.lo.size == 1 and not outside.any():
            return self[int(index.lo.reshape(-1)[0])]
        chosen = self[-1]
        for number, element in enumerate(self[:-1]):
            chosen = _choose_elements(equal(index, number), element, chosen)
        if isinstance(chosen, Integer):
            return chosen.derive(
                chosen.lo, None if chosen.known else chosen.hi, index, anything=outside
            )
        return mark_undefined(chosen, outside) if isinstance(chosen, Band) else chosen


def array(*elements: Value) -> Elements:
    """A table to index, as `float[]`, `vec3[]` and `int[]` make in GLSL; of one list or NumPy array
    its elements. Python's integers are `int`s.

    >>> array(0.25, 0.5, 1.0)[1]
    0.5
    >>> array(8, 2, 10)[Integer([0, 2])].lo.tolist()
    [8, 10]
    """
    if len(elements) == 1 and isinstance(elements[0], list | tuple | np.ndarray):
        elements = tuple(elements[0])
    if not elements:
        raise FormulaError("an array has at least one element")
    return Elements(_make_element(element) for element in elements)


def _make_element(value: Value) -> Value:
    if isinstance(value, list | tuple):
        return array(value)
    kind = np.asarray(value).dtype.kind if isinstance(value, int | np.integer | np.ndarray) else ""
    return Integer(value, unsigned=kind == "u") if kind in ("i", "u") else value


def _choose_elements(condition: Any, a: Value, b: Value) -> Value:
    """`where`, element by element of arrays in an array."""
    if isinstance(a, Sequence):
        return Elements(_choose_elements(condition, x, y) for x, y in zip(a, b, strict=True))
    return where(condition, a, b)
