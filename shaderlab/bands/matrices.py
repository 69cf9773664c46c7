"""Products of matrices and vectors of bands: each element a sum of products, in any order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shaderlab.bands import arithmetic
from shaderlab.errors import FormulaError

if TYPE_CHECKING:
    from shaderlab.bands.band import Band


def times_vector(m: Band, v: Band) -> Band:
    """m · v for matrices (…, r, c) and vectors (…, c): vectors (…, r)."""
    if m.ndim < 2 or v.shape[-1] != m.shape[-1]:
        raise FormulaError(f"no product of a matrix {m.shape} and a vector {v.shape}")
    products = arithmetic.multiply(m, v[..., None, :])
    return arithmetic.sum_last(products)[..., 0]


def times_matrix(a: Band, b: Band) -> Band:
    """a · b for matrices (…, r, k) and (…, k, c): matrices (…, r, c)."""
    if a.ndim < 2 or b.ndim < 2 or a.shape[-1] != b.shape[-2]:
        raise FormulaError(f"no product of matrices {a.shape} and {b.shape}")
    products = arithmetic.multiply(a[..., :, None, :], transposed(b)[..., None, :, :])
    return arithmetic.sum_last(products)[..., 0]


def transposed(m: Band) -> Band:
    """The matrices (…, r, c) with rows and columns exchanged."""
    return m.mapped(lambda array: array.swapaxes(-1, -2))


def matmul(a: Band, b: Band) -> Band:
    """NumPy's `a @ b`: b is a vector if it has one axis, or if its rows don't fit a's columns."""
    if b.ndim == 1 or (b.shape[-1] == a.shape[-1] != b.shape[-2]):
        return times_vector(a, b)
    if a.ndim == 1:
        return times_vector(transposed(b), a)
    return times_matrix(a, b)
