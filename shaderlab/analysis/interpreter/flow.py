"""Instructions that move values and choose the way: variables, calls, branches; and the table of
all handlers.

A handler takes the run, the instruction and the path's state, and returns the result. Opcodes are
those of Khronos, SPIR-V Specification 1.6, section 3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands import Band, Integer, TriBool
from shaderlab.bands.exact import as_tri_bool
from shaderlab.compiler.spirv import Glsl450 as G, Op, StorageClass, type_name
from shaderlab.errors import NotInterpretedError

from .operations import (
    COMPOSITES,
    DERIVATIVES,
    FLOATS,
    INTEGERS,
    LOGIC,
    Handler,
    call_extended,
    compute,
    settle_parts,
)
from .program import Function, Instruction
from .textures import TEXTURES
from .values import (
    Flags,
    Missing,
    NotGivenError,
    PathState,
    Pointer,
    Value,
    fetch,
    format_place,
    known_index,
    replace_part,
    select,
    undefined,
)

if TYPE_CHECKING:
    from .running import Run


def _variable(run: Run, at: Instruction, state: PathState) -> Pointer:
    initial = at.operands[1:]
    state.memory[at.id] = run.value(initial[0]) if initial else None
    if not initial and run.for_ranges:
        state.memory[at.id] = undefined(run.program.variables[at.id][0], run.arithmetic)
    return run.results.get(at.id) or Pointer(at.id)


def _access_chain(run: Run, at: Instruction, state: PathState) -> Pointer:
    base, *steps = at.operands
    pointer: Pointer = run.value(base)
    path = (*pointer.path, *(known_index(run.value(step)) for step in steps))
    return Pointer(pointer.variable, path)


def _load(run: Run, at: Instruction, state: PathState) -> Any:
    pointer: Pointer = run.value(at.operands[0])
    value = state.memory.get(pointer.variable)
    if pointer.variable in run.shared:
        if run.for_ranges:  # others may have stored anything
            return undefined(run.program.types[at.type], run.arithmetic)
        run.accesses.append((at, tuple(run.calls), pointer, state.mask))
    elif pointer.variable in run.stale:
        name = type_name(run.program.module, run.program.module.variables[pointer.variable][0])
        raise run.program.not_interpreted(f"{name}, which others may have changed", at.line)
    if value is not None and pointer.path:
        whole, path = value, pointer.path
        if all(isinstance(index, int) for index in path):
            value = run.cache_part(whole, path, lambda: fetch(whole, path, state.mask))
        else:
            value = fetch(whole, path, state.mask)
    if type(value) is Missing:
        module = run.program.module
        if module.types[at.type].op == Op.TypeImage:
            kind, remedy = type_name(module, at.type), "compute what is stored in a function"
            if kind == "subpassInput":
                remedy = "read a sampler2D: texelFetch(name, ivec2(gl_FragCoord.xy), 0)"
            raise run.program.not_interpreted(f"{kind} {value.name}", at.line, remedy)
        raise NotGivenError.of(value)
    if value is None:
        value = undefined(run.program.types[at.type], run.arithmetic)
    run.note_read(value)
    return value


def _array_length(run: Run, at: Instruction, state: PathState) -> Any:
    pointer: Pointer = run.value(at.operands[0])
    block = state.memory[pointer.variable]
    length = len(fetch(block, (*pointer.path, at.operands[1]), state.mask))
    return run.arithmetic.rounded(Integer(np.full((1, 1), length), unsigned=True))


def _extended(run: Run, at: Instruction, state: PathState) -> Any:
    """A function of GLSL's own; of modf and frexp the second part goes to their argument."""
    if at.operands[1] not in _TWO_PARTS:
        return call_extended(run, at, state)
    name, (value, place) = _TWO_PARTS[at.operands[1]], at.operands[2:]
    first, second = settle_parts(run, compute(run, name, run.values((value,))), state)
    _write(run, at, state, run.value(place), second)
    return first


_TWO_PARTS: Mapping[int, str] = {G.Modf: "modf", G.Frexp: "frexp"}


def _store(run: Run, at: Instruction, state: PathState) -> None:
    _write(run, at, state, run.value(at.operands[0]), run.value(at.operands[1]))


