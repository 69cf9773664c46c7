"""Vectors, matrices and tables: GLSL's constructors and components, and its geometric and matrix
functions (GLSL 4.60, 5.4, 8.5, 8.6).

Vectors lie along the last axis, which `dot`, `length` and `distance` keep with size 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, arithmetic, exact, functions
from shaderlab.bands.bounds import SETS, as_vector, components
from shaderlab.bands.exact import concatenate, join
from shaderlab.bands.rounding import LARGEST, SMALLEST_NORMAL
from shaderlab.errors import FormulaError

from .choice import equal, where
from .dispatch import Value, apply, as_bands, as_number, mark_undefined
from .scalar import clamp, max, sqrt

__all__ = [
    "array", "cross", "determinant", "distance", "dot", "faceforward", "inverse", "length",
    "mat2", "mat3", "mat4", "matmul", "matrixCompMult", "mul", "normalize", "outerProduct",
    "reflect", "refract", "swizzle", "transpose", "vec2", "vec3", "vec4",
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


# What rounding may add to a component of a unit vector, in both of its expansions.
_BEYOND_UNIT = 1.0 + 16 * 2.0**-23


def dot(a: Value, b: Value) -> Value:
    """a·b: the sum of the products, in any order; of one value with itself not negative.

    >>> dot(np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]))
    array([32.])
    """

    def plain(a: Value, b: Value) -> Value:
        return np.sum(np.atleast_1d(a * b), axis=-1, keepdims=True)

    return apply(plain, arithmetic.dot, a, b)


def length(v: Value) -> Value:
    """√(v·v).

    >>> length(np.array([3.0, 4.0]))
    array([5.])
    """
    return sqrt(dot(v, v))


def distance(a: Value, b: Value) -> Value:
    """length(a - b)."""
    return length(as_number(a) - as_number(b))


def normalize(v: Value) -> Value:
    """v / length(v), or v · inversesqrt(v·v): bands allow both; undefined for length 0.

    >>> normalize(np.array([3.0, 4.0]))
    array([0.6, 0.8])
    """

    def plain(v: Value) -> Value:
        return v / length(v)

    def on_bands(v: Band) -> Band:
        if v.direction is None:
            v.direction = direction(v.without_terms())
        return v.direction.copy_independent()

    return apply(plain, on_bands, v)


def direction(v: Band) -> Band:
    """The unit vector of a band that is no sum."""
    squared = arithmetic.sum_last(arithmetic.multiply(v, v))
    quotient = arithmetic.divide(v, functions.sqrt(squared))
    product = arithmetic.multiply(v, functions.inversesqrt(squared))
    either: Band = clamp(exact.union(quotient, product), -_BEYOND_UNIT, _BEYOND_UNIT)
    # A sum of squares that overflows may be the largest number, and what is divided by it is large.
    return mark_undefined(either, (squared.lo < SMALLEST_NORMAL) | (squared.hi > LARGEST))


def cross(a: Value, b: Value) -> Value:
    """a × b of three-component vectors.

    >>> cross(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    array([0., 0., 1.])
    """
    a, b = as_number(a), as_number(b)
    if a.shape[-1:] != (3,) or b.shape[-1:] != (3,):
        raise FormulaError(f"cross takes vectors of three components, not {a.shape}, {b.shape}")
    yzx, zxy = [1, 2, 0], [2, 0, 1]
    return a[..., yzx] * b[..., zxy] - a[..., zxy] * b[..., yzx]


def faceforward(n: Value, incident: Value, reference: Value) -> Value:
    """n if reference·incident < 0, else -n."""
    n = as_number(n)
    return where(dot(reference, incident) < 0.0, n, -n)


def reflect(incident: Value, n: Value) -> Value:
    """incident - 2·(n·incident)·n, for a unit vector n."""
    incident, n = as_number(incident), as_number(n)
    return incident - 2.0 * dot(n, incident) * n


def refract(incident: Value, n: Value, eta: Value) -> Value:
    """The refracted unit vector by Snell's law with ratio of indices eta, or 0 (total reflection).

    k = 1 - eta²·(1 - (n·i)²); k < 0 gives 0, else eta·i - (eta·(n·i) + √k)·n.
    """
    incident, n, eta = as_number(incident), as_number(n), as_number(eta)
    cos_theta = dot(n, incident)
    k = 1.0 - eta * eta * (1.0 - cos_theta * cos_theta)
    through = eta * incident - (eta * cos_theta + sqrt(max(k, 0.0))) * n
    return where(k < 0.0, 0.0, through)


def mul(m: Value, v: Value) -> Value:
    """m·v for matrices (…, r, c) and vectors (…, c): vectors (…, r).

    >>> mul(np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[1.0, 0.0], [0.0, 1.0]]))
    array([[ 0.,  1.],
           [-1.,  0.]])
    """
    return apply(lambda m, v: np.matmul(m, v[..., None])[..., 0], arithmetic.times_vector, m, v)


def matmul(a: Value, b: Value) -> Value:
    """a·b for matrices (…, r, k) and (…, k, c): matrices (…, r, c)."""
    return apply(np.matmul, arithmetic.times_matrix, a, b)


def matrixCompMult(a: Value, b: Value) -> Value:
    """The product element by element."""
    return as_number(a) * as_number(b)


def outerProduct(column: Value, row: Value) -> Value:
    """column · rowᵀ, (…, r) and (…, c): matrices (…, r, c)."""
    return as_number(column)[..., :, None] * as_number(row)[..., None, :]


def transpose(m: Value) -> Value:
    """Rows and columns exchanged; exact."""
    return apply(lambda a: np.swapaxes(a, -1, -2), exact.transpose, m)


def determinant(m: Value) -> Value:
    """The determinant (…, 1), expanded along the first row; GLSL states no precision of its own."""
    m = as_number(m)
    size = _size(m)
    if size == 2:
        value = _at(m, 0, 0) * _at(m, 1, 1) - _at(m, 0, 1) * _at(m, 1, 0)
    else:
        value = sum(_at(m, 0, j) * _cofactor(m, 0, j) for j in range(size))
    return value


def inverse(m: Value) -> Value:
    """The inverse by cofactors over the determinant; undefined for a singular matrix."""
    m = as_number(m)
    size = _size(m)
    rows = [stack([_cofactor(m, j, i) for j in range(size)], -1) for i in range(size)]
    adjugate = stack([row[..., None, :] for row in rows], -2)
    with np.errstate(all="ignore"):
        return adjugate / determinant(m)[..., None]


def _size(m: Value) -> int:
    size = int(m.shape[-1]) if m.ndim >= 2 else 0
    if size not in (2, 3, 4) or m.shape[-2] != size:
        raise FormulaError(f"no square matrix of size 2, 3 or 4: shape {m.shape}")
    return size


def _at(m: Value, i: int, j: int) -> Value:
    return m[..., i, j : j + 1]


def _cofactor(m: Value, i: int, j: int) -> Value:
    """The signed determinant (…, 1) of m without row i and column j."""
    size = m.shape[-1]
    rows = [k for k in range(size) if k != i]
    columns = [k for k in range(size) if k != j]
    sign = 1.0 if (i + j) % 2 == 0 else -1.0
    if size == 2:
        return sign * _at(m, rows[0], columns[0])
    return sign * determinant(m[..., rows, :][..., :, columns])


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
    if isinstance(a, Sequence):
        return Elements(_choose_elements(condition, x, y) for x, y in zip(a, b, strict=True))
    return where(condition, a, b)
