"""Dispatch between bands and plain numbers, so that one function serves both."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from shaderlab.bands import Band, Integer, Literal, TriBool

__all__ = ["Condition", "Value"]

# A Python number, a float64 array whose last axis is the components, or a Band.
Value: TypeAlias = Any
# A Python bool, a boolean array, or a TriBool.
Condition: TypeAlias = Any
_OF_THE_SHADER = (Band, Literal, Integer)


def as_number(value: Value) -> Value:
    """A band, literal or integer as it is, else float64: dividing by zero then follows IEEE 754."""
    if isinstance(value, _OF_THE_SHADER):
        return value
    return np.asanyarray(value, dtype=np.float64)[()]


def as_bands(*values: Value) -> list[Band] | None:
    """All values as bands if one of them is a band, a literal or a band's integer, else None."""
    for value in values:
        if isinstance(value, Band):
            return [value.lift(other) for other in values]
    for value in values:
        if isinstance(value, Literal):
            return [value.band.lift(other) for other in values]
        if isinstance(value, Integer) and value.rules is not None:
            band = value.as_band(value.rules)
            return [band.lift(other) for other in values]
    return None


def as_integers(*values: Value) -> list[Integer] | None:
    """All values as integers of one type if one is an `Integer` and no other is a float."""
    for value in values:
        if isinstance(value, Integer):
            lifted = [value.lift(other) for other in values]
            unsigned = any(n is not None and n.unsigned for n in lifted)
            found = [n.convert(unsigned) for n in lifted if n is not None]
            return found if len(found) == len(values) else None
    return None


def apply(
    plain: Callable[..., Any],
    on_bands: Callable[..., Band | TriBool],
    *values: Value,
    on_integers: Callable[..., Integer] | None = None,
) -> Any:
    """`on_bands` of the values as bands if one is a band, else `plain` of them as float64; of
    integers `on_integers`, if there is such a function.

    Of literals it is both: a compiler may compute them, in float64 or as the device does.
    """
    whole = None if on_integers is None else as_integers(*values)
    if on_integers is not None and whole is not None:
        return on_integers(*whole)
    for value in values:
        if isinstance(value, Band):
            return on_bands(*[o if o is value else value.lift(o) for o in values])
    lifted = as_bands(*values)
    band = None if lifted is None else on_bands(*lifted)
    if band is not None and not all(isinstance(value, int | float) for value in values):
        return band
    with np.errstate(all="ignore"):
        result = plain(*(np.asanyarray(value, dtype=np.float64)[()] for value in values))
    if isinstance(band, Band):
        return Literal.fold(float(result), band) if np.ndim(result) == 0 else band
    return result if band is None else band


def mark_undefined(band: Band, where: Any) -> Band:
    """The band with anything allowed where GLSL leaves a function's result undefined."""
    return band.derive(band.lo, band.hi, anything=where, terms=band.terms) if where.any() else band
