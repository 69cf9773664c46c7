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
from functools import update_wrapper
from typing import Any, TypeVar, cast

VARIABLE = "SHADERLAB_BANDS"
# Stands in kernels/_kernels.c, too.
INTERFACE = 5


def left_aside() -> bool:
    """Whether the environment asks for NumPy."""
    return os.environ.get(VARIABLE) == "numpy"


def _built() -> Any:
    """The extension module, or None; one that was built of older sources is left aside."""
    if left_aside():
        return None
    try:
        found = importlib.import_module("shaderlab.bands._kernels")
    except ImportError:
        return None
    return found if getattr(found, "INTERFACE", 1) == INTERFACE else None


KERNELS = _built()


@contextmanager
def numpy_alone() -> Iterator[None]:
    """All is done by NumPy meanwhile: for comparisons of both."""
    if KERNELS is None:
        yield
        return
    KERNELS.use(False)
    try:
        yield
    finally:
        KERNELS.use(True)


Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(plain: Function) -> Function:
    """A function of bands, or of arrays, by its compiled pass, and `plain` where that finds
    something rare."""
    if not hasattr(KERNELS, plain.__name__):
        return plain
    return cast(Function, update_wrapper(KERNELS.operation(plain.__name__, plain), plain))


Operator = Callable[[Any, Any], Any]


def operators(operation: Operator, straight: Operator, reflected: Operator) -> tuple[Any, Any]:
    """An operator and its reflected twin: `operation` by its pass where one operand is a band and
    the other a band or literal of its rules, elsewhere the functions given."""
    if KERNELS is None:
        return straight, reflected
    both = enumerate((straight, reflected))
    return tuple(KERNELS.operator(operation, plain, bool(k)) for k, plain in both)


def use_bands(band: type, terms: type, rules: type, truth: type, nowhere: tuple[Any, ...]) -> None:
    """Tell the passes what bands are made of; `nowhere` are flags that are set nowhere."""
    if KERNELS is not None:
        KERNELS.use_bands(band, terms, rules, truth, nowhere)


def use_literals(literal: type) -> None:
    """Tell the passes which numbers have a band of their own."""
    if KERNELS is not None:
        KERNELS.use_literals(literal)
