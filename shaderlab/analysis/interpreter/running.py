"""One run of a program: its constants, its functions block by block, and what it stores."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, TriBool
from shaderlab.bands.rounding import shortest, ulp
from shaderlab.compiler.compile import literal_of
from shaderlab.compiler.spirv import Op
from shaderlab.errors import FormulaError, NotInterpretedError
from shaderlab.model.frame import Array

from .arithmetic import Arithmetic
from .flow import HANDLERS, Leaving, Steps, steps_of, take_phis
from .program import Function, Instruction, Program
from .values import (
    Flags,
    Missing,
    NotGivenError,
    PathState,
    Pointer,
    UnchoosableError,
    Value,
    component,
    compose,
    fetch,
    join,
    null,
    part_type,
    split_parts,
    undefined,
)


@dataclass(frozen=True, eq=False)
class Stored:
    """A value that one path through a program stores. Its name is that of the variable, or of the
    part of it, as GLSL writes it; "f()" is the result of f, "f(x)" what f is passed as x. It is
    floats, an `Integer`, a `TriBool`, or a tuple of such, with one row or as many as there are
    invocations, and means nothing to those that are not in the `mask`. `calls` has the lines of the
    calls that led here, the outermost first, `reads` what was loaded, and what functions gave,
    since the value that was stored before."""

    at: Instruction
    name: str
    value: Any
    mask: Flags
    calls: tuple[int, ...]
    reads: tuple[Any, ...]

    @property
    def line(self) -> int:
        """The line of the program's text, counted from 1; see `Program.place`."""
        return self.at.line

    @property
    def is_argument(self) -> bool:
        """Whether it is what a function is passed."""
        return self.at.op == Op.FunctionCall


Trace = Callable[[Stored], object]


def is_vector(value: Any) -> bool:
    """Whether a value is a band of scalars or of vectors."""
    return isinstance(value, Band) and value.ndim == 2


def row_of(values: Any, row: int) -> Any:
    """One row of what has a row for each invocation, or one for all."""
    array = np.asarray(values, np.float64)
    return array[row if len(array) > 1 else 0]


def width(band: Band, row: int, scale: float = 0.0) -> float:
    """A band's width in ULP of its larger bound, or of `scale` where it holds 0 and that is larger;
    in the component where that is most."""
    low, high = row_of(band.lo, row), row_of(band.hi, row)
    with np.errstate(all="ignore"):
        size = np.maximum(np.abs(low), np.abs(high))
        unit = ulp(np.where((low <= 0.0) & (high >= 0.0), np.maximum(size, scale), size))
        found = np.where(high == low, 0.0, (high - low) / unit)
    return float(np.nan_to_num(found, nan=np.inf).max())


def precision_loss(event: Stored, row: int) -> float:
    """How many ULP wider the band is that one invocation stores than the widest that it read."""
    reads = [value for value in event.reads if is_vector(value)]
    # The size of 1 - x near 0 means nothing: that of what was read does.
    scale = max((_size(value, row) for value in reads), default=0.0)
    own = width(event.value, row)
    if not np.isfinite(own):
        return own
    before = max((width(value, row) for value in reads), default=0.0)
    return max(width(event.value, row, scale) - before, 0.0)


def _size(band: Band, row: int) -> float:
    return float(np.maximum(np.abs(row_of(band.lo, row)), np.abs(row_of(band.hi, row))).max())


_TRUE = (Op.ConstantTrue, Op.SpecConstantTrue)
_FALSE = (Op.ConstantFalse, Op.SpecConstantFalse)
_SCALAR = (Op.Constant, Op.SpecConstant)
_COMPOSITE = (Op.ConstantComposite, Op.SpecConstantComposite)


def value(run: Run, id_: int) -> Value:
    """What a constant, or a global variable's name, stands for."""
    program = run.program
    if id_ in program.variables:
        return Pointer(id_)
    declared = program.module.values[id_]
    op, words = declared.op, declared.words
    type_ = program.types[words[0]]
    if op in _TRUE or op in _FALSE:
        return TriBool.of(np.full((1, 1), op in _TRUE))
    if op in _SCALAR:
        word = np.array([[words[2]]], np.uint32)
        if type_.kind == "float":
            written = literal_of(program.name(id_))
            if written is None:  # the fewest digits that give this float32
                written = float(shortest(word.view(np.float32)[0, 0]))
            return run.arithmetic.literal(written)
        number = word.view(np.int32) if type_.signed else word
        return Integer(number, unsigned=not type_.signed, rules=run.arithmetic.rules)
    if op in _COMPOSITE:
        return compose(type_, run.values(words[2:]))
    if op == Op.ConstantNull:
        return null(type_, run.arithmetic)
    if op == Op.Undef:
        return undefined(type_, run.arithmetic)
    handler = HANDLERS.get(words[2]) if op == Op.SpecConstantOp else None
    if handler is None:
        raise program.not_interpreted(f"a constant of SPIR-V's opcode {op}", 0)
    everywhere = PathState(np.ones(run.count, np.bool_), {})
    return handler(run, Instruction(words[2], words[0], id_, words[3:], 0), everywhere)


