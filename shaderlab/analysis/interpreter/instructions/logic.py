"""Conditions: comparisons of floats, logic, and choosing by a condition."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import Any

from shaderlab import glslmath
from shaderlab.bands import Truth
from shaderlab.bands.truth import as_truth

from ..values import select
from .handler import Handler, of_values


def _comparing(function: Any) -> Handler:
    return of_values(lambda *values: as_truth(function(*values)))


def _different(a: Truth, b: Truth) -> Truth:
    return (a & ~b) | (~a & b)


LOGIC: Mapping[int, Handler] = {
    154: of_values(Truth.any),
    155: of_values(Truth.all),
    156: _comparing(glslmath.isnan),
    157: _comparing(glslmath.isinf),
    164: of_values(lambda a, b: ~_different(a, b)),
    165: of_values(_different),
    166: of_values(operator.or_),
    167: of_values(operator.and_),
    168: of_values(operator.invert),
    169: of_values(select),
    180: _comparing(operator.eq),
    182: _comparing(operator.ne),
    183: _comparing(operator.ne),
    184: _comparing(operator.lt),
    186: _comparing(operator.gt),
    188: _comparing(operator.le),
    190: _comparing(operator.ge),
}
"""The comparisons are those that glslang writes: ordered ones, and != that holds for NaN."""
