"""The compiled passes over bands (`kernels/`), where they were built; NumPy does the rest.

An operation takes some twelve NumPy loops and as many temporary arrays; compiled it is one pass.
Both give the same numbers. They are built on installation where there is a C compiler;
`SHADERLAB_BANDS=numpy` turns them off.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, TypeVar, cast

VARIABLE = "SHADERLAB_BANDS"
# The same number stands in kernels/_kernels.c.
INTERFACE = 7


def is_turned_off() -> bool:
    """Whether the environment asks for NumPy."""
    return os.environ.get(VARIABLE) == "numpy"


def _load() -> Any:
    """The extension module, or None: not built, turned off, or built from older sources."""
    if is_turned_off():
        return None
    try:
        module = importlib.import_module("shaderlab.bands._kernels")
    except ImportError:
        return None
    return module if getattr(module, "INTERFACE", 1) == INTERFACE else None


KERNELS = _load()
_numpy_alone = False


@contextmanager
def numpy_alone() -> Iterator[None]:
    """Compute everything with NumPy within this context: for comparisons of both."""
    global _numpy_alone
    before, _numpy_alone = _numpy_alone, True
    try:
        yield
    finally:
        _numpy_alone = before


Function = TypeVar("Function", bound=Callable[..., Any])


def use_kernel(plain: Function) -> Function:
    """Compute a function of bands, or of arrays, by the compiled pass of its name, and by `plain`
    where there is no such pass or that meets something rare."""
    kernel = getattr(KERNELS, plain.__name__, None)
    if kernel is None:
        return plain

    @wraps(plain)
    def compute(*operands: Any) -> Any:
        result = None if _numpy_alone else kernel(*operands)
        return plain(*operands) if result is None else result

    return cast(Function, compute)


def use_bands(band: type, terms: type, rules: type, nowhere: tuple[Any, ...]) -> None:
    """Register with the passes what bands are made of; `nowhere` are flags that are set nowhere."""
    if KERNELS is not None:
        KERNELS.use_bands(band, terms, rules, nowhere)
