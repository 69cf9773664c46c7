"""Running a program: its functions, block after block, over all invocations at once.

Of the paths that are under way, the one whose block comes first in the module's order goes on.
glslang writes what a branch goes round before the place where its sides meet, and a loop's body
before what follows it, so paths meet again as early as they can; in any other order they would
still compute the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Truth
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array

from . import constants
from .arithmetic import Arithmetic
from .blocks import Steps, steps_of
from .branches import Leaving
from .emission import Emission
from .memory import Flags, Pointer, World, fetch, join, part_type
from .program import Function, Instruction, Program
from .stored import Stored, Trace
from .types import Kind, Type
from .values import Missing, NotGivenError, UnchoosableError, Value, component

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
            self.results[id_] = constants.value(self, id_)
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
