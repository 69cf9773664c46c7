"""Constants of a shader's source, with what a compiler may make of them before the shader runs."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from shaderlab.bands import arithmetic
from shaderlab.bands.band import Band
from shaderlab.bands.exact import union

from .rounding import Rules


class Literal(float):
    """A float constant that remembers which float32 it may be; `band` has shape (1,).

    Where `0.52 - 0.02` stands in a shader, some compilers compute it in float32, whose result is
    not ½, and some in float64, whose result is: the band of a sum, product or quotient of
    literals holds both. To everything but bands and `shaderlab.glslmath` it is a plain float.

    >>> half = Literal.of(0.52) - Literal.of(0.02)
    >>> half == 0.5, bool(half.band.lo[0] < 0.5 < half.band.hi[0])
    (True, True)
    """

    __slots__ = ("band",)
    band: Band

    @classmethod
    def of(cls, value: float, rules: Rules | None = None) -> Literal:
        """The constant as it is written: exact if it is a float32, else both neighbours."""
        made = cls(value)
        made.band = Band.literal(value, rules or Rules())
        return made

    @classmethod
    def folded(cls, value: float, band: Band) -> Literal:
        """What a compiler makes of constants: `value` in float64, or anything in `band`."""
        made = cls(value)
        # No compiler rearranges what it has computed exactly.
        exact = band.lo is band.hi
        made.band = band.opaque() if exact else union(band, Band.literal(value, band.rules))
        return made

    def as_band(self, rules: Rules) -> Band:
        """The band under these rules."""
        own = self.band.rules
        return self.band if rules is own or rules == own else Band.literal(float(self), rules)

    def __pow__(self, other: Any, modulo: None = None) -> Any:
        return Literal.of(float(self) ** float(other), self.band.rules)

    def __neg__(self) -> Literal:
        return Literal.folded(-float(self), -self.band)

    def __pos__(self) -> Literal:
        return self

    def __abs__(self) -> Literal:
        return Literal.folded(abs(float(self)), abs(self.band))


def _both_ways(
    value_of: Callable[[Any, Any], Any], operation: Callable[[Any, Any], Any]
) -> tuple[Any, Any]:
    """An operation on floats, and on bands, as a literal's operator, and with the literal on the
    right."""

    def straight(self: Literal, other: Any) -> Any:
        if type(other) not in (float, int, Literal):
            return NotImplemented
        value = value_of(float(self), float(other))
        return Literal.folded(value, operation(self.band, self.band.lift(other)))

    def reflected(self: Literal, other: Any) -> Any:
        if type(other) not in (float, int):
            return NotImplemented
        value = value_of(float(other), float(self))
        return Literal.folded(value, operation(self.band.lift(other), self.band))

    return straight, reflected


for _name, _value_of, _operation in (
    ("add", operator.add, arithmetic.add),
    ("sub", operator.sub, arithmetic.subtract),
    ("mul", operator.mul, arithmetic.multiply),
    ("truediv", operator.truediv, arithmetic.divide),
):
    _straight, _reflected = _both_ways(_value_of, _operation)
    setattr(Literal, f"__{_name}__", _straight)
    setattr(Literal, f"__r{_name}__", _reflected)
