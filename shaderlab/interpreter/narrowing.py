"""What a condition says of the variables in it: where `x < limit` was taken, x lies below limit.

Only bands gain by it, where an invocation takes both sides: a loop that ends when something is
small enough then ends for the band as well. A variable's pending slack (see `Band.settled`) stays,
for a device may compute the variable anew after the comparison, and round otherwise.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.interpreter.memory import Pointer, World
from shaderlab.interpreter.program import Instruction

if TYPE_CHECKING:
    from shaderlab.interpreter.running import Run

_LOAD, _OR, _AND, _NOT = 61, 166, 167, 168
_LESS, _GREATER = (184, 188), (186, 190)


def narrow(run: Run, condition: int, holds: bool, world: World) -> None:
    """Bound the variables of a world in which the condition of this id holds, or does not."""
    at = run.program.definitions.get(condition)
    if at is None:
        return
    if at.op == _NOT:
        narrow(run, at.operands[0], not holds, world)
    elif at.op == (_AND if holds else _OR):
        for part in at.operands:
            narrow(run, part, holds, world)
    elif at.op in _LESS or at.op in _GREATER:
        smaller, larger = at.operands if (at.op in _LESS) == holds else at.operands[::-1]
        values = run.value(smaller), run.value(larger)
        if all(isinstance(value, Band) for value in values):
            (least, _), (_, most) = (value.settled() for value in values)
            _bound(run, smaller, world, -np.inf, most)
            _bound(run, larger, world, least, np.inf)


def _bound(run: Run, operand: int, world: World, low: Any, high: Any) -> None:
    """Bound the variable that an operand was loaded from, if it still holds that value."""
    at: Instruction | None = run.program.definitions.get(operand)
    pointer = run.value(at.operands[0]) if at is not None and at.op == _LOAD else None
    if not isinstance(pointer, Pointer) or pointer.path:
        return
    band: Band = run.value(operand)
    if world.memory.get(pointer.variable) is not band:
        return
    lo, hi = np.maximum(band.lo, low), np.minimum(band.hi, high)
    crossed = lo > hi  # of other invocations
    lo, hi = np.where(crossed, band.lo, lo), np.where(crossed, band.hi, hi)
    world.memory[pointer.variable] = Band(lo, hi, band.rules, band.flags, band.terms)
