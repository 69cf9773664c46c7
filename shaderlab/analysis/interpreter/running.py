"""A module's constants as values."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Truth
from shaderlab.bands.truth import as_truth
from shaderlab.compiler.spirv import Op, StorageClass
from shaderlab.errors import FormulaError, NotInterpretedError
from shaderlab.model.frame import Array

from .arithmetic import Arithmetic
from .instructions import HANDLERS, NAMES
from .instructions.arithmetic import Handler
from .program import Function, Instruction, Kind, Program, Type
from .stored import Stored, Trace
from .values import (
    Flags,
    Missing,
    NotGivenError,
    Pointer,
    UnchoosableError,
    Value,
    World,
    broadcast,
    component,
    composed,
    fetch,
    join,
    null,
    part_type,
    select,
    undefined,
)

_TRUE, _FALSE = (41, 48), (42, 49)
_SCALAR, _COMPOSITE, _NULL, _OPERATION = (43, 50), (44, 51), 46, 52


def value(run: Run, id_: int) -> Value:
    """What a constant, or a global variable's name, stands for."""
    program = run.program
    if id_ in program.variables:
        return Pointer(id_)
    declared = program.module.values[id_]
    op, words = declared.op, declared.words
    type_ = program.types[words[0]]
    if op in _TRUE or op in _FALSE:
        return Truth.known(np.full((1, 1), op in _TRUE))
    if op in _SCALAR:
        word = np.array([[words[2]]], np.uint32)
        if type_.kind == "float":
            return run.arithmetic.literal(float(word.view(np.float32)[0, 0]))
        number = word.view(np.int32) if type_.signed else word
        return Integer(number, unsigned=not type_.signed, rules=run.arithmetic.rules)
    if op in _COMPOSITE:
        return composed(type_, run.values(words[2:]))
    if op == _NULL:
        return null(type_, run.arithmetic)
    if op == Op.Undef:
        return undefined(type_, run.arithmetic)
    handler = HANDLERS.get(words[2]) if op == _OPERATION else None
    if handler is None:
        raise program.not_interpreted(f"a constant of SPIR-V's opcode {op}", 0)
    everywhere = World(np.ones(run.count, np.bool_), {})
    return handler(run, Instruction(words[2], words[0], id_, words[3:], 0), everywhere)


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
    Op.Branch: _branch,
    Op.BranchConditional: _conditional,
    Op.Switch: _switch,
    Op.Kill: _kill,
    Op.Return: _return,
    Op.ReturnValue: _return_value,
    Op.Unreachable: _unreachable,
}


_LESS = (Op.FOrdLessThan, Op.FOrdLessThanEqual)
_GREATER = (Op.FOrdGreaterThan, Op.FOrdGreaterThanEqual)


def narrow(run: Run, condition: int, holds: bool, world: World) -> None:
    """Bound the variables of a world in which the condition of this id holds, or does not."""
    at = run.program.definitions.get(condition)
    if at is None:
        return
    if at.op == Op.LogicalNot:
        narrow(run, at.operands[0], not holds, world)
    elif at.op == (Op.LogicalAnd if holds else Op.LogicalOr):
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
    pointer = run.value(at.operands[0]) if at is not None and at.op == Op.Load else None
    if not isinstance(pointer, Pointer) or pointer.path:
        return
    band: Band = run.value(operand)
    if world.memory.get(pointer.variable) is not band:
        return
    lo, hi = np.maximum(band.lo, low), np.minimum(band.hi, high)
    crossed = lo > hi  # of other invocations
    lo, hi = np.where(crossed, band.lo, lo), np.where(crossed, band.hi, hi)
    world.memory[pointer.variable] = Band(lo, hi, band.rules, band.flags, band.terms)


Steps = tuple[list[tuple[Handler, Instruction, bool]], Branch, Instruction]
"""A block's instructions, each with its handler and whether it is a call; and how it ends."""


