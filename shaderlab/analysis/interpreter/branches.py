"""The instructions that end a block: where each invocation goes next."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.bands.truth import as_truth

from .memory import Flags, Pointer, World
from .program import Function, Instruction

if TYPE_CHECKING:
    from .running import Run


_PHI = 245
Leaving = list[tuple[int | None, World]]
"""Worlds, each with the label of the block that it goes to; None for one that returns."""


def _branch(run: Run, function: Function, label: int, at: Instruction, world: World) -> Leaving:
    return [_to(run, function, label, at.operands[0], world)]


def _conditional(
    run: Run, function: Function, label: int, at: Instruction, world: World
) -> Leaving:
    condition, then, otherwise = at.operands[:3]
    truth = as_truth(run.value(condition))
    run.branched(at, truth, world)
    if truth.all_true.size == 1 and run.count:  # all go the same way, as loops mostly do
        for target, is_sure in ((then, truth.all_true), (otherwise, truth.all_false)):
            if is_sure.item():
                return [_to(run, function, label, target, world)]
    yes, no = (
        world.mask & ~np.broadcast_to(side[:, 0], world.mask.shape)
        for side in (truth.all_false, truth.all_true)
    )
    leaving = _split(run, function, label, [(then, yes), (otherwise, no)], world)
    if (both := yes & no).any():
        run.note_undecided(at.line, both)
        for (_, side), holds in zip(leaving, (True, False), strict=True):
            narrow(run, condition, holds, side)
    return leaving


def _switch(run: Run, function: Function, label: int, at: Instruction, world: World) -> Leaving:
    selector, default = run.value(at.operands[0]), at.operands[1]
    run.branched(at, selector, world)
    bits = np.dtype(np.uint32 if selector.unsigned else np.int32)
    going: dict[int, Any] = {}
    elsewhere = world.mask
    for literal, target in zip(at.operands[2::2], at.operands[3::2], strict=True):
        same = as_truth(selector == int(np.uint32(literal).astype(bits)))
        may, sure = (
            np.broadcast_to(side[:, 0], world.mask.shape)
            for side in (~same.all_false, same.all_true)
        )
        going[target] = going.get(target, False) | (world.mask & may)
        elsewhere = elsewhere & ~sure
    going[default] = going.get(default, False) | elsewhere
    several = np.sum([flags for flags in going.values()], axis=0) > 1
    if several.any():
        run.note_undecided(at.line, several)
    return _split(run, function, label, list(going.items()), world)


def _split(
    run: Run, function: Function, label: int, sides: list[tuple[int, Flags]], world: World
) -> Leaving:
    taken = [(target, mask) for target, mask in sides if mask.any()]
    if len(taken) == 1:
        return [_to(run, function, label, taken[0][0], world)]
    return [_to(run, function, label, target, world.split(mask)) for target, mask in taken]


def _to(run: Run, function: Function, label: int, target: int, world: World) -> tuple[int, World]:
    """The world on its way to a block, whose phis take the values of the block that it leaves."""
    for phi in function.blocks[target]:
        if phi.op != _PHI:
            break
        pairs = zip(phi.operands[::2], phi.operands[1::2], strict=True)
        world.memory[phi.id] = run.value(next(value for value, of in pairs if of == label))
    return target, world


def _return(run: Run, function: Function, label: int, at: Instruction, world: World) -> Leaving:
    return [(None, world)]


def _return_value(
    run: Run, function: Function, label: int, at: Instruction, world: World
) -> Leaving:
    value = run.value(at.operands[0])
    if run.trace is not None:
        name = run.program.name(function.id).partition("(")[0]
        run.stored(at, f"{name}()", run.program.types[function.result], value, world)
    world.memory[function.id] = value
    return [(None, world)]


def _kill(run: Run, function: Function, label: int, at: Instruction, world: World) -> Leaving:
    run.killed = run.killed | world.mask
    return []


def _unreachable(
    run: Run, function: Function, label: int, at: Instruction, world: World
) -> Leaving:
    return []


Branch = Callable[["Run", Function, int, Instruction, World], Leaving]
"""Ends a block, in a run, of a function, with its label."""

BRANCHES: Mapping[int, Branch] = {
    249: _branch,
    250: _conditional,
    251: _switch,
    252: _kill,
    253: _return,
    254: _return_value,
    255: _unreachable,
}
"""By opcode: OpBranch, OpBranchConditional, OpSwitch, OpKill, OpReturn, OpReturnValue,
OpUnreachable."""


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
