"""Sums along an axis, whose terms a device may add in any order, and the products made of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands.arithmetic import moved_out, multiply
from shaderlab.bands.compiled import use_kernel
from shaderlab.bands.exact import transposed
from shaderlab.bands.rounding import add_above, add_below, finite
from shaderlab.bands.terms import Terms, least_of, reach_of
from shaderlab.errors import FormulaError

if TYPE_CHECKING:
    from shaderlab.bands.band import Band


@use_kernel
@np.errstate(all="ignore")
def sum_last(a: Band) -> Band:
    """The sum over the last axis (kept, with size 1), its terms added in any order."""
    if a.shape[-1] == 1:
        return a
    a_lo, a_hi = a.settled()
    lo, hi = _over_last(a_lo, add_below), _over_last(a_hi, add_above)
    if a_lo is a_hi and (lo == hi).all():
        hi = lo
    nan = None
    if not finite(lo, hi):
        rises = (a_hi == np.inf).sum(axis=-1, keepdims=True)
        falls = (a_lo == -np.inf).sum(axis=-1, keepdims=True)
        both = ((a_hi == np.inf) & (a_lo == -np.inf)).sum(axis=-1, keepdims=True)
        nan = rises * falls > both
    sizes = a.mag
    mag = _over_last(sizes, np.add)
    # The terms of the products are not counted: no compiler expands a dot product's arguments.
    terms = Terms.of(
        mag,
        lambda: _over_last(np.broadcast_to(reach_of(sizes, a.terms), sizes.shape), np.add),
        a.terms,
        count=a.shape[-1],
    )
    step = terms.step()
    count: Any = float(a.shape[-1])
    no_zeros = least_of(sizes) > 0.0
    if not no_zeros:
        count = _over_last((sizes > 0.0).astype(np.float64), np.add)
    # All partial sums but the last, which `made` rounds, may each lose a step.
    between = np.maximum(count - 2.0, 0.0) * step
    lo, hi = moved_out(
        lo,
        hi,
        between,
        lambda crossed: crossed & _over_last(a_lo >= 0.0, np.logical_and),
        lambda crossed: crossed & _over_last(a_hi <= 0.0, np.logical_and),
    )
    if not a.rules.rearrange:
        return a.flags_over_last().made(lo, hi, nan=nan)
    terms.slack = step if no_zeros else np.where(count >= 2.0, step, 0.0)
    return a.flags_over_last().made(lo, hi, nan=nan, terms=terms)


def _over_last(values: Any, join: Callable[[Any, Any], Any]) -> Any:
    """The components along the last axis, which stays with size 1, joined from first to last.

    They are taken one by one, because NumPy's reductions of so few numbers spend their time
    between them.
    """
    total = values[..., 0:1]
    for j in range(1, values.shape[-1]):
        total = join(total, values[..., j : j + 1])
    return total


def dot(a: Band, b: Band) -> Band:
    """The sum of the products over the last axis (kept, with size 1), in any order."""
    return sum_last(multiply(a, b))


def times_vector(m: Band, v: Band) -> Band:
    """m · v for matrices (…, r, c) and vectors (…, c): vectors (…, r)."""
    if m.ndim < 2 or v.shape[-1] != m.shape[-1]:
        raise FormulaError(f"no product of a matrix {m.shape} and a vector {v.shape}")
    products = multiply(m, v[..., None, :])
    return sum_last(products)[..., 0]


def times_matrix(a: Band, b: Band) -> Band:
    """a · b for matrices (…, r, k) and (…, k, c): matrices (…, r, c)."""
    if a.ndim < 2 or b.ndim < 2 or a.shape[-1] != b.shape[-2]:
        raise FormulaError(f"no product of matrices {a.shape} and {b.shape}")
    products = multiply(a[..., :, None, :], transposed(b)[..., None, :, :])
    return sum_last(products)[..., 0]


def matmul(a: Band, b: Band) -> Band:
    """NumPy's `a @ b`: b is a vector if it has one axis, or if its rows don't fit a's columns."""
    if b.ndim == 1 or (b.shape[-1] == a.shape[-1] != b.shape[-2]):
        return times_vector(a, b)
    if a.ndim == 1:
        return times_vector(transposed(b), a)
    return times_matrix(a, b)