MAX_LOOP_ITERATIONS = 4096
"""The limit for a loop, each time that it is entered."""
MAX_BLOCKS = 200_000
"""The default limit for the blocks that a program runs."""
_MAX_STATES = 8  # that wait at one block before they are joined
_MOST_PARTS = 256  # parts of values that are remembered


class EndlessError(NotInterpretedError):
    """A loop or a program goes on after those limits, for the `invocations`."""

    invocations: Flags = np.zeros(0, np.bool_)


Conflict = tuple[Instruction, tuple[int, ...], str]  # with the lines of its calls, and the kind
Watch = Callable[["Run", Instruction, PathState, Value], Value]
"""Called after each instruction but the last of a block, with its result; returns the result that
counts."""


@dataclass(eq=False)
class Run:
    """One run of a program. For instruction handlers: what they read and write.

    Attributes:
        program, arithmetic, count: what is run, in what, for how many invocations.
        places: gl_FragCoord of each invocation, if it is given.
        max_blocks, trace, watch: as of `interpret`.
        for_ranges: whether values are ranges: what nothing is stored to on one of two paths is
            anything where they meet.
        results: each instruction's result by id, as of its last execution, and each constant.
        killed: the invocations that a `discard` may have ended.
        undecided: by line, the invocations that took both sides of a branch there.
        taken: each two blocks, by their labels, of which one was run after the other; 0 comes
            before a function's first.
        blocks: how many blocks were run.
        shared: what a workgroup's variables held when its invocations waited last, by id.
        accesses: loads and stores of these since then, each with the invocations that did it.
        given: what the program's interface holds at first, by id.
        stale: buffers, and images by name, in which something was stored before a barrier.
        texels: by image, the stores of each invocation, in order: whose they are, where, and what.
        conflicts: the invocations to which others of their workgroup do what GLSL does not define.
    """

    program: Program
    arithmetic: Arithmetic
    count: int
    _: KW_ONLY
    places: Array | None = None
    max_blocks: int = MAX_BLOCKS
    trace: Trace | None = None
    watch: Watch | None = None

    def __post_init__(self) -> None:
        rules = self.arithmetic.rules
        self.for_ranges = rules is not None and rules.ranges
        self.results: dict[int, Value] = {}
        self.calls: list[int] = []
        self.killed: Flags = np.zeros(self.count, np.bool_)
        self.undecided: dict[int, Flags] = {}
        self.taken: set[tuple[int, int]] = set()
        self.units: dict[int, tuple[Value, float]] = {}
        self.blocks = 0
        self.shared: dict[int, Value] = {}
        self.accesses: list[tuple[Instruction, tuple[int, ...], Pointer, Flags]] = []
        self.given: dict[int, Value] = {}
        self.stale: set[int | str] = set()
        self.texels: dict[str, list[tuple[Flags, Value, Value]]] = {}
        self.conflicts = defaultdict[Conflict, Flags](lambda: np.zeros(self.count, np.bool_))
        self._reads: list[Value] = []
        self._steps: dict[int, Steps] = {}
        self._parts: dict[tuple[int, Any], tuple[Value, Value]] = {}

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
        except KeyError:  # a constant's first use
            return [self.value(id_) for id_ in ids]

    def part(self, value: Value, index: int) -> Value:
        """A component. Twice the same one is the same object: bands know then that v.x * v.x is a
        square."""
        if isinstance(value, tuple):
            return value[index]
        return self.cache_part(value, index, lambda: component(value, index))

    def cache_part(self, value: Value, how: Any, make: Callable[[], Value]) -> Value:
        """The result of `make`, cached by the value's identity."""
        key = (id(value), how)
        known = self._parts.get(key)
        if known is None:
            if len(self._parts) > _MOST_PARTS:
                self._parts.clear()
            known = self._parts[key] = (value, make())  # kept, or its id might be another's
        return known[1]

    def note_unit(self, value: Value, unit: float) -> None:
        """Remember a power of two that all of a value's numbers are multiples of, 0 if none is."""
        if len(self.units) > _MOST_PARTS:
            self.units.clear()
        self.units[id(value)] = value, unit

    def trace_stored(self, at: Instruction, name: str, value: Value, state: PathState) -> None:
        """Trace a value that was stored; "param" is what glslang calls an argument."""
        if self.trace is not None and name not in ("", "param"):
            calls, reads = tuple(self.calls), tuple(self._reads)
            self.trace(Stored(at, name, value, state.mask, calls, reads))
            self._reads.clear()

    def trace_arguments(self, at: Instruction, function: Function, state: PathState) -> None:
        """Trace the numbers and vectors that a function is passed."""
        if self.trace is None:
            return
        called = self.program.name(function.id).partition("(")[0]
        for id_, of in function.parameters.items():
            value: Any = self.results[id_]
            type_ = self.program.types[of]
            if isinstance(value, Pointer):
                type_ = part_type(self.program.variables[value.variable][0], value.path)
                value = fetch(state.memory.get(value.variable), value.path, state.mask)
            for name, part in split_parts(value, type_, f"{called}({self.program.name(id_)}"):
                self.trace(Stored(at, f"{name})", part, state.mask, tuple(self.calls), ()))

    def note_read(self, value: Value) -> None:
        """Note for the trace what the next value may be computed of."""
        if self.trace is not None:
            self._reads.append(value)

    def note_undecided(self, line: int, invocations: Flags) -> None:
        """Note that invocations took both sides of a branch."""
        self.undecided[line] = self.undecided.get(line, False) | invocations

    def call(self, function: Function, state: PathState) -> PathState | None:
        """Run a function; the state in which it returns, None if it returns nowhere."""
        order = function.order
        first = next(iter(function.blocks))
        self.taken.add((0, first))
        waiting = {first: [state]}
        returned: list[PathState] = []
        visits: dict[int, int] = {}
        while waiting:
            label = min(waiting, key=order.__getitem__) if len(waiting) > 1 else next(iter(waiting))
            arrived = join(waiting.pop(label))
            self._count(visits, label, function.blocks[label][0].line, arrived.mask)
            for target, next_state in self._block(function, label, arrived):
                if target is None:
                    returned.append(next_state)
                    continue
                place = order[target]
                if place <= order[label]:  # a loop turns, those inside of it begin anew
                    visits = {of: n for of, n in visits.items() if order[of] <= place}
                states = waiting.setdefault(target, [])
                states.append(next_state)
                if len(states) > _MAX_STATES:
                    waiting[target] = [join(states)]
        if not returned:
            return None
        end = join(returned)
        for id_ in function.variables:
            end.memory.pop(id_, None)
        return end

    def _count(self, visits: dict[int, int], label: int, line: int, mask: Flags) -> None:
        """Count a block's run, and give up where there are too many."""
        visits[label] = visits.get(label, 0) + 1
        self.blocks += 1
        if visits[label] > MAX_LOOP_ITERATIONS + 1:
            what = f"a loop that goes on after {MAX_LOOP_ITERATIONS} iterations"
        elif self.blocks > self.max_blocks:
            what = f"a program that goes on after {self.max_blocks} blocks"
        else:
            return
        said = self.program.not_interpreted(what, line)
        error = EndlessError(said.message, file=said.file)
        error.invocations = mask
        raise error

    def _block(self, function: Function, label: int, state: PathState) -> Leaving:
        """Run a block; the states that leave it, each with the block that it goes to, None for
        one that returns."""
        if label not in self._steps:
            self._steps[label] = steps_of(function.blocks[label])
        steps, branch, last = self._steps[label]
        results, watch = self.results, self.watch
        for handler, at, is_call in steps:
            try:
                result = handler(self, at, state)
            except UnchoosableError:
                raise self.program.not_interpreted("a choice between samplers", at.line) from None
            except NotGivenError:
                raise
            except FormulaError as error:
                raise self.program.not_interpreted(error.message, at.line) from error
            if type(result) is Missing:
                raise NotGivenError.of(result)
            if watch is not None:
                result = watch(self, at, state, result)
            if at.id:
                results[at.id] = result
            if is_call and not state.mask.any():
                return []  # all were discarded in it
        leaving = branch(self, function, last, state)
        for target, next_state in leaving:
            if target is not None:
                self.taken.add((label, target))
                take_phis(self, function, label, target, next_state)
        return leaving