def _write(run: Run, at: Instruction, state: PathState, pointer: Pointer, value: Any) -> None:
    type_, storage = run.program.variables[pointer.variable]
    stored = value
    if pointer.path:
        old = state.memory.get(pointer.variable)
        if old is None:
            old = undefined(type_, run.arithmetic)
        stored = replace_part(old, type_, pointer.path, value, state.mask)
    state.memory[pointer.variable] = stored
    if pointer.variable in run.shared:
        run.accesses.append((at, tuple(run.calls), pointer, state.mask))
    name = run.program.name(pointer.variable) if run.trace is not None else ""
    if name or storage in (StorageClass.StorageBuffer, StorageClass.Uniform, StorageClass.Output):
        # A block may have no name of its own.
        place = format_place(name, type_, pointer.path).removeprefix(".")
        run.trace_stored(at, place, value, state)


def _call(run: Run, at: Instruction, state: PathState) -> Any:
    function = run.program.functions[at.operands[0]]
    for parameter, argument in zip(function.parameters, at.operands[1:], strict=True):
        run.results[parameter] = run.value(argument)
    run.trace_arguments(at, function, state)
    run.calls.append(at.line)
    end = run.call(function, state)
    run.calls.pop()
    if end is None:
        state.mask = np.zeros_like(state.mask)
        return None
    state.mask, state.memory = end.mask, end.memory
    result = state.memory.pop(function.id, None)
    if result is not None:
        run.note_read(result)
    return result


def _nothing(run: Run, at: Instruction, state: PathState) -> None:
    """Where paths meet follows from the order of blocks."""


RACE, DIVERGENT = "data race", "barrier in divergent control flow"


def meet(run: Run, at: Instruction | None, state: PathState) -> None:
    """Let a workgroup's invocations wait for each other, at a barrier or at the end: each sees then
    what others have stored. What sees another value than it saw before is in a race."""
    if at is not None:
        changed = (v for v, first in run.given.items() if state.memory[v] is not first)
        run.stale.update(run.texels, changed)
    if run.for_ranges:
        return
    groups = state.mask.reshape(-1, run.program.group)
    if at is not None:
        whole = groups.all(axis=1).repeat(groups.shape[1])
        run.conflicts[at, tuple(run.calls), DIVERGENT] |= state.mask & ~whole
    for id_, before in run.shared.items():
        own = state.memory[id_]
        if own is before:
            continue
        merged = state.memory[id_] = _merge(own, before, groups)
        run.shared[id_] = select(TriBool.of(state.mask[:, None]), merged, before)
        for access, calls, pointer, mask in run.accesses:
            if pointer.variable == id_:
                seen, after = (fetch(value, pointer.path, mask) for value in (own, merged))
                run.conflicts[access, calls, RACE] |= mask & state.mask & ~_same(seen, after)
    run.accesses = [one for one in run.accesses if (one[3] & ~state.mask).any()]


def _merge(own: Value, before: Value, groups: Flags) -> Value:
    """What each invocation holds (own), with the parts that others of its group have changed; where
    several have, what the first one stored."""
    if isinstance(own, tuple):
        return tuple(_merge(*parts, groups) for parts in zip(own, before, strict=True))
    if own is before:
        return own
    shape = groups.size, *own.shape[1:]
    new, old = (np.broadcast_to(_array(v), shape).reshape(*groups.shape, -1) for v in (own, before))
    changed = (new != old) & ((new == new) | (old == old)) & groups[..., None]  # NaN is no change
    first = np.take_along_axis(new, changed.argmax(axis=1)[:, None], axis=1)
    merged = np.where(changed.any(axis=1, keepdims=True), first, new).reshape(shape)
    if isinstance(own, Integer):
        return Integer(merged, unsigned=own.unsigned)
    return TriBool.of(merged) if isinstance(own, TriBool) else merged


def _array(value: Value) -> Any:
    return getattr(value, "lo", getattr(value, "all_true", value))


