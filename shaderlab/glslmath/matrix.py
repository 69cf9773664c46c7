"""Matrices (GLSL 4.60, 8.6), written as in mathematics: m[..., row, column].

GLSL's `m * v` is `mul(m, v)` and `a * b` is `matmul(a, b)`: NumPy's `*` goes by component, and its
`@` can't tell four per-pixel vectors from a 4×4 matrix.
"""

from __future__ import annotations

import numpy as np

from shaderlab.bands import exact, sums
from shaderlab.errors import FormulaError
from shaderlab.glslmath.dispatch import Value, applied, number
from shaderlab.glslmath.shape import stacked


def mul(m: Value, v: Value) -> Value:
    """m·v for matrices (…, r, c) and vectors (…, c): vectors (…, r).

    >>> mul(np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[1.0, 0.0], [0.0, 1.0]]))
    array([[ 0.,  1.],
           [-1.,  0.]])
    """
    return applied(lambda m, v: np.matmul(m, v[..., None])[..., 0], sums.times_vector, m, v)


def matmul(a: Value, b: Value) -> Value:
    """a·b for matrices (…, r, k) and (…, k, c): matrices (…, r, c)."""
    return applied(np.matmul, sums.times_matrix, a, b)


def matrixCompMult(a: Value, b: Value) -> Value:
    """The product element by element."""
    return number(a) * number(b)


def outerProduct(column: Value, row: Value) -> Value:
    """column · rowᵀ, (…, r) and (…, c): matrices (…, r, c)."""
    return number(column)[..., :, None] * number(row)[..., None, :]


def transpose(m: Value) -> Value:
    """Rows and columns exchanged; exact."""
    return applied(lambda a: np.swapaxes(a, -1, -2), exact.transposed, m)


def determinant(m: Value) -> Value:
    """The determinant (…, 1), expanded along the first row; GLSL states no precision of its own."""
    m = number(m)
    size = _size(m)
    if size == 2:
        value = _at(m, 0, 0) * _at(m, 1, 1) - _at(m, 0, 1) * _at(m, 1, 0)
    else:
        value = sum(_at(m, 0, j) * _cofactor(m, 0, j) for j in range(size))
    return value


def inverse(m: Value) -> Value:
    """The inverse by cofactors over the determinant; undefined for a singular matrix."""
    m = number(m)
    size = _size(m)
    rows = [stacked([_cofactor(m, j, i) for j in range(size)], -1) for i in range(size)]
    adjugate = stacked([row[..., None, :] for row in rows], -2)
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
