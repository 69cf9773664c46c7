"""What goes wrong between the invocations of a workgroup, and in what a geometry stage emits.

Sources: the OpenGL Shading Language 4.60 (Khronos), 8.15 "Geometry Shader Functions", 8.16 "Shader
Invocation Control Functions", 4.3.8 "Shared Variables".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.bands import Integer
from shaderlab.compiler.reflection import Storage
from shaderlab.model.frame import Array

from ..equivalence.comparison import example
from ..equivalence.given import Given
from ..equivalence.interface import Input
from ..interpreter import Program
from ..interpreter.memory import Flags, Pointer, World, fetch
from ..interpreter.program import BARRIER, Instruction
from ..interpreter.running import Run
from ..interpreter.types import Type
from .hazard import Hazard
from .watching import run_watched

RACE, DIVERGENT, TOO_MANY = (
    "race", "barrier in divergent control flow", "more vertices than max_vertices"
)  # fmt: skip
_LOAD, _STORE, _EMIT, _MAX_VERTICES = 61, 62, 218, 26
_NOBODY, _SEVERAL = -1, -2
_MOST = 256  # workgroups that are looked at


@dataclass
class _Accesses:
    """A `Watch` that keeps who wrote and read each element of shared variables since the last
    barrier, and the first workgroup in which two invocations meet.

    Attributes:
        found: by kind and line, the workgroup, and what happens in words.
    """

    lanes: int
    found: dict[tuple[str, int], tuple[int, str]] = field(default_factory=dict)
    wrote: dict[int, Array] = field(default_factory=dict)
    read: dict[int, Array] = field(default_factory=dict)
    values: dict[int, Array] = field(default_factory=dict)

    def __call__(self, run: Run, at: Instruction, world: World, result: Any) -> Any:
        if at.op == BARRIER:
            self._barrier(at, world)
        elif at.op in (_LOAD, _STORE):
            pointer = run.value(at.operands[0])
            if isinstance(pointer, Pointer):
                type_, storage = run.program.variables[pointer.variable]
                if storage == Storage.WORKGROUP:
                    self._access(run, at, world, pointer, type_)
        return result

    def _barrier(self, at: Instruction, world: World) -> None:
        here = world.mask.reshape(-1, self.lanes)
        split = here.any(axis=1) & ~here.all(axis=1)
        if split.any():
            words = "not all invocations of the workgroup come here"
            self.found.setdefault((DIVERGENT, at.line), (int(split.argmax()), words))
        for table in (self.wrote, self.read):
            for accesses in table.values():
                accesses[here.any(axis=1)] = _NOBODY

    def _access(
        self, run: Run, at: Instruction, world: World, pointer: Pointer, type_: Type
    ) -> None:
        element, size, inside = _element(pointer, type_, run.count)
        groups, lanes = np.divmod(np.arange(run.count), self.lanes)
        wrote, read = (
            table.setdefault(pointer.variable, np.full((groups[-1] + 1, size), _NOBODY))
            for table in (self.wrote, self.read)
        )
        rows = np.flatnonzero(world.mask & inside)
        place = (groups[rows], element[rows])
        name = run.program.name(pointer.variable)
        if at.op == _LOAD:
            other = (wrote[place] != _NOBODY) & (wrote[place] != lanes[rows])
            words = f"{name} is read that another invocation wrote without a barrier between"
            self._note(at, groups[rows], other, words)
            _mark(read, place, lanes[rows])
            return
        before = (read[place] != _NOBODY) & (read[place] != lanes[rows])
        words = f"{name} is written that another invocation reads without a barrier between"
        self._note(at, groups[rows], before, words)
        # What the store left behind is the last invocation's value; others' are lost.
        value = _numbers(run.value(at.operands[1]), run.count)[rows]
        kept = _numbers(fetch(run.shared[pointer.variable], pointer.path, world.mask), run.count)
        lost = (value != kept[rows]).any(axis=1)
        words = f"several invocations write to the same element of {name}"
        self._note(at, groups[rows], lost, words)
        _mark(wrote, place, lanes[rows])

    def _note(self, at: Instruction, groups: Array, flags: Flags, words: str) -> None:
        if flags.any():
            self.found.setdefault((RACE, at.line), (int(groups[flags.argmax()]), words))


def _mark(table: Array, place: tuple[Array, Array], lanes: Array) -> None:
    """Note who came to each element of each workgroup."""
    before = table[place]
    table[place] = lanes
    alone = ((before == _NOBODY) | (before == lanes)) & (table[place] == lanes)
    table[place[0][~alone], place[1][~alone]] = _SEVERAL


def _element(pointer: Pointer, type_: Type, count: int) -> tuple[Array, int, Flags]:
    """A number for the element that each invocation means, how many there are, and whether it is
    one of them."""
    number, size, inside = np.zeros(count, np.int64), 1, np.ones(count, np.bool_)
    for index in pointer.path:
        parts = len(type_.members) or type_.count
        own = index.lo[:, 0] if isinstance(index, Integer) else np.array([index])
        inside = inside & (own >= 0) & (own < parts)
        number = number * parts + np.clip(own, 0, parts - 1)
        size, type_ = size * parts, type_.part(0 if isinstance(index, Integer) else index)
    return np.broadcast_to(number, (count,)), size, inside


def _numbers(value: Any, count: int) -> Array:
    if isinstance(value, tuple):
        return np.concatenate([_numbers(part, count) for part in value], axis=1)
    flat = np.asarray(getattr(value, "lo", getattr(value, "all_true", value)), np.float64)
    return np.broadcast_to(flat.reshape(len(flat), -1), (count, flat[0].size))


def between_invocations(
    program: Program, given: Given, inputs: Mapping[str, Input]
) -> Iterator[Hazard]:
    """Races for shared variables, barriers that not all come to, and more vertices than a geometry
    stage declares."""
    lanes = program.lanes
    if lanes > 1:
        given = given.part(np.arange(min(given.count, _MOST)))
        watch = _Accesses(lanes)
        run_watched(program, given, watch)
        for (kind, line), (row, words) in watch.found.items():
            yield _hazard(program, kind, line, words, example(given, row, inputs))
    if program.stage == "geometry":
        most = program.module.modes[_MAX_VERTICES][0]
        emitted = run_watched(program, given).outputs["EmitVertex()"].lo[:, 0]
        if (emitted > most).any():
            row = int(emitted.argmax())
            words = f"{emitted[row]} are emitted, {most} declared"
            line = program.line_of(_EMIT)
            yield _hazard(program, TOO_MANY, line, words, example(given, row, inputs))


def _hazard(
    program: Program, kind: str, line: int, words: str, inputs: Mapping[str, tuple[float, ...]]
) -> Hazard:
    file, own = program.place(line)
    return Hazard(file=file, line=own, kind=kind, message=f"{kind}: {words}", inputs=inputs)
