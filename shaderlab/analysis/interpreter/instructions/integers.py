"""Arithmetic on integers of 32 bits, and on their bits."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab import glslmath
from shaderlab.bands import Integer, Truth
from shaderlab.bands.truth import as_truth

from ..memory import World
from ..program import Instruction
from .handler import Handler

if TYPE_CHECKING:
    from ..running import Run


def whole_numbers(
    function: Callable[..., Any], *, unsigned: bool | None = None, bits: bool = False
) -> Handler:
    """A handler of a function of integers; `unsigned` is how it reads its operands, None as they
    are. With `bits` the last operands are a field's offset and size, and stay as they are."""

    def handler(run: Run, at: Instruction, world: World) -> Any:
        values: list[Integer] = run.values(at.operands)
        if unsigned is not None:
            values = [value.converted(unsigned) for value in values]
        elif not bits and len({value.unsigned for value in values}) > 1:
            values = [value.converted(values[0].unsigned) for value in values]
        result = function(*values)
        type_ = run.program.types[at.type]
        if type_.kind == "struct":
            return tuple(settled(run, part, world) for part in result)
        return settled(run, result.converted(not type_.base.signed), world)

    return handler


def settled(run: Run, value: Integer, world: World) -> Integer:
    """The integer without what it may be for invocations that are not here: one number, so that
    the value counts as known where it is so for all that are."""
    if run.arithmetic.rules is None:
        rounded: Integer = run.arithmetic.rounded(value)
        return rounded
    if value.known or value.shape[0] != world.mask.size:
        return value
    high = np.where(world.mask[:, None], value.hi, value.lo)
    anything = value.anything & (world.mask[:, None] if value.anything.ndim else True)
    return Integer(
        value.lo,
        None if np.array_equal(high, value.lo) else high,
        unsigned=value.unsigned,
        rules=value.rules,
        anything=anything if anything.any() else np.False_,
    )


_YES, _NO = (Truth.known([[holds]]) for holds in (True, False))


def _comparing(function: Callable[[Any, Any], Any], unsigned: bool | None = None) -> Handler:
    def handler(run: Run, at: Instruction, world: World) -> Any:
        a, b = run.values(at.operands)
        kind = a.unsigned if unsigned is None else unsigned
        a, b = a.converted(kind), b.converted(kind)
        if a.lo.size == b.lo.size == 1 and run.arithmetic.rules is None:  # as a loop's counter is
            return _YES if function(a.lo.item(), b.lo.item()) else _NO
        return as_truth(function(a, b))

    return handler


INTEGERS: Mapping[int, Handler] = {
    126: whole_numbers(operator.neg),
    128: whole_numbers(operator.add),
    130: whole_numbers(operator.sub),
    132: whole_numbers(operator.mul),
    134: whole_numbers(operator.truediv, unsigned=True),
    135: whole_numbers(operator.truediv, unsigned=False),
    137: whole_numbers(operator.mod, unsigned=True),
    138: whole_numbers(operator.mod, unsigned=False),
    139: whole_numbers(operator.mod, unsigned=False),
    149: whole_numbers(glslmath.uaddCarry, unsigned=True),
    150: whole_numbers(glslmath.usubBorrow, unsigned=True),
    151: whole_numbers(lambda a, b: glslmath.umulExtended(a, b)[::-1], unsigned=True),
    152: whole_numbers(lambda a, b: glslmath.imulExtended(a, b)[::-1], unsigned=False),
    170: _comparing(operator.eq),
    171: _comparing(operator.ne),
    172: _comparing(operator.gt, unsigned=True),
    173: _comparing(operator.gt, unsigned=False),
    174: _comparing(operator.ge, unsigned=True),
    175: _comparing(operator.ge, unsigned=False),
    176: _comparing(operator.lt, unsigned=True),
    177: _comparing(operator.lt, unsigned=False),
    178: _comparing(operator.le, unsigned=True),
    179: _comparing(operator.le, unsigned=False),
    194: whole_numbers(operator.rshift, unsigned=True),
    195: whole_numbers(operator.rshift, unsigned=False),
    196: whole_numbers(operator.lshift),
    197: whole_numbers(operator.or_),
    198: whole_numbers(operator.xor),
    199: whole_numbers(operator.and_),
    200: whole_numbers(operator.invert),
    201: whole_numbers(glslmath.bitfieldInsert, bits=True),
    202: whole_numbers(glslmath.bitfieldExtract, bits=True),
    203: whole_numbers(glslmath.bitfieldExtract, bits=True),
    204: whole_numbers(glslmath.bitfieldReverse),
    205: whole_numbers(glslmath.bitCount),
}
