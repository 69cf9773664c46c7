"""The compiled passes over bands (`kernels/`), where they were built; NumPy does the rest.

An operation takes some twelve NumPy loops and as many temporary arrays; compiled it is one pass.
Both give the same numbers. They are built on installation where there is a C compiler;
`SHADERLAB_BANDS=numpy` leaves them aside.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any

from shaderlab.bands.terms import Terms

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


def compiled(plain: Callable[..., Band]) -> Callable[..., Band]:
    """An operation on bands by its compiled pass, and `plain` where that finds something rare."""
    kernel = getattr(KERNELS, plain.__name__, None)
    if kernel is None:
        return plain

    @wraps(plain)
    def by_kernel(*bands: Band) -> Band:
        rules = bands[0].rules
        found = kernel(*bands, rules.flush, rules.rearrange)
        if found is None:
            return plain(*bands)
        lo, hi, mag, slack, count = found
        terms = None if mag is None else Terms(mag, slack, count)
        return bands[0].kept(lo, hi, *bands[1:], terms=terms)

    return by_kernel
