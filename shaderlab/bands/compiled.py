"""The compiled passes over bands (`kernels/`), where they were built; NumPy does the rest.

An operation takes some twelve NumPy loops and as many temporary arrays; compiled it is one pass.
Both give the same numbers. They are built on installation where there is a C compiler;
`SHADERLAB_BANDS=numpy` leaves them aside.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import TYPE_CHECKING, Any, TypeVar, cast

if TYPE_CHECKING:
    from shaderlab.bands.band import Band

VARIABLE = "SHADERLAB_BANDS"


def left_aside() -> bool:
    """Whether the environment asks for NumPy."""
    return os.environ.get(VARIABLE) == "numpy"


def _built() -> Any:
    """The extension module, or None."""
    if left_aside():
        return None
    try:
        return importlib.import_module("shaderlab.bands._kernels")
    except ImportError:
        return None


KERNELS = _built()


class _Use:
    """Whether the passes are used where there are any."""

    passes = True


@contextmanager
def numpy_alone() -> Iterator[None]:
    """All is done by NumPy meanwhile: for comparisons of both."""
    _Use.passes = False
    try:
        yield
    finally:
        _Use.passes = True


def compiled(plain: Callable[..., Band]) -> Callable[..., Band]:
    """An operation on bands by its compiled pass, and `plain` where that finds something rare."""
    # Terms stand on what `compiled_arrays` makes faster.
    from shaderlab.bands.terms import Terms

    kernel = getattr(KERNELS, plain.__name__, None)
    if kernel is None:
        return plain
    over_last = plain.__name__ == "sum_last"

    @wraps(plain)
    def by_kernel(*bands: Band) -> Band:
        first = bands[0]
        rules = first.rules
        found = kernel(*bands, rules.flush, rules.rearrange) if _Use.passes else None
        if found is None:
            return plain(*bands)
        lo, hi, mag, slack, count, *reach = found
        terms = None if mag is None else Terms(mag, slack, count, *reach)
        carrier = first.flags_over_last() if over_last else first
        return carrier.kept(lo, hi, *bands[1:], terms=terms)

    return by_kernel


OfArrays = TypeVar("OfArrays", bound=Callable[..., Any])


def compiled_arrays(plain: OfArrays) -> OfArrays:
    """The same for a function that gives arrays."""
    kernel = getattr(KERNELS, plain.__name__, None)
    if kernel is None:
        return plain

    @wraps(plain)
    def by_kernel(*arguments: Any) -> Any:
        found = kernel(*arguments) if _Use.passes else None
        return plain(*arguments) if found is None else found

    return cast(OfArrays, by_kernel)
