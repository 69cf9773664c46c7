"""Invocations to try: drawn at random, special ones, and ones near those that almost go wrong."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from shaderlab.model.frame import Array, Bindings, Texels

from .batches import InputBatch, join_batches, run_batch
from .checks import Place, WatchedInstruction, Watcher
from .inputs import Input, InputDomain, is_place, keep_in_order, sample_inputs
from .interpreter import Program

DRAWN, NOTHING, EQUAL = range(3)
"""What is special about an invocation: nothing; a place that is 0; two places that are one."""
_LEAST_TEXEL = 0.02  # of textures that are drawn; less is a direction's
_NEAR_0 = 1e-5
_MOST_PAIRS = 120
_COPIES = 3  # of each special input, with other values of all others
_SHRINKING, _START = 0.4, 0.5  # of the steps of a search, in widths of the ranges


def first_ones(
    inputs: Mapping[str, Input], domains: Mapping[str, InputDomain], count: int
) -> InputBatch:
    """Invocations at random, with special ones after them. Textures hold 0 and 1 here and there."""
    batch = sample_inputs(inputs, domains, count, 0)
    textures = {name: _with_ends(texels) for name, texels in batch.bindings.textures.items()}
    batch = InputBatch(batch.each, Bindings(textures=textures), batch.count)
    parts = [batch]
    rng = np.random.default_rng(5)
    for each in _special(inputs, domains):
        some = batch.part(rng.integers(0, batch.count, _COPIES))
        changed = dict(some.each)
        for name, value in each.items():
            other = changed[value] if isinstance(value, str) else np.float32(value)
            changed[name] = np.broadcast_to(other, changed[name].shape).copy()
        keep_in_order(changed, domains)
        parts.append(InputBatch(changed, batch.bindings, some.count))
    return join_batches(parts)


def origins(
    batch: InputBatch, inputs: Mapping[str, Input], domains: Mapping[str, InputDomain]
) -> Array:
    """What is special about each invocation that nobody said may be, (count,): a place is 0, or
    its w is, or two are the same one."""
    places = [
        name
        for name, one in inputs.items()
        if is_steady(one, domains[name]) and one.type != "float" and is_place(name)
        if domains[name].source == "assumed" and domains[name].kind == "number"
    ]
    found = np.full(batch.count, DRAWN)
    for name in places:
        found[(batch.each[name] == 0.0).all(axis=1)] = NOTHING
        if inputs[name].type == "vec4":  # its w, by which perspective divides
            found[np.abs(batch.each[name][:, 3]) < _NEAR_0] = NOTHING
    for a, b in itertools.islice(itertools.combinations(places, 2), _MOST_PAIRS):
        if inputs[a].type == inputs[b].type:
            found[(batch.each[a] == batch.each[b]).all(axis=1)] = EQUAL
    return found


def _with_ends(texels: Texels) -> Texels:
    """The texture with rows of 0 and of 1, unless it holds directions."""
    if texels.values.min() < _LEAST_TEXEL:
        return texels
    values = texels.values.copy()
    rows = values.shape[-3]
    values[..., : rows // 4, :, :] = 0.0
    values[..., rows // 2 : 3 * rows // 4, :, :] = 1.0
    return replace(texels, values=values)


def _special(
    inputs: Mapping[str, Input], domains: Mapping[str, InputDomain]
) -> Iterator[dict[str, float | str]]:
    """Inputs that are all 0 or an end of their range, and pairs that are equal: a value by input,
    or the name of another one."""
    steady = [n for n, one in inputs.items() if is_steady(one, domains[n])]
    for name in steady:
        domain = domains[name]
        if domain.kind == "number":
            for value in dict.fromkeys((0.0, domain.low, domain.high)):
                if domain.low <= value <= domain.high:
                    yield {name: value}
    pairs = [
        (a, b)
        for a, b in itertools.combinations(steady, 2)
        if inputs[a].type == inputs[b].type and domains[a].kind == domains[b].kind
        if domains[b].kind == "unit" or _meet(domains[a], domains[b])
    ]
    for a, b in pairs[:_MOST_PAIRS]:
        yield {a: b}


def _meet(a: InputDomain, b: InputDomain) -> bool:
    """Whether any value of one is one of the other's."""
    return a.low <= b.low and b.high <= a.high


def is_steady(one: Input, domain: InputDomain) -> bool:
    """Whether an input is a float, or a vector of floats, that may be changed a little."""
    return one.name != "gl_FragCoord" and one.type.startswith(("float", "vec")) and domain.kind in (
        "number", "unit"
    )  # fmt: skip