def _same(a: Value, b: Value) -> Any:
    if isinstance(a, tuple):
        return np.all([_same(*parts) for parts in zip(a, b, strict=True)], axis=0)
    x, y = _array(a), _array(b)
    equal = (x == y) | ((x != x) & (y != y))
    return equal.reshape(len(equal), -1).all(axis=1)


HANDLERS: Mapping[int, Handler] = {
    Op.Undef: lambda run, at, state: undefined(run.program.types[at.type], run.arithmetic),
    Op.FunctionCall: _call, Op.Variable: _variable, Op.Load: _load, Op.Store: _store,
    Op.AccessChain: _access_chain, Op.InBoundsAccessChain: _access_chain,
    Op.ArrayLength: _array_length, Op.ExtInst: _extended,
    Op.CopyObject: lambda run, at, state: run.value(at.operands[0]),
    Op.Phi: lambda run, at, state: state.memory.pop(at.id),
    Op.LoopMerge: _nothing, Op.SelectionMerge: _nothing, Op.MemoryBarrier: _nothing,
    Op.ControlBarrier: meet,
    **COMPOSITES, **FLOATS, **INTEGERS, **LOGIC, **DERIVATIVES, **TEXTURES,
}  # fmt: skip

Leaving = list[tuple[int | None, PathState]]
"""States, each with the label of the block that it goes to; None for one that returns."""


def _conditional(run: Run, function: Function, at: Instruction, state: PathState) -> Leaving:
    condition, then, otherwise = at.operands[:3]
    truth = as_tri_bool(run.value(condition))
    if truth.all_true.size == 1 and run.count:  # all go the same way, as loops mostly do
        for target, is_sure in ((then, truth.all_true), (otherwise, truth.all_false)):
            if is_sure.item():
                return [(target, state)]
    yes, no = (state.mask & ~side[:, 0] for side in (truth.all_false, truth.all_true))
    leaving = _split([(then, yes), (otherwise, no)], state)
    if (both := yes & no).any():
        run.note_undecided(at.line, both)
        for (_, side), holds in zip(leaving, (True, False), strict=True):
            narrow(run, condition, holds, side)
    return leaving


def _switch(run: Run, function: Function, at: Instruction, state: PathState) -> Leaving:
    selector, default = run.value(at.operands[0]), at.operands[1]
    bits = np.dtype(np.uint32 if selector.unsigned else np.int32)
    going: dict[int, Any] = {}
    elsewhere = state.mask
    for literal, target in zip(at.operands[2::2], at.operands[3::2], strict=True):
        same = as_tri_bool(selector == int(np.uint32(literal).astype(bits)))
        may, sure = (
            np.broadcast_to(side[:, 0], state.mask.shape)
            for side in (~same.all_false, same.all_true)
        )
        going[target] = going.get(target, False) | (state.mask & may)
        elsewhere = elsewhere & ~sure
    going[default] = going.get(default, False) | elsewhere
    several = np.sum([flags for flags in going.values()], axis=0) > 1
    if several.any():
        run.note_undecided(at.line, several)
    return _split(list(going.items()), state)


def _split(sides: list[tuple[int, Flags]], state: PathState) -> Leaving:
    taken = [(target, mask) for target, mask in sides if mask.any()]
    if len(taken) == 1:
        return [(taken[0][0], state)]
    return [(target, state.split(mask)) for target, mask in taken]


def take_phis(run: Run, function: Function, label: int, target: int, state: PathState) -> None:
    """Give the phis of a block that a state goes to their values from the block that it leaves."""
    for phi in function.blocks[target]:
        if phi.op != Op.Phi:
            break
        pairs = zip(phi.operands[::2], phi.operands[1::2], strict=True)
        state.memory[phi.id] = run.value(next(value for value, of in pairs if of == label))


def _return_value(run: Run, function: Function, at: Instruction, state: PathState) -> Leaving:
    value = run.value(at.operands[0])
    if run.trace is not None:
        name = run.program.name(function.id).partition("(")[0]
        run.trace_stored(at, f"{name}()", value, state)
    state.memory[function.id] = value
    return [(None, state)]


def _kill(run: Run, function: Function, at: Instruction, state: PathState) -> Leaving:
    run.killed = run.killed | state.mask
    return []


