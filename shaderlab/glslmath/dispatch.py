"""Dispatch between bands and plain numbers, so that one function serves both."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from shaderlab.bands import Band, Literal, Truth

# A Python number, a float64 array whose last axis is the components, or a Band.
Value: TypeAlias = Any
# A Python bool, a boolean array, or a Truth.
Condition: TypeAlias = Any


def number(value: Value) -> Value:
    """A band or a literal as it is, anything else as float64: dividing by zero then follows
    IEEE 754."""
    if isinstance(value, Band | Literal):
        return value
    return np.asarray(value, dtype=np.float64)[()]


def bands(*values: Value) -> list[Band] | None:
    """All values as bands if one of them is a band or a literal, else None."""
    for value in values:
        if isinstance(value, Band):
            return [value.lift(other) for other in values]
    for value in values:
        if isinstance(value, Literal):
            return [value.band.lift(other) for other in values]
    return None


def applied(plain: Callable[..., Any], banded: Callable[..., Band | Truth], *values: Value) -> Any:
    """`banded` of the values as bands if one is a band, else `plain` of them as float64.

    Of literals it is both: a compiler may compute them, in float64 or as the device does.
    """
    for value in values:
        if isinstance(value, Band):
            return banded(*(value.lift(other) for other in values))
    with np.errstate(all="ignore"):
        result = plain(*(np.asarray(value, dtype=np.float64)[()] for value in values))
    lifted = bands(*values)
    if lifted is None:
        return result
    band = banded(*lifted)
    if isinstance(band, Band) and np.ndim(result) == 0:
        return Literal.folded(float(result), band)
    return band


def undefined(band: Band, where: Any) -> Band:
    """The band with anything allowed where GLSL leaves a function's result undefined."""
    return band.made(band.lo, band.hi, anything=where, terms=band.terms) if where.any() else band
