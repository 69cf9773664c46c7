"""GLSL.std.450: most of GLSL's built-in functions, each one instruction.

Numbers: Khronos, SPIR-V Extended Instructions for GLSL 1.00, section 3.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from shaderlab.bands import Integer

from ..memory import World
from ..program import Instruction
from .handler import Handler
from .integers import settled
from .multiples import computed

if TYPE_CHECKING:
    from ..running import Run

_FLOATS = {
    1: "round", 2: "roundEven", 3: "trunc", 4: "abs", 6: "sign", 8: "floor", 9: "ceil",
    10: "fract", 11: "radians", 12: "degrees", 13: "sin", 14: "cos", 15: "tan", 16: "asin",
    17: "acos", 18: "atan", 19: "sinh", 20: "cosh", 21: "tanh", 22: "asinh", 23: "acosh",
    24: "atanh", 25: "atan", 26: "pow", 27: "exp", 28: "log", 29: "exp2", 30: "log2", 31: "sqrt",
    32: "inversesqrt", 33: "determinant", 34: "inverse", 36: "modf", 37: "min", 40: "max",
    43: "clamp", 46: "mix", 48: "step", 49: "smoothstep", 50: "fma", 52: "frexp", 53: "ldexp",
    66: "length", 67: "distance", 68: "cross", 69: "normalize", 70: "faceforward", 71: "reflect",
    72: "refract",
}  # fmt: skip
_INTEGERS = {
    5: ("abs", False), 7: ("sign", False), 38: ("min", True), 39: ("min", False),
    41: ("max", True), 42: ("max", False), 44: ("clamp", True), 45: ("clamp", False),
    73: ("findLSB", None), 74: ("findMSB", False), 75: ("findMSB", True),
}  # fmt: skip
_PACKING = {
    54: "packSnorm4x8", 55: "packUnorm4x8", 56: "packSnorm2x16", 57: "packUnorm2x16",
    58: "packHalf2x16", 60: "unpackSnorm2x16", 61: "unpackUnorm2x16", 62: "unpackHalf2x16",
    63: "unpackSnorm4x8", 64: "unpackUnorm4x8",
}  # fmt: skip
_UNKNOWN = {
    35: "modf", 51: "frexp", 59: "packDouble2x32", 65: "unpackDouble2x32",
    76: "interpolateAtCentroid", 77: "interpolateAtSample", 78: "interpolateAtOffset",
}  # fmt: skip


def _extended(run: Run, at: Instruction, world: World) -> Any:
    number, operands = at.operands[1], at.operands[2:]
    name = _FLOATS.get(number) or _PACKING.get(number)
    if name is not None:
        return _kept(run, computed(run, name, run.values(operands)), world)
    if number in _INTEGERS:
        function, unsigned = _INTEGERS[number]
        values: list[Integer] = run.values(operands)
        if unsigned is not None:
            values = [value.converted(unsigned) for value in values]
        result: Integer = run.arithmetic.call(function, *values)
        to = run.program.types[at.type].base
        return settled(run, result.converted(not to.signed), world)
    raise run.program.not_interpreted(
        _UNKNOWN.get(number, f"GLSL.std.450's instruction {number}"), at.line
    )


def _kept(run: Run, value: Any, world: World) -> Any:
    """The result; integers in it only as far as they concern the invocations that are here."""
    if isinstance(value, tuple):
        return tuple(_kept(run, part, world) for part in value)
    if isinstance(value, Integer):
        return settled(run, value, world)
    return value


EXTENDED: Mapping[int, Handler] = {12: _extended}
