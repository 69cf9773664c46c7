"""What may go wrong in an instruction: GLSL's undefined results, and those that are no number.

Sources: the OpenGL Shading Language 4.60 (Khronos), 5.9 "Expressions", 5.4 "Constructors" and
chapter 8, "Built-In Functions"; SPIR-V Extended Instructions for GLSL 1.00.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

FLOATS = frozenset({12, *range(127, 149)})
"""The opcodes of arithmetic on floats, and of GLSL.std.450."""
_EXTENDED = 12
_INT, _UINT = (-(2.0**31), 2.0**31), (-1.0, 2.0**32)


@dataclass(frozen=True, eq=False)
class Check:
    """One way in which an instruction may go wrong.

    Attributes:
        kind: what it is called.
        margin: of the operands, (count or 1, components): how far each is from going wrong.
        bad: of the margin, where it does.
        words: of one component's operands, what happens.
        crosses: whether the margin has a sign, and 0 alone is bad.
        possible: why it is no hazard by itself: GLSL says what happens, or devices mostly do.
    """

    kind: str
    margin: Callable[..., Any]
    words: Callable[..., str]
    bad: Callable[[Any], Any] = lambda margin: margin < 0.0
    crosses: bool = False
    possible: str = ""


def _at_most_0(margin: Any) -> Any:
    return margin <= 0.0


def _is_0(margin: Any) -> Any:
    return margin == 0.0


def _number(value: float) -> str:
    return f"{value:.6g}"


def _below_0(function: str) -> Check:
    return Check(f"{function} of a negative number", lambda x: x, lambda x: f"{function}({x:.6g})")


def _not_above_0(function: str) -> Check:
    return Check(
        f"{function} of 0 or less", lambda x: x, lambda x: f"{function}({x:.6g})", _at_most_0
    )


def _beyond(function: str) -> Check:
    return Check(
        f"{function} beyond 1",
        lambda x: 1.0 - np.abs(x),
        lambda x: f"{function}({x:.9g}), which is defined for -1..1",
    )


def _conversion(to: str, low: float, high: float) -> Check:
    return Check(
        f"{to} of a number that has none",
        lambda x: np.minimum(x - low, high - x),
        lambda x: f"{to}({x:.6g}), which lies outside of the type's range",
        _at_most_0 if to == "uint" else lambda margin: margin < 0.0,
    )


def _wide_angle(function: str) -> Check:
    return Check(
        f"{function} beyond half a turn",
        lambda x: np.float32(np.pi) - np.abs(x),
        lambda x: f"{function}({x:.6g})",
        possible="the precision rules bound nothing beyond -π..π",
    )


def _wraps(compute: Callable[[Any, Any], Any]) -> Check:
    return Check(
        "integer overflow", lambda a, b: 2.0**31 - 1.0 - np.abs(compute(a, b)),
        lambda a, b: f"{compute(a, b):g} lies beyond 31 bits", possible="it wraps around",
    )  # fmt: skip


def _of_two(name: str) -> Callable[[float, float], str]:
    return lambda a, b: f"{name}({_number(a)}, {_number(b)})"


_DIVISION = Check(
    "division by 0", lambda a, b: b + 0.0 * a, lambda a, b: f"{a:.6g} is divided by 0",
    _is_0, crosses=True,
)  # fmt: skip
_MOD = Check(
    "division by 0", lambda a, b: b + 0.0 * a, lambda a, b: f"mod({a:.6g}, 0)",
    _is_0, crosses=True,
)  # fmt: skip
_POW = Check(
    "pow of a negative number", lambda x, y: x + 0.0 * y,
    lambda x, y: f"pow({x:.6g}, {y:.6g}), whose base is negative",
)  # fmt: skip
_POW_0 = Check(
    "pow of 0 to 0 or less", lambda x, y: np.maximum(np.abs(x), np.maximum(y, 0.0)), _of_two("pow"),
    _is_0,
)  # fmt: skip
_ATAN = Check(
    "atan of nothing", lambda y, x: np.maximum(np.abs(y), np.abs(x)), _of_two("atan"), _is_0
)
_CLAMP = Check(
    "clamp between crossed bounds", lambda x, low, high: high - low + 0.0 * x,
    lambda x, low, high: f"clamp to {low:.6g}..{high:.6g}, whose bounds are crossed",
)  # fmt: skip
_SMOOTHSTEP = Check(
    "smoothstep between crossed edges", lambda low, high, x: high - low + 0.0 * x,
    lambda low, high, x: f"smoothstep from {low:.6g} to {high:.6g}, which is not above it",
    _at_most_0,
)  # fmt: skip
_NORMALIZE = Check(
    "normalize of nothing", lambda v: np.sqrt((v * v).sum(axis=-1, keepdims=True)),
    lambda v: "normalize of a vector of length 0", _is_0,
)  # fmt: skip
_INTEGER_DIVISION = Check(
    "integer division by 0", lambda a, b: np.abs(b) + 0 * a, lambda a, b: f"{a:g} is divided by 0",
    _is_0,
)  # fmt: skip
_REMAINDER = Check(
    "remainder of a negative number", lambda a, b: np.minimum(a, b),
    lambda a, b: f"{a:g} % {b:g}, which is undefined of negative numbers",
)  # fmt: skip
_SHIFT = Check(
    "shift beyond 31 bits", lambda a, b: np.minimum(b, 31 - b) + 0 * a,
    lambda a, b: f"a shift by {b:g} bits",
)  # fmt: skip
_FIELD = Check(
    "bit field outside of 32 bits",
    lambda *parts: np.minimum(np.minimum(parts[-2], parts[-1]), 32 - parts[-2] - parts[-1]),
    lambda *parts: f"a field of {parts[-1]:g} bits from bit {parts[-2]:g} on",
)

CHECKS: Mapping[tuple[int, int], tuple[Check, ...]] = {
    (136, 0): (_DIVISION,),
    (140, 0): (_DIVISION,),
    (141, 0): (_MOD,),
    (109, 0): (_conversion("uint", *_UINT),),
    (110, 0): (_conversion("int", *_INT),),
    (128, 0): (_wraps(operator.add),),
    (130, 0): (_wraps(operator.sub),),
    (132, 0): (_wraps(operator.mul),),
    (134, 0): (_INTEGER_DIVISION,),
    (135, 0): (_INTEGER_DIVISION,),
    (137, 0): (_INTEGER_DIVISION,),
    (138, 0): (_INTEGER_DIVISION, _REMAINDER),
    (139, 0): (_INTEGER_DIVISION, _REMAINDER),
    (194, 0): (_SHIFT,),
    (195, 0): (_SHIFT,),
    (196, 0): (_SHIFT,),
    (201, 0): (_FIELD,),
    (202, 0): (_FIELD,),
    (203, 0): (_FIELD,),
    (_EXTENDED, 13): (_wide_angle("sin"),),
    (_EXTENDED, 14): (_wide_angle("cos"),),
    (_EXTENDED, 16): (_beyond("asin"),),
    (_EXTENDED, 17): (_beyond("acos"),),
    (_EXTENDED, 23): (Check("acosh below 1", lambda x: x - 1.0, lambda x: f"acosh({x:.9g})"),),
    (_EXTENDED, 24): (
        Check("atanh beyond 1", lambda x: 1.0 - np.abs(x), lambda x: f"atanh({x:.9g})", _at_most_0),
    ),
    (_EXTENDED, 25): (_ATAN,),
    (_EXTENDED, 26): (_POW, _POW_0),
    (_EXTENDED, 28): (_not_above_0("log"),),
    (_EXTENDED, 30): (_not_above_0("log2"),),
    (_EXTENDED, 31): (_below_0("sqrt"),),
    (_EXTENDED, 32): (_not_above_0("inversesqrt"),),
    (_EXTENDED, 43): (_CLAMP,),
    (_EXTENDED, 44): (_CLAMP,),
    (_EXTENDED, 45): (_CLAMP,),
    (_EXTENDED, 49): (_SMOOTHSTEP,),
    (_EXTENDED, 69): (_NORMALIZE,),
}
"""By opcode and the number of GLSL.std.450's instruction, 0 for all others."""

OVERFLOW = Check(
    "overflow", lambda result: np.log2(np.finfo(np.float32).max) - np.log2(np.abs(result)),
    lambda result: "no number" if np.isnan(result) else "beyond the largest float",
    lambda margin: ~(margin > -1.0),
)  # fmt: skip
"""Of a result that is no number although all operands are; of the result."""

INDEX = Check(
    "index out of range", lambda index, size: np.minimum(index, size - 1 - index),
    lambda index, size: f"index {index:g} into {size:g} elements",
)  # fmt: skip
"""Of an index and the number of elements."""


def number_of(op: int, operands: tuple[int, ...]) -> tuple[int, int]:
    """What `CHECKS` has an instruction by."""
    return (op, operands[1]) if op == _EXTENDED else (op, 0)


def arguments_of(op: int, operands: tuple[int, ...]) -> tuple[int, ...]:
    """The ids of an instruction's operands that are values."""
    return operands[2:] if op == _EXTENDED else operands
