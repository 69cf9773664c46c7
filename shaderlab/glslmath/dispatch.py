"""Dispatch between bands and plain numbers, so that one function serves both."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from shaderlab.bands import Band, Truth

# A Python number, a float64 array whose last axis is the components, or a Band.
Value: TypeAlias = Any
# A Python bool, a boolean array, or a Truth.
Condition: TypeAlias = Any


def number(value: Value) -> Value:
    """A band as it is, anything else as float64: dividing by zero then follows IEEE 754."""
    return value if isinstance(value, Band) else np.asarray(value, dtype=np.float64)[()]


def bands(*values: Value) -> list[Band] | None:
    """All values as bands if one of them is a band, else None."""
    for value in values:
        if isinstance(value, Band):
            return [value.lift(other) for other in values]
    return None


def applied(plain: Callable[..., Any], banded: Callable[..., Band | Truth], *values: Value) -> Any:
    """`banded` of the values as bands if one is a band, else `plain` of them as float64."""
    lifted = bands(*values)
    if lifted is not None:
        return banded(*lifted)
    with np.errstate(all="ignore"):
        return plain(*map(number, values))
