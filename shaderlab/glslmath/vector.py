"""GLSL's geometric functions (GLSL 4.60, 8.5). Vectors lie along the last axis, which `dot`,
`length` and `distance` keep with size 1.
"""

from __future__ import annotations

import numpy as np

from shaderlab.bands import Band, arithmetic, exact, functions
from shaderlab.bands.rounding import SMALLEST_NORMAL
from shaderlab.errors import FormulaError

from .arrays import stack
from .choice import where
from .dispatch import Value, apply, as_number, mark_undefined
from .scalar import clamp, max, sqrt

__all__ = [
    "cross", "determinant", "distance", "dot", "faceforward", "inverse", "length", "matmul",
    "matrixCompMult", "mul", "normalize", "outerProduct", "reflect", "refract", "transpose",
]  # fmt: skip

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
    squared = arithmetic.sum_last(arithmetic.square(v))
    quotient = arithmetic.divide(v, functions.sqrt(squared))
    product = arithmetic.multiply(v, functions.inversesqrt(squared))
    either: Band = clamp(exact.union(quotient, product), -_BEYOND_UNIT, _BEYOND_UNIT)
    return mark_undefined(either, squared.lo < SMALLEST_NORMAL)


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
