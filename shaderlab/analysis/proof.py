"""Proof in place of sampling: something holds for every input of the ranges, or not for this one.

Boxes of inputs are run in bands. A box in which nothing may go wrong is done with; any other one
is halved, until its ends are neighbours or there were too many. The middle and the ends of boxes
are run in float32 besides: one of them may be a counterexample.
docs/internals/proof.md says why nothing is claimed that does not hold.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from shaderlab.bands import Band, TriBool
from shaderlab.errors import FormulaError, NotInterpretedError
from shaderlab.glslmath.choice import isinf, isnan
from shaderlab.model.frame import Array

from .answer import format_inputs
from .batches import InputBatch, run_batch
from .boxes import ARITHMETIC, BoxWatcher, Space
from .checks import Place, WatchedInstruction, Watcher
from .hazards import Claim
from .inputs import MOST_NUMBERS, Domains, Inputs
from .interpreter import Interpreted, Program
from .interpreter.values import Flags
from .undefined import NEEDED

BOXES = 200_000  # that are run at most
_AT_ONCE = 2048
_MOST_BATCHES = 16  # of MOST_NUMBERS each, that the boxes of a search may fill
_MOST_OF_A_BOX = 8  # such batches that the points of one box may fill
_POINTS = 16_384  # run in float32 for so many boxes
_BOXES_A_FAILURE = 8192  # a loop that does not end takes long
_LONG = 400  # instructions that are run: a box of a longer program counts for several
_FIRST = 1e35  # times a width: more than any effect
_NARROWER = 256.0  # times than the widest side: a side is not halved before that
_FEW, _ROUNDS = 64, 3  # boxes that are halved so often before they are run again
_OUTPUT, _UNKNOWN = -1, -2  # ids of places: an output, what could not be run

Condition = Callable[[Mapping[str, Any], InputBatch], Mapping[str, Any]]  # what holds, in words


class Point(NamedTuple):
    """An invocation, `row` of `batch`, and which instruction goes wrong there; None for outputs."""

    batch: InputBatch
    row: int
    watched: WatchedInstruction | None


def are_finite(outputs: Mapping[str, Any], batch: InputBatch) -> Mapping[str, Any]:
    """The condition that each float output is a finite number."""
    return {
        f"{name} is a finite number": ~(isnan(value) | isinf(value))
        for name, value in _floats(outputs)
    }


def _floats(outputs: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in outputs.items():
        if isinstance(value, tuple):
            yield from _floats({f"{name}[{i}]": part for i, part in enumerate(value)})
        elif isinstance(value, Band | np.ndarray) and (name[:3] != "gl_" or name in NEEDED):
            yield name, value


class Proof:
    """A search over all inputs of some ranges.

    Args:
        program, inputs, domains: one stage, and what it reads, as of `domains_of`.
        condition: what has to hold of the outputs for the inputs.
        tried: inputs to begin with.
        counts: which inputs settle a place, by default all; `points` has others if none does.
        drawn: what draws give the program, whose ends are the ranges.

    `points` has a counterexample for each place that has one, `reached` all that one came to.
    """

    def __init__(
        self, program: Program, inputs: Inputs, domains: Domains, *,
        condition: Condition = are_finite, tried: Sequence[InputBatch] = (),
        counts: Callable[[InputBatch], Flags] | None = None, hazards: bool = True,
        boxes: int = BOXES, max_blocks: int = 2000, drawn: InputBatch | None = None,
    ) -> None:  # fmt: skip
        self.tried = 0
        self.points: dict[Place, Point] = {}
        self._program, self._condition, self._hazards = program, condition, hazards
        self.space = Space(program, inputs, domains, drawn)
        self._batch = max(MOST_NUMBERS // (1 + len(self.space.low)), 1)  # boxes of MOST_NUMBERS
        self._waiting = min(boxes, _MOST_BATCHES * self._batch)  # how many may be run yet
        self.reached: set[Place] = set()
        self._settled, self._counts = set[Place](), counts
        self._numbers: dict[Place, int] = {}  # the column of each place in what is open
        self._lines: dict[Place, int] = {}
        # What is left: boxes that can't be halved, and what is open in each of them.
        self._left: list[tuple[Array, Array, Flags]] = []
        self._interpret = partial(run_batch, program)
        for batch in tried:
            self._try(batch)
        self._interpret = partial(run_batch, program, max_blocks=max_blocks)
        self._search()

    def _search(self) -> None:
        low, high = self.space.low[None], self.space.high[None]
        opened: Flags = np.zeros((1, 0), np.bool_)
        self._patience = self._waiting // _BOXES_A_FAILURE
        self._at_once = max(min(_AT_ONCE, self._batch // 2), 1)
        while len(low) and self._waiting > 0 and self._patience >= 0:
            now = min(self._at_once, self._waiting)
            some = low[:now], high[:now]
            found = self._run(*some)
            for place in found:
                self._numbers.setdefault(place, len(self._numbers))
            flags = np.zeros((len(some[0]), len(self._numbers)), np.bool_)
            for place, bad in found.items():
                flags[:, self._numbers[place]] = bad
            halves = self._unsettled(*some, flags)
            if self._waiting > 0:
                halves = self._halve(*halves)
            wider = np.zeros((len(opened[now:]), flags.shape[1]), np.bool_)
            wider[:, : opened.shape[1]] = opened[now:]
            rest = low[now:], high[now:], wider
            low, high, opened = map(np.concatenate, zip(rest, halves, strict=True))
        self._left.append((low, high, opened))

    def _unsettled(self, low: Array, high: Array, flags: Flags) -> tuple[Array, Array, Flags]:
        """The boxes in which something is open that is not refuted, and that alone."""
        flags = flags & np.array([p not in self._settled for p in self._numbers], np.bool_)
        kept = flags.any(axis=1)
        return low[kept], high[kept], flags[kept]

    def _run(self, low: Array, high: Array) -> dict[Place, Flags]:
        """What may go wrong in which boxes; of those that can't be run nothing is known."""
        batch = self.space.ranges(low, high)
        watcher = BoxWatcher(batch.count, self.space.texels)
        try:
            result = self._interpret(batch, ARITHMETIC, watch=watcher)
        except NotInterpretedError as error:
            self._patience -= 1
            self._at_once = max(self._at_once // 4, 1)  # one of them spoils all
            return {Place(_UNKNOWN, (), error.message): np.ones(batch.count, np.bool_)}
        finally:
            self._waiting -= batch.count * -(-watcher.steps // _LONG)
        self._lines |= watcher.lines
        return (watcher.bad if self._hazards else {}) | self._judge(result, batch)

    def _judge(self, result: Interpreted, batch: InputBatch) -> dict[Place, Flags]:
        """Where the condition may not hold; in float32, where it does not."""
        drawn = ~np.broadcast_to(result.discarded.all_true, (batch.count,))
        found = {}
        for name, holds in self._condition(result.outputs, batch).items():
            truth = holds.all_true if isinstance(holds, TriBool) else np.asarray(holds)
            if truth.dtype != bool or truth.shape[:1] not in ((), (1,), (batch.count,)):
                message = f"the condition gives {holds!r:.60}, no truth value for each input"
                raise FormulaError(message, remedy="compare the results: lambda y: y >= 0.0")
            fails = ~truth.reshape(*truth.shape[:1] or (1,), -1).all(axis=1)
            found[Place(_OUTPUT, (), name)] = np.broadcast_to(fails, drawn.shape) & drawn
        return found

    def _halve(self, low: Array, high: Array, flags: Flags) -> tuple[Array, Array, Flags]:
        """The halves of boxes, each at the side that matters most, and what is open in them."""
        if not low.size:  # there may be no number to halve
            self._left.append((low, high, flags))
            return low[:0], high[:0], flags[:0]
        weights = self.space.relative(low, high)
        points = (2 * low.shape[1] + 3) * self.space.rows  # of a box
        few = max(_POINTS // points, 1) if points < _MOST_OF_A_BOX * self._batch else 0
        effects = self._effects(low[:few], high[:few], flags[:few])
        effects[weights[:few] * _NARROWER < weights[:few].max(axis=1, keepdims=True)] = 0.0
        has_effect = effects.max(axis=1, keepdims=True) > 0.0
        widths = weights.copy()
        weights[:few] = np.where(has_effect, effects, weights[:few])
        weights = np.where(self.space.urgent(low, high), _FIRST * widths, weights)
        ends = ~self.space.divisible(low, high).any(axis=1)
        self._left.append((low[ends], high[ends], flags[ends]))
        low, high, flags, weights = low[~ends], high[~ends], flags[~ends], weights[~ends]
        for _ in range(min(len(low), 1 if len(low) > _FEW else _ROUNDS)):
            sides = np.where(self.space.divisible(low, high), weights, -1.0).argmax(axis=1)
            weights[np.arange(len(low)), sides] /= 2.0
            low, high = self.space.halve(low, high, sides)
            flags, weights = (np.concatenate([part] * 2) for part in (flags, weights))
        inside = self.space.feasible(low, high) & (low <= high).all(axis=1)
        return self._unsettled(low[inside], high[inside], flags[inside])

    def _effects(self, low: Array, high: Array, flags: Flags) -> Array:
        """How much each side of a box changes what is open in it, from the middle to an end. What
        goes wrong at one of these points is refuted."""
        count, sides = low.shape
        if not count:
            return low
        middle = np.where(self.space.whole, np.floor((low + high) / 2.0), (low + high) / 2.0)
        points = np.repeat(middle[:, None], 2 * sides + 3, axis=1)
        points[:, -2], points[:, -1] = low, high
        for k in range(sides):
            points[:, 2 * k + 1, k], points[:, 2 * k + 2, k] = low[:, k], high[:, k]
        try:
            batch = self.space.points(points.reshape(-1, sides))
            found, outputs = self._try(batch)
        except NotInterpretedError:
            return np.zeros((count, sides))
        sizes = [np.zeros(batch.count)]
        which = np.zeros(len(self._numbers), np.int64)
        for place, number in self._numbers.items():
            if place in found or place.id == _OUTPUT:
                which[number] = len(sizes)
                sizes.append(found[place].margin if place in found else outputs + sizes[0])
        first = which[flags.argmax(axis=1)]
        own = np.stack(sizes)[:, :: self.space.rows].reshape(-1, count, 2 * sides + 3)
        own = own[first, np.arange(count)]
        with np.errstate(all="ignore"):
            changes = np.abs(own[:, 1:-2] - own[:, :1]).reshape(count, sides, 2).max(axis=2)
            return np.asarray(np.nan_to_num(changes, posinf=1e30))

    def _try(self, batch: InputBatch) -> tuple[dict[Place, WatchedInstruction], Any]:
        """Run inputs in float32: what goes wrong is refuted. How far each instruction is from that,
        and the sum of the outputs."""
        self.tried += batch.count
        watcher = Watcher(batch.count, made_up=not self.space.is_drawn)
        result = self._interpret(batch, watch=watcher)
        self.reached.update(watcher.found)
        bad = {place: one.bad for place, one in watcher.found.items() if self._hazards}
        counted = ~np.zeros(1, np.bool_) if self._counts is None else self._counts(batch)
        for place, rows in (bad | self._judge(result, batch)).items():
            if rows.any() and place not in self._settled:
                counts = bool((rows & counted).any())
                row = int((rows & counted if counts else rows).argmax())
                self.points[place] = Point(batch, row, watcher.found.get(place))
                self._settled |= {place} if counts else set()
        with np.errstate(invalid="ignore"):
            outputs = [v.astype(np.float64).sum(axis=1) for _, v in _floats(result.outputs)]
            return watcher.found, sum(outputs)

    def claims(self) -> list[Claim]:
        """What is proved and what is open, by line; what is refuted is in `points`."""
        found = []
        unknown = {p.kind: number for p, number in self._numbers.items() if p.id == _UNKNOWN}
        refuted = {self._name(place) for place in self._settled}
        for place, number in self._numbers.items():
            key = self._name(place)
            if key in refuted:
                continue
            share, note = self._remaining([number, *unknown.values()])
            note = ", ".join([note, *unknown] if note else ())
            found.append(Claim(*key, "open" if note else "proved", share, note))
        found.sort(key=lambda c: (c.status == "open", c.share))
        worst = {(c.file, c.line, c.what): c for c in found}
        return sorted(worst.values(), key=lambda c: (c.line == 0, c.line, c.what))

    def refuted_claims(self) -> list[Claim]:
        """What does not hold for an input of the ranges, which need be none that is drawn."""
        found = {}
        for place, (batch, row, _) in self.points.items():
            note = f"not with {format_inputs(batch.example(row, self.space.inputs))}"
            found[self._name(place)] = Claim(*self._name(place), "open", note=note)
        return list(found.values())

    def _name(self, place: Place) -> tuple[str, int, str]:
        """What is claimed of a place: one claim for all of a kind in a line."""
        if place.id < 0:
            what = place.kind if place.id == _OUTPUT else "nothing goes wrong"
            return self._program.path, 0, what
        return *self._program.place(self._lines.get(place, 0)), f"no {place.kind}"

    def _remaining(self, numbers: list[int]) -> tuple[float, str]:
        """The share of the range in which one of these is open, and the largest box of it."""
        share, largest, words = 0.0, -1.0, ""
        for low, high, flags in self._left:
            rows = flags[:, [n for n in numbers if n < flags.shape[1]]].any(axis=1)
            volumes = self.space.relative(low[rows], high[rows]).prod(axis=1)
            if rows.any() and volumes.max() > largest:
                k, largest = int(volumes.argmax()), volumes.max()
                words = self.space.describe(low[rows][k], high[rows][k]) or "everywhere"
            share += float(volumes.sum())
        return min(share, 1.0), words and f"such as {words}".replace("such as every", "every")
