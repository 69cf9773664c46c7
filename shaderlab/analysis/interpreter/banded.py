"""Floats as bands: what the precision rules allow each instruction."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab import glslmath
from shaderlab.bands import Band, Rules
from shaderlab.bands.arithmetic import scaled
from shaderlab.bands.rounding import is_power_of_two

from .arithmetic import Floats

# A float32 that needs more digits was computed by the compiler: another one may round otherwise.
_DIGITS, _COMPUTED = 8, 3.0


@dataclass(frozen=True)
class Bands:
    """The `Arithmetic` of `shaderlab.bands`, under some precision rules."""

    rules: Rules = field(default_factory=Rules)
    name: str = "band"

    def exact(self, values: Any) -> Floats:
        return Band.exact(values, self.rules)

    def literal(self, value: float) -> Floats:
        """The hull of the decimal number's neighbours, as in a reference; 3 ULP around one with
        so many digits that the compiler must have computed it of others."""
        shown = np.format_float_scientific(np.float32(value), trim="-")
        digits = shown.split("e")[0].replace(".", "").replace("-", "")
        if len(digits) < _DIGITS or value == round(value):
            return Band.literal(np.full((1, 1), float(shown)), self.rules)
        give = _COMPUTED * float(np.spacing(np.abs(np.float32(value))))
        middle = np.full((1, 1), float(value))
        return Band.between(middle - give, middle + give, self.rules)

    def undefined(self) -> Floats:
        return Band.exact(np.full((1, 1), np.nan), self.rules)

    def call(self, function: str, *values: Any) -> Any:
        own = _OPERATORS.get(function)
        return getattr(glslmath, function)(*values) if own is None else own(*values)

    def rounded(self, value: Any) -> Any:
        return value


def _add(a: Any, b: Any) -> Any:
    """a + b. Nothing is added to the zero that a loop's sum begins with."""
    if _is_zero(a) and b.shape[-1] == a.shape[-1]:
        return b
    return a + b


def _is_zero(value: Any) -> bool:
    return value.shape[0] == 1 and value.terms is None and not (value.lo.any() or value.hi.any())


def _multiply(a: Any, b: Any) -> Any:
    """a · b. Times 0 or a power of two, as `step` gives them, nothing is rounded."""
    for scale, other in ((a, b), (b, a)):
        exact = scale.lo is scale.hi and scale.terms is None and scale.lo.size
        # The first value of most inputs shows already that they are no powers of two.
        if exact and is_power_of_two(scale.lo.flat[0]) and is_power_of_two(scale.lo):
            return scaled(other, scale)
    return a * b


_OPERATORS: Mapping[str, Callable[..., Any]] = {
    "add": _add,
    "subtract": operator.sub,
    "multiply": _multiply,
    "divide": operator.truediv,
    "negate": operator.neg,
    "remainder": lambda a, b: a - b * glslmath.trunc(a / b),
}
