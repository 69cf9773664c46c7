"""Looking for invocations at which instructions go wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from shaderlab.model.frame import Array

from ..equivalence.given import Given
from ..equivalence.interface import Input
from ..equivalence.roles import Role
from ..interpreter import Program
from .population import DRAWN, Search, concatenated, first_ones, origins
from .watching import Place, Watched, Watcher, run_watched

_GENERATIONS = 18
_PARENTS = 6
_CHILDREN = 4, 16  # of each parent, at least and at most
_MOST = 4096  # children in a generation, each invocation of a workgroup counted
_LEAST = 128  # workgroups, whose invocations run together
_STEPS = 8  # on the way between both signs of a margin
_TINY = 1e-6  # of the usual margin: so near to a change of sign it passes through 0


@dataclass(frozen=True, eq=False)
class Witness:
    """An invocation at which an instruction goes wrong.

    Attributes:
        place, watched: the instruction.
        given, row: the invocation; `given` may be a set that it is one of.
        origin: what is special about it; see `population`.
        operands: one component's.
        crossing: whether the operand is nearly 0, and on both sides of it.
    """

    place: Place
    watched: Watched
    given: Given
    row: int
    origin: int = DRAWN
    operands: tuple[float, ...] = ()
    crossing: bool = False


def watched(program: Program, given: Given) -> dict[Place, Watched]:
    """How far each instruction is from going wrong on some invocations."""
    watcher = Watcher(given.count, program.lanes)
    run_watched(program, given, watcher)
    return watcher.found


def witnesses_of(found: Mapping[Place, Watched], given: Given, origin: Array) -> Iterator[Witness]:
    """The first invocation at which each instruction goes wrong; one at random, if there is."""
    for place, one in found.items():
        rows = np.flatnonzero(one.bad)
        if rows.size:
            row = int(rows[np.argmin(origin[rows], axis=0)])
            yield Witness(place, one, given, row, int(origin[row]), _operands(one, row))


def _operands(one: Watched, row: int) -> tuple[float, ...]:
    return one.operands.get(row) or next(iter(one.operands.values()), ())


class Hunt:
    """Tries to make every instruction of a program go wrong.

    Attributes:
        tried: how many invocations were run.
        witnesses: of each instruction that goes wrong, by its place.
        drawn: the invocations at random that it began with.
    """

    def __init__(
        self,
        program: Program,
        inputs: Mapping[str, Input],
        roles: Mapping[str, Role],
        count: int,
    ) -> None:
        self._program = program
        self._search = Search(inputs, roles)
        lanes = program.lanes
        self._most, count = max(_MOST // lanes, _LEAST), max(count // lanes, _LEAST)
        self._inputs, self._roles = inputs, roles
        first = first_ones(inputs, roles, count)
        self.drawn = first.part(np.arange(count))
        self.tried = 0
        self.witnesses: dict[Place, Witness] = {}
        self._best: dict[Place, tuple[Given, Array]] = {}  # the closest ones and their margins
        self._usual: dict[Place, float] = {}
        self._ends: dict[Place, tuple[Given, Given]] = {}  # of both signs, one invocation each
        self._take(first)

    def run(self) -> None:
        """Search from the closest invocations on, for all instructions at once."""
        for generation in range(_GENERATIONS):
            children = list(self._children(generation))
            if not children:
                break
            self._take(concatenated(children))
        self._crossings()

    def _take(self, given: Given) -> None:
        """Run some invocations and keep the closest."""
        origin = origins(given, self._inputs, self._roles)
        found = watched(self._program, given)
        self.tried += given.count
        for witness in witnesses_of(found, given, origin):
            known = self.witnesses.get(witness.place)
            if known is None or witness.origin < known.origin:
                self.witnesses[witness.place] = witness
        for place, one in found.items():
            if place in self.witnesses and self.witnesses[place].origin == DRAWN:
                continue
            self._usual.setdefault(place, _median(np.abs(one.margin)))
            self._keep(place, one, given, origin)

    def _keep(self, place: Place, one: Watched, given: Given, origin: Array) -> None:
        size = np.abs(one.margin) if one.check.crosses else one.margin
        size = np.where(origin == DRAWN, size, np.inf)
        rows = np.argsort(size, kind="stable")[:_PARENTS]
        rows = rows[np.isfinite(size[rows])]
        if not rows.size:
            return
        parts, margins = [given.part(rows)], [one.margin[rows]]
        if place in self._best:
            before, known = self._best[place]
            parts.append(before)
            margins.append(known)
        merged, margin = concatenated(parts), np.concatenate(margins)
        order = np.argsort(np.abs(margin) if one.check.crosses else margin, kind="stable")
        self._best[place] = (merged.part(order[:_PARENTS]), margin[order[:_PARENTS]])
        if one.check.crosses:
            self._bracket(place, one, given)

    def _bracket(self, place: Place, one: Watched, given: Given) -> None:
        """Keep an invocation of each sign; two neighbours on the way between them, once there is
        one."""
        margin = np.where(np.isfinite(one.margin), one.margin, 0.0)
        if place not in self._ends:
            above, below = margin > 0.0, margin < 0.0
            if above.any() and below.any():
                nearest = (np.where(f, np.abs(margin), np.inf).argmin() for f in (below, above))
                rows = [int(row) for row in nearest]
                ends = tuple(given.part(np.array([row])) for row in rows)
                self._ends[place] = (ends[0], ends[1])

    def _children(self, generation: int) -> Iterator[Given]:
        open_ones = [
            parents
            for place, (parents, _) in self._best.items()
            if place not in self.witnesses or self.witnesses[place].origin != DRAWN
        ]
        each = int(np.clip(self._most // (_PARENTS * max(len(open_ones), 1)), *_CHILDREN))
        for parents in open_ones[: self._most // (_PARENTS * each)]:
            rows = np.repeat(np.arange(parents.count), each)
            yield self._search.moved(parents.part(rows), generation)

    def _crossings(self) -> None:
        """Follow each margin that has both signs to where it changes."""
        for place, (below, above) in self._ends.items():
            if place in self.witnesses and self.witnesses[place].origin == DRAWN:
                continue
            found = self._crossing(place, below, above)
            if found is not None:
                self.witnesses[place] = found

    def _crossing(self, place: Place, below: Given, above: Given) -> Witness | None:
        rows = np.zeros(_STEPS + 1, np.int64)
        low, high = 0.0, 1.0
        found = None
        for _ in range(_GENERATIONS):
            t = np.linspace(low, high, _STEPS + 1)
            given = self._search.between(below.part(rows), above.part(rows), t)
            self.tried += given.count
            one = watched(self._program, given).get(place)
            if one is None:
                return found
            if one.bad.any():
                row = int(one.bad.argmax())
                return Witness(
                    place, one, given, row, self._origin(given, row), _operands(one, row)
                )
            if not np.isfinite(one.margin).all():  # a condition keeps what lies between out
                return None
            sign = np.sign(one.margin)
            turns = np.flatnonzero(sign[:-1] * sign[1:] < 0.0)
            if not turns.size:
                return found
            k = int(turns[0])
            if np.abs(one.margin[k : k + 2]).max() <= _TINY * self._usual[place]:
                row = k + int(np.abs(one.margin[k : k + 2]).argmin())
                origin = self._origin(given, row)
                found = Witness(place, one, given, row, origin, _operands(one, row), crossing=True)
            low, high = t[k], t[k + 1]
        return found

    def _origin(self, given: Given, row: int) -> int:
        return int(origins(given, self._inputs, self._roles)[row])


def _median(margin: Array) -> float:
    known = margin[np.isfinite(margin)]
    return float(np.median(known)) if known.size else 0.0