def steps_of(block: list[Instruction]) -> Steps:
    """A block as it is run. What has no handler is refused where it is reached.

    Raises:
        NotInterpretedError: no branch ends it.
    """
    steps: list[tuple[Handler, Instruction, bool]] = []
    for at in block:
        if at.op in BRANCHES:
            return steps, BRANCHES[at.op], at
        steps.append((HANDLERS.get(at.op, _unknown), at, at.op == Op.FunctionCall))
    raise NotInterpretedError("not interpreted: a block without an end")


def _unknown(run: Run, at: Instruction, world: World) -> Value:
    name = NAMES.get(at.op, f"SPIR-V's opcode {at.op}")
    raise run.program.not_interpreted(name, at.line)


class Emission:
    """The vertices that were emitted so far.

    Attributes:
        vertices: what each output held, by id; of the invocations that emitted so many.
        emitted: how many vertices each invocation emitted, (count,).
        strips: the number of the strip of each of those vertices, and of the next one, (count,).
    """

    def __init__(self, count: int) -> None:
        self.vertices: list[dict[int, Value]] = []
        self.strip_of: list[Any] = []
        self.emitted = np.zeros(count, np.int64)
        self.strips = np.zeros(count, np.int64)

    def emit(self, run: Run, at: Instruction, world: World) -> None:
        """Keep what the outputs hold, which are undefined from here on."""
        if any((flags & world.mask).any() for flags in run.undecided.values()):
            raise run.program.not_interpreted("EmitVertex behind an open branch", at.line)
        held = dict(_outputs(run, world))
        for number in np.unique(self.emitted[world.mask]):
            here = world.mask & (self.emitted == number)
            if number == len(self.vertices):
                self.vertices.append(held)
                self.strip_of.append(self.strips)
                continue
            before, own = self.vertices[number], Truth.known(here[:, None])
            self.vertices[number] = {id_: select(own, held[id_], before[id_]) for id_ in held}
            self.strip_of[number] = np.where(here, self.strips, self.strip_of[number])
        self.emitted = self.emitted + world.mask
        for id_ in held:
            type_, _ = run.program.variables[id_]
            world.memory[id_] = undefined(type_, run.arithmetic)

    def end(self, world: World) -> None:
        """Begin another strip."""
        self.strips = self.strips + world.mask

    def memories(self, run: Run) -> Iterator[dict[int, Value]]:
        """What each vertex' outputs hold by id, 0 of the invocations that emitted fewer."""
        for number, vertex in enumerate(self.vertices):
            there = Truth.known((self.emitted > number)[:, None])
            yield {
                id_: select(there, broadcast(value, run.count), _nothing(run, id_))
                for id_, value in vertex.items()
            }

    def counts(self, rules: Any) -> dict[str, Any]:
        """How many vertices each invocation emitted, and the strip of each."""
        strips = [
            np.where(self.emitted > number, strip, 0) for number, strip in enumerate(self.strip_of)
        ]
        return {
            "EmitVertex()": Integer(self.emitted[:, None], rules=rules),
            "EndPrimitive()": tuple(Integer(strip[:, None], rules=rules) for strip in strips),
        }


def _outputs(run: Run, world: World) -> Iterator[tuple[int, Value]]:
    for id_, (type_, storage) in run.program.variables.items():
        if storage == StorageClass.Output:
            value = world.memory.get(id_)
            yield id_, undefined(type_, run.arithmetic) if value is None else value


def _nothing(run: Run, id_: int) -> Value:
    return null(run.program.variables[id_][0], run.arithmetic)


TURNS = 4096
"""How often a loop may turn each time that it is entered, unless a caller says otherwise."""
BLOCKS = 200_000
"""How many blocks a program may run, likewise."""
_MOST_WORLDS = 8  # that wait at one block before they are joined
_MOST_PARTS = 256  # parts of values that are remembered


Watch = Callable[["Run", Instruction, World, Value], Value]
"""Is told of each instruction that was run, the last of a block left out, and of its result; gives
the result that counts."""