class Search:
    """Children of invocations that are close to going wrong: moved a little, ever less.

    Args:
        inputs, roles: what may be moved, and where to.
    """

    def __init__(self, inputs: Mapping[str, Input], domains: Mapping[str, InputDomain]) -> None:
        self._inputs, self._roles = inputs, domains
        self._steady = [n for n, one in inputs.items() if is_steady(one, domains[n])]
        self._rng = np.random.default_rng(11)

    def moved(self, parents: InputBatch, generation: int) -> InputBatch:
        """A child of each parent: in one input, or in one component of it, or in all."""
        rng, count = self._rng, parents.count
        each = dict(parents.each)
        which = rng.integers(-1, len(self._steady), count) if self._steady else np.zeros(count)
        size = _START * _SHRINKING**generation
        for i, name in enumerate(self._steady):
            domain, values = self._roles[name], each[name].astype(np.float64)
            width = 1.0 if domain.kind == "unit" else domain.high - domain.low
            step = rng.normal(size=values.shape) * width * size
            one = rng.integers(0, values.shape[1], count)[:, None] == np.arange(values.shape[1])
            step = np.where(one | (rng.random(count) < 0.5)[:, None], step, 0.0)
            moves = ((which == i) | (which == -1))[:, None]
            each[name] = self._kept(name, np.where(moves, values + step, values))
        keep_in_order(each, self._roles)
        return InputBatch(self._whole(each), parents.bindings, count)

    def between(self, starts: InputBatch, ends: InputBatch, t: Array) -> InputBatch:
        """Invocations on the straight ways from some to others, at a share of each, (count,)."""
        each = dict(starts.each)
        for name in self._steady:
            a, b = (g.each[name].astype(np.float64) for g in (starts, ends))
            each[name] = self._kept(name, a + t[:, None] * (b - a))
        return InputBatch(each, starts.bindings, starts.count)

    def _kept(self, name: str, values: Array) -> Array:
        domain = self._roles[name]
        if domain.kind == "unit":
            with np.errstate(all="ignore"):
                values = values / np.linalg.norm(values, axis=1, keepdims=True)
            return np.nan_to_num(values, nan=0.57735).astype(np.float32)
        return np.clip(values, domain.low, domain.high).astype(np.float32)

    def _whole(self, each: dict[str, Array]) -> dict[str, Array]:
        """With integers drawn anew here and there."""
        for name, one in self._inputs.items():
            if one.workgroup is not None:
                continue  # they number the invocations
            if one.type.startswith(("int", "ivec", "uint", "uvec")) and name in each:
                values, domain = each[name], self._roles[name]
                fresh = self._rng.integers(int(domain.low), int(domain.high) + 1, values.shape)
                each[name] = np.where(self._rng.random(values.shape) < 0.3, fresh, values)
        return each


_GENERATIONS = 18
_PARENTS = 6
_CHILDREN = 4, 16  # of each parent, at least and at most
_MOST = 4096  # children in a generation, each invocation of a workgroup counted
_LEAST = 128  # workgroups, whose invocations run together
_STEPS = 8  # on the way between both signs of a margin
_TINY = 1e-6  # of the usual margin: so near to a change of sign it passes through 0


@dataclass(frozen=True, eq=False)
class Counterexample:
    """An invocation at which an instruction goes wrong.

    Attributes:
        place, watched: the instruction.
        given, row: the invocation; `given` may be a set that it is one of.
        origin: what is special about it; see `population`.
        operands: one component's.
        crossing: whether the operand is nearly 0, and on both sides of it.
    """

    place: Place
    watched: WatchedInstruction
    batch: InputBatch
    row: int
    origin: int = DRAWN
    operands: tuple[float, ...] = ()
    crossing: bool = False


def watch_batch(program: Program, batch: InputBatch) -> dict[Place, WatchedInstruction]:
    """How far each instruction is from going wrong on some invocations."""
    watcher = Watcher(batch.count, program.workgroup_size)
    run_batch(program, batch, watch=watcher)
    return watcher.found


def counterexamples_of(
    found: Mapping[Place, WatchedInstruction], batch: InputBatch, origin: Array
) -> Iterator[Counterexample]:
    """The first invocation at which each instruction goes wrong; one at random, if there is."""
    for place, one in found.items():
        rows = np.flatnonzero(one.bad)
        if rows.size:
            row = int(rows[np.argmin(origin[rows], axis=0)])
            yield Counterexample(place, one, batch, row, int(origin[row]), _operands(one, row))


def _operands(one: WatchedInstruction, row: int) -> tuple[float, ...]:
    return one.operands.get(row) or next(iter(one.operands.values()), ())