Branch = Callable[["Run", Function, Instruction, PathState], Leaving]
"""Ends a block of a function."""

BRANCHES: Mapping[int, Branch] = {
    Op.Branch: lambda run, function, at, state: [(at.operands[0], state)],
    Op.Return: lambda run, function, at, state: [(None, state)],
    Op.Unreachable: lambda run, function, at, state: [],
    Op.BranchConditional: _conditional, Op.Switch: _switch, Op.Kill: _kill,
    Op.ReturnValue: _return_value,
}  # fmt: skip


_LESS = (Op.FOrdLessThan, Op.FOrdLessThanEqual)
_GREATER = (Op.FOrdGreaterThan, Op.FOrdGreaterThanEqual)


def narrow(run: Run, condition: int, holds: bool, state: PathState) -> None:
    """Bound the variables of a state in which the condition of this id holds, or does not."""
    at = run.program.definitions.get(condition)
    if at is None:
        return
    if at.op == Op.LogicalNot:
        narrow(run, at.operands[0], not holds, state)
    elif at.op == (Op.LogicalAnd if holds else Op.LogicalOr):
        for part in at.operands:
            narrow(run, part, holds, state)
    elif at.op in _LESS or at.op in _GREATER:
        smaller, larger = at.operands if (at.op in _LESS) == holds else at.operands[::-1]
        values = run.value(smaller), run.value(larger)
        if all(isinstance(value, Band) for value in values):
            (least, _), (_, most) = (value.apply_slack() for value in values)
            if not holds:  # nor does it of NaN
                unknown = values[0].may_be_nan | values[1].may_be_nan
                least, most = np.where(unknown, -np.inf, least), np.where(unknown, np.inf, most)
            _bound(run, smaller, state, -np.inf, most)
            _bound(run, larger, state, least, np.inf)


def _bound(run: Run, operand: int, state: PathState, low: Any, high: Any) -> None:
    """Bound the variable that an operand was loaded from, if it still holds that value."""
    at: Instruction | None = run.program.definitions.get(operand)
    band: Band = run.value(operand)
    if at is not None and at.op == Op.ExtInst and at.operands[1] == G.FAbs:
        own = run.value(at.operands[2])  # it is as far from 0, on the side that it is on
        above = np.where(own.lo >= 0.0, low, -high)
        _bound(run, at.operands[2], state, above, np.where(own.hi <= 0.0, -low, high))
        return
    pointer = run.value(at.operands[0]) if at is not None and at.op == Op.Load else None
    if not isinstance(pointer, Pointer) or (pointer.path and not run.for_ranges):
        return
    path, whole = pointer.path, state.memory.get(pointer.variable)
    if not all(isinstance(index, int) for index in path):
        return
    held = run.cache_part(whole, path, lambda: fetch(whole, path, state.mask)) if path else whole
    if held is not band:
        return
    lo, hi = np.maximum(band.lo, low), np.minimum(band.hi, high)
    crossed = lo > hi  # of other invocations
    lo, hi = np.where(crossed, band.lo, lo), np.where(crossed, band.hi, hi)
    new = Band(lo, hi, band.rules, band.flags, band.terms)
    type_, _ = run.program.variables[pointer.variable]
    state.memory[pointer.variable] = replace_part(whole, type_, path, new, state.mask)


Steps = tuple[list[tuple[Handler, Instruction, bool]], Branch, Instruction]
"""A block's instructions, each with its handler and whether it is a call; and how it ends."""


def steps_of(block: list[Instruction]) -> Steps:
    """A block as it is run. What has no handler is refused where it is reached. Raises
    NotInterpretedError: no branch ends it."""
    steps: list[tuple[Handler, Instruction, bool]] = []
    for at in block:
        if at.op in BRANCHES:
            return steps, BRANCHES[at.op], at
        steps.append((HANDLERS.get(at.op, _unknown), at, at.op == Op.FunctionCall))
    raise NotInterpretedError("not interpreted: a block without an end")


def _unknown(run: Run, at: Instruction, state: PathState) -> Value:
    name = Op(at.op).name if at.op in set(Op) else f"opcode {at.op}"
    raise run.program.not_interpreted(f"SPIR-V's {name}", at.line)
