"""What Python's operators do to integers: GLSL's arithmetic, shifts, bits and comparisons.

Source: the OpenGL Shading Language 4.60 (Khronos), 5.9 "Expressions".
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands.rounding import Flags
from shaderlab.bands.truth import Truth
from shaderlab.errors import FormulaError

if TYPE_CHECKING:
    from shaderlab.bands.integer import Integer

Integers = npt.NDArray[np.int64]
WHOLE = "glslmath.int(x) makes an integer; where(c, 1, 2) and abs(3) of numbers alone give floats"
RANGE = 2**32
# Products of bounds below this are exact in float64, and far from int64's ends.
_EXACT = 2.0**53


def _add(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    return a.lo + b.lo, a.hi + b.hi, None


def _subtract(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    return a.lo - b.hi, a.hi - b.lo, None


def _multiply(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    if a.known and b.known:
        # int64 wraps at 2^64, which leaves the lower 32 bits right.
        return a.lo * b.lo, None, None
    corners = [x * y for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    sizes = [np.abs(x.astype(np.float64) * y) for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    far = np.maximum.reduce(sizes) >= _EXACT
    low, high = np.minimum.reduce(corners), np.maximum.reduce(corners)
    return np.where(far, 0, low), np.where(far, RANGE - 1, high), None


def _divide(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    """Truncated; by zero, nothing is defined."""
    undefined = (b.lo <= 0) & (b.hi >= 0)
    divisors = [np.where(undefined, 1, bound) for bound in (b.lo, b.hi)]
    corners = [_quotient(x, y) for x in (a.lo, a.hi) for y in divisors]
    return np.minimum.reduce(corners), np.maximum.reduce(corners), undefined


def _quotient(a: Integers, b: Integers) -> Integers:
    found: Integers = np.abs(a) // np.abs(b) * np.sign(a) * np.sign(b)
    return found


def _remainder(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    """a - b·(a / b); not defined where either may be negative, or b zero."""
    undefined = (a.lo < 0) | (b.lo <= 0)
    if a.known and b.known:
        return a.lo % np.where(undefined, 1, b.lo), None, undefined
    return np.zeros_like(a.lo * b.lo), np.minimum(a.hi, np.maximum(b.hi - 1, 0)), undefined


def _shift_left(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    undefined = (b.lo < 0) | (b.hi > 31)
    low, high = (np.int64(1) << np.clip(bound, 0, 31) for bound in (b.lo, b.hi))
    if a.known and b.known:
        return a.lo * low, None, undefined
    corners = [x * y for x in (a.lo, a.hi) for y in (low, high)]
    return np.minimum.reduce(corners), np.maximum.reduce(corners), undefined


def _shift_right(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    undefined = (b.lo < 0) | (b.hi > 31)
    corners = [x >> np.clip(y, 0, 31) for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    return np.minimum.reduce(corners), np.maximum.reduce(corners), undefined


def _bitwise(operation: Callable[[Any, Any], Any]) -> Callable[..., tuple[Any, Any, Any]]:
    def bits(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
        if a.known and b.known:
            return operation(a.lo, b.lo), None, None
        low = np.zeros(np.broadcast_shapes(a.shape, b.shape), np.int64)
        return low, low + RANGE - 1, None

    return bits


# By Python's name: what integers do, what floats do, and whether the left operand alone decides
# whether the result is unsigned.
_OPERATIONS: dict[str, tuple[Any, Any, bool]] = {
    "add": (_add, operator.add, False),
    "sub": (_subtract, operator.sub, False),
    "mul": (_multiply, operator.mul, False),
    "truediv": (_divide, operator.truediv, False),
    "mod": (_remainder, None, False),
    "and": (_bitwise(operator.and_), None, False),
    "or": (_bitwise(operator.or_), None, False),
    "xor": (_bitwise(operator.xor), None, False),
    "lshift": (_shift_left, None, True),
    "rshift": (_shift_right, None, True),
}


def _both_ways(name: str) -> tuple[Any, Any]:
    whole, floating, left_alone = _OPERATIONS[name]

    def of(a: Integer, b: Integer) -> Integer:
        unsigned = a.unsigned or (b.unsigned and not left_alone)
        if not left_alone:
            a, b = a.converted(unsigned), b.converted(unsigned)
        lo, hi, undefined = whole(a, b)
        hi = None if hi is None or (a.known and b.known) else hi
        return a.made(lo, hi, b, anything=undefined, unsigned=unsigned)

    def applied(self: Integer, other: Any, left: bool) -> Any:
        lifted = self.lift(other)
        if lifted is not None:
            return of(self, lifted) if left else of(lifted, self)
        if floating is None:
            raise FormulaError(f"GLSL has no {name} of an integer and a float", remedy=WHOLE)
        number = self.to_float()
        return floating(number, other) if left else floating(other, number)

    return lambda a, b: applied(a, b, True), lambda a, b: applied(a, b, False)


def _less(a: Integer, b: Integer) -> tuple[Flags, Flags]:
    return a.hi < b.lo, a.lo >= b.hi


def _equal(a: Integer, b: Integer) -> tuple[Flags, Flags]:
    return (a.lo == b.hi) & (a.hi == b.lo), (a.hi < b.lo) | (b.hi < a.lo)


def _comparison(compared: Any, floating: Any, *, swapped: bool, negated: bool) -> Any:
    def compare(self: Integer, other: Any) -> Any:
        lifted = self.lift(other)
        if lifted is None:
            return floating(self.to_float(), other)
        unsigned = self.unsigned or lifted.unsigned
        pair = self.converted(unsigned), lifted.converted(unsigned)
        yes, no = compared(*(reversed(pair) if swapped else pair))
        rules = self.rules or lifted.rules
        if rules is None:
            return no if negated else yes
        open_ = self.anything | lifted.anything
        truth = Truth(yes & ~open_, no & ~open_, rules)
        return ~truth if negated else truth

    return compare


class IntegerOperators:
    """The operators of `Integer`."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]


for _name in _OPERATIONS:
    _straight, _reflected = _both_ways(_name)
    setattr(IntegerOperators, f"__{_name}__", _straight)
    setattr(IntegerOperators, f"__r{_name}__", _reflected)
for _name, _compared, _swapped, _negated in (
    ("lt", _less, False, False),
    ("ge", _less, False, True),
    ("gt", _less, True, False),
    ("le", _less, True, True),
    ("eq", _equal, False, False),
    ("ne", _equal, False, True),
):
    setattr(
        IntegerOperators,
        f"__{_name}__",
        _comparison(_compared, getattr(operator, _name), swapped=_swapped, negated=_negated),
    )