class InputSearch:
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
        domains: Mapping[str, InputDomain],
        count: int,
    ) -> None:
        self._program = program
        self._search = Search(inputs, domains)
        size = program.workgroup_size
        self._most, count = max(_MOST // size, _LEAST), max(count // size, _LEAST)
        self._inputs, self._roles = inputs, domains
        first = first_ones(inputs, domains, count)
        self.sample_inputs = first.part(np.arange(count))
        self.tried = 0
        self.examples: dict[Place, Counterexample] = {}
        self._best: dict[Place, tuple[InputBatch, Array]] = {}  # the closest ones and their margins
        self._usual: dict[Place, float] = {}
        self._ends: dict[
            Place, tuple[InputBatch, InputBatch]
        ] = {}  # of both signs, one invocation each
        self._take(first)

    def run(self) -> None:
        """Search from the closest invocations on, for all instructions at once."""
        for generation in range(_GENERATIONS):
            children = list(self._children(generation))
            if not children:
                break
            self._take(join_batches(children))
        self._crossings()

    def _take(self, batch: InputBatch) -> None:
        """Run some invocations and keep the closest."""
        origin = origins(batch, self._inputs, self._roles)
        found = watch_batch(self._program, batch)
        self.tried += batch.count
        for example in counterexamples_of(found, batch, origin):
            known = self.examples.get(example.place)
            if known is None or example.origin < known.origin:
                self.examples[example.place] = example
        for place, one in found.items():
            if place in self.examples and self.examples[place].origin == DRAWN:
                continue
            self._usual.setdefault(place, _median(np.abs(one.margin)))
            self._keep(place, one, batch, origin)

    def _keep(
        self, place: Place, one: WatchedInstruction, batch: InputBatch, origin: Array
    ) -> None:
        size = np.abs(one.margin) if one.check.crosses else one.margin
        size = np.where(origin == DRAWN, size, np.inf)
        rows = np.argsort(size, kind="stable")[:_PARENTS]
        rows = rows[np.isfinite(size[rows])]
        if not rows.size:
            return
        parts, margins = [batch.part(rows)], [one.margin[rows]]
        if place in self._best:
            before, known = self._best[place]
            parts.append(before)
            margins.append(known)
        merge_batches, margin = join_batches(parts), np.concatenate(margins)
        order = np.argsort(np.abs(margin) if one.check.crosses else margin, kind="stable")
        self._best[place] = (merge_batches.part(order[:_PARENTS]), margin[order[:_PARENTS]])
        if one.check.crosses:
            self._bracket(place, one, batch)

    def _bracket(self, place: Place, one: WatchedInstruction, batch: InputBatch) -> None:
        """Keep an invocation of each sign; two neighbours on the way between them, once there is
        one."""
        margin = np.where(np.isfinite(one.margin), one.margin, 0.0)
        if place not in self._ends:
            above, below = margin > 0.0, margin < 0.0
            if above.any() and below.any():
                nearest = (np.where(f, np.abs(margin), np.inf).argmin() for f in (below, above))
                rows = [int(row) for row in nearest]
                ends = tuple(batch.part(np.array([row])) for row in rows)
                self._ends[place] = (ends[0], ends[1])

    def _children(self, generation: int) -> Iterator[InputBatch]:
        open_ones = [
            parents
            for place, (parents, _) in self._best.items()
            if place not in self.examples or self.examples[place].origin != DRAWN
        ]
        each = int(np.clip(self._most // (_PARENTS * max(len(open_ones), 1)), *_CHILDREN))
        for parents in open_ones[: self._most // (_PARENTS * each)]:
            rows = np.repeat(np.arange(parents.count), each)
            yield self._search.moved(parents.part(rows), generation)

    def _crossings(self) -> None:
        """Follow each margin that has both signs to where it changes."""
        for place, (below, above) in self._ends.items():
            if place in self.examples and self.examples[place].origin == DRAWN:
                continue
            found = self._crossing(place, below, above)
            if found is not None:
                self.examples[place] = found

    def _crossing(
        self, place: Place, below: InputBatch, above: InputBatch
    ) -> Counterexample | None:
        rows = np.zeros(_STEPS + 1, np.int64)
        low, high = 0.0, 1.0
        found = None
        for _ in range(_GENERATIONS):
            t = np.linspace(low, high, _STEPS + 1)
            batch = self._search.between(below.part(rows), above.part(rows), t)
            self.tried += batch.count
            one = watch_batch(self._program, batch).get(place)
            if one is None:
                return found
            if one.bad.any():
                row = int(one.bad.argmax())
                return Counterexample(
                    place, one, batch, row, self._origin(batch, row), _operands(one, row)
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
                origin = self._origin(batch, row)
                found = Counterexample(
                    place, one, batch, row, origin, _operands(one, row), crossing=True
                )
            low, high = t[k], t[k + 1]
        return found

    def _origin(self, batch: InputBatch, row: int) -> int:
        return int(origins(batch, self._inputs, self._roles)[row])


def _median(margin: Array) -> float:
    known = margin[np.isfinite(margin)]
    return float(np.median(known)) if known.size else 0.0
