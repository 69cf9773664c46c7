"""Values that nobody stored: what is read before it is written, and outputs that are not written.

The program is run twice, each time with another value in all that nothing was stored to.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.bands import Integer, Truth
from shaderlab.compiler.reflection import Storage
from shaderlab.model.frame import Array

from ..equivalence.comparing import flattened
from ..equivalence.comparison import example
from ..equivalence.given import Given
from ..equivalence.interface import Input
from ..interpreter import Interpreted, Numbers, Program
from ..interpreter.instructions import HANDLERS
from ..interpreter.memory import Pointer, World, spelt
from ..interpreter.program import Instruction
from ..interpreter.running import Run
from ..interpreter.values import null
from .consequences import alone
from .hazard import Hazard
from .watching import run_watched

READ, UNWRITTEN = "uninitialised read", "output not written"
_UNDEFINED, _VARIABLE, _LOAD = 1, 59, 61
_VALUES = (0.21, 3.4)
_ARGUMENT = "param"  # what glslang calls the copy of an argument
_INTERFACE = "gl_"  # built-in outputs need no value
_NEEDED = ("gl_FragDepth", "gl_Position")  # but for these, where a shader writes to them at all


@dataclass(frozen=True)
class _Filled(Numbers):
    """float32 in which what nothing was stored to is a certain number."""

    dtype: Any = np.float32
    value: float = 0.0

    def undefined(self) -> Array:
        return np.full((1, 1), self.value, np.float32)


@dataclass
class _Filling:
    """A `Watch` that stores a number to variables, those outside of functions too, or to one of
    them alone; it keeps what is loaded at some rows."""

    value: float
    only: int | None = None
    rows: slice | None = None
    loads: list[tuple[int, str, Array]] = field(default_factory=list)
    filled: dict[int, None] = field(default_factory=dict)
    began: bool = False

    def __call__(self, run: Run, at: Instruction, world: World, result: Any) -> Any:
        if not self.began:
            self.began = True
            if self._fill_globals(run, world) and at.op == _LOAD:  # it may be of one of them
                result = HANDLERS[_LOAD](run, at, world)
        if at.op == _VARIABLE and len(at.operands) == 1:
            self.filled[at.id] = None
            type_, _ = run.program.variables[at.id]
            world.memory[at.id] = _stand_in(null(type_, run.arithmetic), self._value(at.id))
        elif at.op == _UNDEFINED:
            self.filled[at.id] = None
            result = _stand_in(result, self._value(at.id))
        elif at.op == _LOAD and self.rows is not None and world.mask[self.rows].any():
            self._keep(run, at, world, result)
        return result

    def _fill_globals(self, run: Run, world: World) -> bool:
        memories = {Storage.PRIVATE: world.memory, Storage.WORKGROUP: run.shared}
        before = len(self.filled)
        for id_, (type_, storage) in run.program.variables.items():
            if storage in memories and memories[storage].get(id_) is None:
                self.filled[id_] = None
                value = _stand_in(null(type_, run.arithmetic), self._value(id_))
                memories[storage][id_] = value
        return len(self.filled) > before

    def _value(self, id_: int) -> float:
        return self.value if self.only in (None, id_) else _VALUES[0]

    def _keep(self, run: Run, at: Instruction, world: World, result: Any) -> None:
        pointer = run.value(at.operands[0])
        assert isinstance(pointer, Pointer) and self.rows is not None
        type_, _ = run.program.variables[pointer.variable]
        name = spelt(run.program.name(pointer.variable), type_, pointer.path)
        parts = [v for _, v in flattened({"": result})] if _has_numbers(result) else []
        here = world.mask[self.rows]
        values = [(v[self.rows][here] if len(v) > 1 else v).ravel() for v in parts]
        self.loads.append((at.line, name, np.concatenate(values) if values else np.zeros(0)))


def _has_numbers(value: Any) -> bool:
    if isinstance(value, tuple):
        return all(_has_numbers(part) for part in value)
    return isinstance(value, np.ndarray | Integer | Truth)


def _stand_in(value: Any, number: float) -> Any:
    if isinstance(value, tuple):
        return tuple(_stand_in(part, number) for part in value)
    if isinstance(value, Integer):
        return Integer(np.full_like(value.lo, int(number)), unsigned=value.unsigned)
    if isinstance(value, Truth):
        return Truth.known(np.full_like(value.all_true, number > 1.0))
    return np.full_like(value, number)


def undefined_values(
    program: Program, given: Given, inputs: Mapping[str, Input]
) -> Iterator[Hazard]:
    """What is read before it is written and changes an output, and outputs not written."""
    watch = _Filling(_VALUES[0])
    plain = _run(program, given, watch)
    whole = _run(program, given, _Filling(_VALUES[1]))
    if _differing(plain, whole, given.count):
        for id_ in watch.filled:
            other = _run(program, given, _Filling(_VALUES[1], id_))
            for output, row in list(_differing(plain, other, given.count).items())[:1]:
                yield _read(program, given, row, id_, output, inputs)
    other = _run(program, given, _Filling(_VALUES[0]), _VALUES[1])
    for output, row in _differing(plain, other, given.count, unwritten=True).items():
        file, line = _declaration(program, output)
        yield Hazard(
            file=file, line=line, kind=UNWRITTEN,
            message=f"{UNWRITTEN}: {_in_words(program, output)}, or a part of it has none",
            inputs=example(given, row, inputs),
        )  # fmt: skip


def _run(
    program: Program, given: Given, watch: _Filling, outputs: float = _VALUES[0]
) -> Interpreted:
    return run_watched(program, given, watch, _Filled(value=outputs))


def _differing(
    one: Interpreted, other: Interpreted, count: int, *, unwritten: bool = False
) -> dict[str, int]:
    """The first row at which each output differs, of those that do; with `unwritten`, of those that
    need a value."""
    gone, gone_too = (np.broadcast_to(r.discarded.all_true, (count,)) for r in (one, other))
    if (gone != gone_too).any():
        return {"discard": int((gone != gone_too).argmax())}
    found = {}
    others = dict(flattened(other.outputs))
    for name, a in flattened(one.outputs):
        b = others.get(name)
        built_in = unwritten and name.startswith(_INTERFACE)
        if b is None or (built_in and not name.startswith(_NEEDED)):
            continue
        differs = (~((a == b) | (np.isnan(a) & np.isnan(b)))).any(axis=-1) & ~gone
        if differs.any() and not (built_in and differs.all()):
            found[name] = int(differs.argmax())
    return found


def _read(
    program: Program, given: Given, row: int, id_: int, output: str, inputs: Mapping[str, Input]
) -> Hazard:
    """The hazard of a variable's value that nobody stored: at the first line that loads it."""
    some, own = alone(program, given, row)
    lanes = program.lanes
    rows = slice(own * lanes, (own + 1) * lanes)
    watches = [_Filling(value, id_, rows) for value in _VALUES]
    for watch in watches:
        _run(program, some, watch)
    inside = program.definitions.get(id_)
    file, line = (
        _declaration(program, program.name(id_)) if inside is None else program.place(inside.line)
    )
    for (at, name, a), (_, _, b) in zip(*(watch.loads for watch in watches), strict=False):
        if name != _ARGUMENT and not np.array_equal(a, b, equal_nan=True):
            file, line = program.place(at)
            break
    name = program.name(id_) or "a function's result"
    return Hazard(
        file=file, line=line, kind=READ,
        message=f"{READ}: {name} has no value here, and {output} depends on it",
        inputs=example(given, row, inputs),
    )  # fmt: skip


def _in_words(program: Program, output: str) -> str:
    name, bracket, number = output.rpartition("[")
    if program.stage != "geometry" or not bracket:
        return f"{output} has no value here"
    return f"{name} has no value in vertex {number.rstrip(']')}"


def _declaration(program: Program, output: str) -> tuple[str, int]:
    """Where an output is declared, or where `main` is."""
    text = "" if program.source is None else program.source.code
    own = re.escape(output.partition("[")[0].partition(".")[0])
    for pattern in (rf"\bout\b[^;{{}}]*\b{own}\b", rf"\b{own}\b", r"\bmain\b"):
        found = re.search(pattern, text)
        if found:
            return program.place(text.count("\n", 0, found.end()) + 1)
    return program.place(1)
