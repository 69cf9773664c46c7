"""Variables, pointers, loads and stores, calls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.compiler.spirv import Op, StorageClass

from ..program import Instruction
from ..values import (
    Missing,
    NotGivenError,
    Pointer,
    World,
    changed,
    fetch,
    known_index,
    part_type,
    shared,
    spelt,
    undefined,
)
from .arithmetic import Handler

if TYPE_CHECKING:
    from ..running import Run


def _variable(run: Run, at: Instruction, world: World) -> Pointer:
    initial = at.operands[1:]
    world.memory[at.id] = run.value(initial[0]) if initial else None
    return run.results.get(at.id) or Pointer(at.id)


def _access_chain(run: Run, at: Instruction, world: World) -> Pointer:
    base, *steps = at.operands
    pointer: Pointer = run.value(base)
    path = (*pointer.path, *(known_index(run.value(step)) for step in steps))
    return Pointer(pointer.variable, path)


def _load(run: Run, at: Instruction, world: World) -> Any:
    pointer: Pointer = run.value(at.operands[0])
    value = world.memory.get(pointer.variable)
    if value is None:
        value = run.shared.get(pointer.variable)
    if value is not None and pointer.path:
        whole, path = value, pointer.path
        if all(isinstance(index, int) for index in path):
            value = run.remembered(whole, path, lambda: fetch(whole, path, world.mask))
        else:
            value = fetch(whole, path, world.mask)
    if type(value) is Missing:
        if run.program.module.types[at.type].op == Op.TypeImage:
            raise run.program.not_interpreted(f"image {value.name}", at.line)
        raise NotGivenError.of(value)
    if value is None:
        value = undefined(run.program.types[at.type], run.arithmetic)
    run.loaded(value)
    return value


def _store(run: Run, at: Instruction, world: World) -> None:
    pointer: Pointer = run.value(at.operands[0])
    value = run.value(at.operands[1])
    type_, storage = run.program.variables[pointer.variable]
    is_shared = storage == StorageClass.Workgroup
    memory = run.shared if is_shared else world.memory
    stored = value
    if pointer.path or is_shared:
        old = memory.get(pointer.variable)
        if old is None:
            old = undefined(type_, run.arithmetic)
        if is_shared:
            stored = shared(old, type_, pointer.path, value, world.mask, run.lanes)
        else:
            stored = changed(old, type_, pointer.path, value, world.mask)
    memory[pointer.variable] = stored
    name = run.program.name(pointer.variable) if run.trace is not None else ""
    if name:
        part = part_type(type_, pointer.path)
        run.stored(at, spelt(name, type_, pointer.path), part, value, world)


def _copy(run: Run, at: Instruction, world: World) -> Any:
    return run.value(at.operands[0])


def _call(run: Run, at: Instruction, world: World) -> Any:
    function = run.program.functions[at.operands[0]]
    for parameter, argument in zip(function.parameters, at.operands[1:], strict=True):
        run.results[parameter] = run.value(argument)
    run.passed(at, function, world)
    run.calls.append(at.line)
    end = run.call(function, world)
    run.calls.pop()
    if end is None:
        world.mask = np.zeros_like(world.mask)
        return None
    world.mask, world.memory = end.mask, end.memory
    result = world.memory.pop(function.id, None)
    if result is not None:
        run.loaded(result)
    return result


def _phi(run: Run, at: Instruction, world: World) -> Any:
    return world.memory.pop(at.id)


def _undefined(run: Run, at: Instruction, world: World) -> Any:
    return undefined(run.program.types[at.type], run.arithmetic)


def _merge(run: Run, at: Instruction, world: World) -> None:
    """Where paths meet again follows from the order of blocks."""


VARIABLES: Mapping[int, Handler] = {
    Op.Undef: _undefined,
    Op.FunctionCall: _call,
    Op.Variable: _variable,
    Op.Load: _load,
    Op.Store: _store,
    Op.AccessChain: _access_chain,
    Op.InBoundsAccessChain: _access_chain,
    Op.CopyObject: _copy,
    Op.Phi: _phi,
    Op.LoopMerge: _merge,
    Op.SelectionMerge: _merge,
}


def _emit_vertex(run: Run, at: Instruction, world: World) -> None:
    run.emission.emit(run, at, world)


def _end_primitive(run: Run, at: Instruction, world: World) -> None:
    run.emission.end(world)


def _wait(run: Run, at: Instruction, world: World) -> None:
    """All invocations of a workgroup take each step together."""


STAGES: Mapping[int, Handler] = {
    Op.EmitVertex: _emit_vertex,
    Op.EndPrimitive: _end_primitive,
    Op.ControlBarrier: _wait,
    Op.MemoryBarrier: _wait,
}
