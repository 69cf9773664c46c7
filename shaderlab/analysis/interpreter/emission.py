"""What a geometry stage emits: of each invocation one vertex after the other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands import Integer, Truth
from shaderlab.compiler.reflection import Storage

from .memory import World
from .program import Instruction
from .values import Value, broadcast, null, select, undefined

if TYPE_CHECKING:
    from .running import Run


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
        if storage == Storage.OUTPUT:
            value = world.memory.get(id_)
            yield id_, undefined(type_, run.arithmetic) if value is None else value


def _nothing(run: Run, id_: int) -> Value:
    return null(run.program.variables[id_][0], run.arithmetic)