@dataclass(eq=False)
class Run:
    """One run of a program. For instruction handlers: what they read and write.

    Attributes:
        program, arithmetic, count: what is run, in what, for how many invocations.
        places: gl_FragCoord of each invocation, if it is given.
        lanes: how many invocations share variables, those of a workgroup one after the other.
        turns, blocks, trace, flow, watch: as of `interpret`.
        shared: what variables of workgroups hold by id, on whatever path an invocation is.
        emission: the vertices that a geometry stage emitted.
        results: each instruction's result by id, as of its last execution, and each constant.
        calls: the lines of the calls under way.
        killed: the invocations that a `discard` may have ended.
        undecided: by line, the invocations that took both sides of a branch there.
    """

    program: Program
    arithmetic: Arithmetic
    count: int
    _: KW_ONLY
    places: Array | None = None
    lanes: int = 1
    turns: int = TURNS
    blocks: int = BLOCKS
    trace: Trace | None = None
    flow: Trace | None = None
    watch: Watch | None = None

    def __post_init__(self) -> None:
        self.shared: dict[int, Value] = {}
        self.emission = Emission(self.count)
        self.results: dict[int, Value] = {}
        self.calls: list[int] = []
        self.killed: Flags = np.zeros(self.count, np.bool_)
        self.undecided: dict[int, Flags] = {}
        self.units: dict[int, tuple[Value, float]] = {}
        self._blocks = 0
        self._reads: list[Value] = []
        self._steps: dict[int, Steps] = {}
        self._parts: dict[tuple[int, Any], tuple[Value, Value]] = {}
        self._repeated: dict[int, tuple[list[int], list[Value], Value]] = {}

    def value(self, id_: int) -> Value:
        """What an operand's id stands for."""
        if id_ not in self.results:
            self.results[id_] = value(self, id_)
        return self.results[id_]

    def values(self, ids: tuple[int, ...]) -> list[Value]:
        """What several operands stand for."""
        results = self.results
        try:
            return [results[id_] for id_ in ids]
        except KeyError:  # a constant that is asked for the first time
            return [self.value(id_) for id_ in ids]

    def part(self, value: Value, index: int) -> Value:
        """A component. Twice the same one is the same object: bands know then that v.x * v.x is a
        square."""
        if isinstance(value, tuple):
            return value[index]
        return self.remembered(value, index, lambda: component(value, index))

    def remembered(self, value: Value, how: Any, make: Callable[[], Value]) -> Value:
        """What `make` gives, or gave for this very value before."""
        key = (id(value), how)
        known = self._parts.get(key)
        if known is None:
            if len(self._parts) > _MOST_PARTS:
                self._parts.clear()
            known = self._parts[key] = (value, make())  # kept, or its id might be another's
        return known[1]

    def repeated(self, at: Instruction, function: str) -> Value:
        """A function of an instruction's operands; what it gave, if it is run again for the very
        same values, as what does not change in a loop is. For numbers alone: of a band, the same
        object would mean that a device rounds alike each time."""
        values = self.values(at.operands)
        key = [*map(id, values)]
        known = self._repeated.get(at.id)
        if known is None or known[0] != key:
            found = self.arithmetic.call(function, *values)
            known = self._repeated[at.id] = key, values, found  # kept, or an id might be another's
        return known[2]

    def note_unit(self, value: Value, unit: float) -> None:
        """Remember a power of two that all of a value's numbers are multiples of, 0 if none is."""
        if len(self.units) > _MOST_PARTS:
            self.units.clear()
        self.units[id(value)] = value, unit

    def stored(self, at: Instruction, name: str, type_: Type, value: Value, world: World) -> None:
        """Tell the trace of a value that was stored; "param" is what glslang calls an argument."""
        if self.trace is not None and name not in ("", "param"):
            self.trace(self._event(at, name, type_, value, world))
            self._reads.clear()

    def branched(self, at: Instruction, value: Value, world: World) -> None:
        """Tell who asked of what a branch is taken by."""
        if self.flow is not None:
            kind: Kind = "bool" if isinstance(value, Truth) else "int"
            name = "condition" if kind == "bool" else "selector"
            self.flow(self._event(at, name, Type(kind), value, world))

    def passed(self, at: Instruction, function: Function, world: World) -> None:
        """Tell who asked of what a function is passed; it was not given anything for `out`."""
        if self.flow is None:
            return
        called = self.program.name(function.id).partition("(")[0]
        for id_, of in function.parameters.items():
            value: Any = self.results[id_]
            type_ = self.program.types[of]
            if isinstance(value, Pointer):
                type_ = part_type(self.program.variables[value.variable][0], value.path)
                value = fetch(world.memory.get(value.variable), value.path, world.mask)
            if type_.kind != "image" and not isinstance(value, Missing | None):
                name = f"{called}({self.program.name(id_)})"
                self.flow(self._event(at, name, type_, value, world))

    def _event(self, at: Instruction, name: str, type_: Type, value: Value, world: World) -> Stored:
        calls, reads = tuple(self.calls), tuple(self._reads)
        return Stored(at, name, type_, value, world.mask, calls, reads)

    def loaded(self, value: Value) -> None:
        """Note for the trace what the next value may be computed of."""
        if self.trace is not None:
            self._reads.append(value)

    def note_undecided(self, line: int, invocations: Flags) -> None:
        """Note that invocations took both sides of a branch."""
        self.undecided[line] = self.undecided.get(line, False) | invocations

    def call(self, function: Function, world: World) -> World | None:
        """Run a function; the world in which it returns, None if it returns nowhere."""
        order = function.order
        waiting = {next(iter(function.blocks)): [world]}
        returned: list[World] = []
        visits: dict[int, int] = {}
        while waiting:
            label = min(waiting, key=order.__getitem__) if len(waiting) > 1 else next(iter(waiting))
            arrived = join(waiting.pop(label))
            self._count(visits, label, function.blocks[label][0].line)
            for target, next_world in self._block(function, label, arrived):
                if target is None:
                    returned.append(next_world)
                    continue
                place = order[target]
                if place <= order[label]:  # a loop turns, those inside of it begin anew
                    visits = {of: n for of, n in visits.items() if order[of] <= place}
                worlds = waiting.setdefault(target, [])
                worlds.append(next_world)
                if len(worlds) > _MOST_WORLDS:
                    waiting[target] = [join(worlds)]
        if not returned:
            return None
        end = join(returned)
        for id_ in function.variables:
            end.memory.pop(id_, None)
        return end

    def _count(self, visits: dict[int, int], label: int, line: int) -> None:
        """Count a block's run, and give up where there are too many."""
        visits[label] = visits.get(label, 0) + 1
        self._blocks += 1
        if visits[label] > self.turns + 1:
            what = f"a loop that goes on after {self.turns} turns"
        elif self._blocks > self.blocks:
            what = f"a program that goes on after {self.blocks} blocks"
        else:
            return
        raise self.program.not_interpreted(what, line)

    def _block(self, function: Function, label: int, world: World) -> Leaving:
        """Run a block; the worlds that leave it, each with the block that it goes to, None for
        one that returns."""
        if label not in self._steps:
            self._steps[label] = steps_of(function.blocks[label])
        steps, branch, last = self._steps[label]
        results, watch = self.results, self.watch
        for handler, at, is_call in steps:
            try:
                result = handler(self, at, world)
            except UnchoosableError:
                raise self.program.not_interpreted("a choice between samplers", at.line) from None
            except NotGivenError:
                raise
            except FormulaError as error:
                raise self.program.not_interpreted(error.message, at.line) from error
            if type(result) is Missing:
                raise NotGivenError.of(result)
            if watch is not None:
                result = watch(self, at, world, result)
            if at.id:
                results[at.id] = result
            if is_call and not world.mask.any():
                return []  # all were discarded in it
        return branch(self, function, label, last, world)
