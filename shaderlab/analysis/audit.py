"""Audit a program: what may go wrong in it, on the inputs that it may get.

    audit = audit_program(load(source), Plan(ranges={"distance": "0..50"}))
    audit.clean                                             # no hazard was shown
    print(*audit.lines(), sep="; ")

A hazard is shown by an invocation: in float32 an instruction's operands are ones for which GLSL
defines no result there, and an output depends on its result.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from shaderlab.model.frame import Array, Bindings, Texels

from .batches import InputBatch, join_batches, merge_batches, run_batch
from .checks import INDEX, OVERFLOW, Place, WatchedInstruction, Watcher
from .hazards import Audit as Audit, Hazard as Hazard, find_dependents, reached_by_0
from .inputs import (
    Input,
    InputDomain,
    domains_of,
    inputs_of,
    interpolate_inputs,
    is_place,
    keep_in_order,
    sample_inputs,
)
from .interpreter import Program
from .portability import Spread, find_spreads, widest_spreads
from .undefined import divergent, excess_vertices, undefined_values

RANDOM, ZERO, EQUAL = range(3)
"""What is special about an invocation: nothing; a place that is 0; two places that are equal."""
_MIN_TEXEL = 0.02  # of sampled textures; a smaller one is a direction's
_NEAR_0 = 1e-5
_MAX_PAIRS = 120
_COPIES = 3  # of each special input, with other values of all others
_SHRINKING, _START = 0.4, 0.5  # of the steps of a search, in widths of the ranges
_GENERATIONS = 18
_PARENTS = 6
_CHILDREN = 4, 16  # of each parent, at least and at most
_MAX_CHILDREN = 4096  # in a generation
_STEPS = 8  # on the way between both signs of a margin
_TINY = 1e-6  # of the usual margin: so near to a change of sign it passes through 0


def first_batch(
    inputs: Mapping[str, Input], domains: Mapping[str, InputDomain], count: int
) -> InputBatch:
    """Random invocations, and special ones after them. Textures hold 0 and 1 here and there."""
    batch = sample_inputs(inputs, domains, count, 0)
    textures = {name: _with_extremes(texels) for name, texels in batch.bindings.textures.items()}
    batch = InputBatch(batch.each, Bindings(textures=textures), batch.count)
    parts = [batch]
    rng = np.random.default_rng(5)
    for each in _special_values(inputs, domains):
        some = batch.part(rng.integers(0, batch.count, _COPIES))
        changed = dict(some.each)
        for name, value in each.items():
            other = changed[value] if isinstance(value, str) else np.float32(value)
            changed[name] = np.broadcast_to(other, changed[name].shape).copy()
        keep_in_order(changed, domains)
        parts.append(InputBatch(changed, batch.bindings, some.count))
    return join_batches(parts)


def find_origins(
    batch: InputBatch, inputs: Mapping[str, Input], domains: Mapping[str, InputDomain]
) -> Array:
    """What is special about each invocation, (count,), where the author has not said that it may
    be: a place is 0, or its w is, or two places are equal."""
    places = [
        name
        for name, one in inputs.items()
        if is_continuous(one, domains[name]) and one.type != "float" and is_place(name)
        if domains[name].source == "assumed" and domains[name].kind == "number"
    ]
    found = np.full(batch.count, RANDOM)
    for name in places:
        found[(batch.each[name] == 0.0).all(axis=1)] = ZERO
        if inputs[name].type == "vec4":  # its w, by which perspective divides
            found[np.abs(batch.each[name][:, 3]) < _NEAR_0] = ZERO
    for a, b in itertools.islice(itertools.combinations(places, 2), _MAX_PAIRS):
        if inputs[a].type == inputs[b].type:
            found[(batch.each[a] == batch.each[b]).all(axis=1)] = EQUAL
    return found


def _with_extremes(texels: Texels) -> Texels:
    """The texture with rows of 0 and of 1, unless it holds directions."""
    if texels.values.min() < _MIN_TEXEL:
        return texels
    values = texels.values.copy()
    rows = values.shape[-3]
    values[..., : rows // 4, :, :] = 0.0
    values[..., rows // 2 : 3 * rows // 4, :, :] = 1.0
    return replace(texels, values=values)


def _special_values(
    inputs: Mapping[str, Input], domains: Mapping[str, InputDomain]
) -> Iterator[dict[str, float | str]]:
    """Inputs that are all 0 or an end of their range, and pairs that are equal: a value by input,
    or the name of another one."""
    continuous = [n for n, one in inputs.items() if is_continuous(one, domains[n])]
    for name in continuous:
        domain = domains[name]
        if domain.kind == "number":
            for value in dict.fromkeys((0.0, domain.low, domain.high)):
                if domain.low <= value <= domain.high:
                    yield {name: value}
    pairs = [
        (a, b)
        for a, b in itertools.combinations(continuous, 2)
        if inputs[a].type == inputs[b].type and domains[a].kind == domains[b].kind
        if domains[b].kind == "unit"
        or domains[a].low <= domains[b].low <= domains[b].high <= domains[a].high
    ]
    for a, b in pairs[:_MAX_PAIRS]:
        yield {a: b}


def is_continuous(one: Input, domain: InputDomain) -> bool:
    """Whether an input is a float, or a vector of floats, that may be changed a little."""
    return one.name != "gl_FragCoord" and one.type.startswith(("float", "vec")) and domain.kind in (
        "number", "unit"
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Counterexample:
    """An invocation, `row` of `batch`, at which an instruction goes wrong; where `crossing` its
    operand is nearly 0 and has both signs around it. `origin` is `RANDOM`, `ZERO` or `EQUAL`."""

    place: Place
    watched: WatchedInstruction
    batch: InputBatch
    row: int
    origin: int = RANDOM
    crossing: bool = False

    @property
    def operands(self) -> tuple[float, ...]:
        """The instruction's operands there, of one component."""
        known = self.watched.operands
        return known.get(self.row) or next(iter(known.values()), ())


def watch_batch(program: Program, batch: InputBatch) -> dict[Place, WatchedInstruction]:
    """How far each instruction is from going wrong on some invocations."""
    watcher = Watcher(batch.count)
    run_batch(program, batch, watch=watcher)
    return watcher.found


def find_counterexamples(
    found: Mapping[Place, WatchedInstruction], batch: InputBatch, origins: Array
) -> Iterator[Counterexample]:
    """The first invocation at which each instruction goes wrong; a random one if there is one."""
    for place, one in found.items():
        rows = np.flatnonzero(one.bad)
        if rows.size:
            row = int(rows[np.argmin(origins[rows], axis=0)])
            yield Counterexample(place, one, batch, row, int(origins[row]))


class InputSearch:
    """A search that tries to make every instruction of a program go wrong.

    It keeps the invocations that come closest for each instruction, and tries others near them,
    ever closer.

    Attributes:
        tried: how many invocations were run.
        found: a counterexample for each instruction that goes wrong, by its place.
        first: the random invocations that it began with.
    """

    def __init__(
        self,
        program: Program,
        inputs: Mapping[str, Input],
        domains: Mapping[str, InputDomain],
        count: int,
    ) -> None:
        self._program, self._inputs, self._domains = program, inputs, domains
        self._continuous = [n for n, one in inputs.items() if is_continuous(one, domains[n])]
        self._rng = np.random.default_rng(11)
        batch = first_batch(inputs, domains, count)
        self.first = batch.part(np.arange(count))
        self.tried = 0
        self.found: dict[Place, Counterexample] = {}
        self._best: dict[Place, tuple[InputBatch, Array]] = {}  # the closest, and their margins
        self._usual: dict[Place, float] = {}  # the median margin
        # An invocation with a negative and one with a positive margin.
        self._signs: dict[Place, tuple[InputBatch, InputBatch]] = {}
        self._try(batch)

    def run(self) -> None:
        """Search from the closest invocations on, for all instructions at once."""
        for generation in range(_GENERATIONS):
            children = list(self._children(generation))
            if not children:
                break
            self._try(join_batches(children))
        for place, (below, above) in self._signs.items():
            if self._is_open(place):
                crossing = self._find_crossing(place, below, above)
                if crossing is not None:
                    self.found[place] = crossing

    def _is_open(self, place: Place) -> bool:
        """Whether no random invocation is known at which it goes wrong."""
        return place not in self.found or self.found[place].origin != RANDOM

    def _try(self, batch: InputBatch) -> None:
        """Run some invocations and keep the closest."""
        origins = find_origins(batch, self._inputs, self._domains)
        found = watch_batch(self._program, batch)
        self.tried += batch.count
        for example in find_counterexamples(found, batch, origins):
            known = self.found.get(example.place)
            if known is None or example.origin < known.origin:
                self.found[example.place] = example
        for place, one in found.items():
            if self._is_open(place):
                self._usual.setdefault(place, _median(np.abs(one.margin)))
                self._keep_closest(place, one, batch, origins)

    def _keep_closest(
        self, place: Place, one: WatchedInstruction, batch: InputBatch, origins: Array
    ) -> None:
        size = np.abs(one.margin) if one.check.crosses else one.margin
        size = np.where(origins == RANDOM, size, np.inf)
        rows = np.argsort(size, kind="stable")[:_PARENTS]
        rows = rows[np.isfinite(size[rows])]
        if not rows.size:
            return
        best, margin = batch.part(rows), one.margin[rows]
        if place in self._best:
            before, known = self._best[place]
            best, margin = join_batches([best, before]), np.concatenate([margin, known])
        order = np.argsort(np.abs(margin) if one.check.crosses else margin, kind="stable")
        self._best[place] = (best.part(order[:_PARENTS]), margin[order[:_PARENTS]])
        if one.check.crosses and place not in self._signs:
            margin = np.where(np.isfinite(one.margin), one.margin, 0.0)
            if (margin > 0.0).any() and (margin < 0.0).any():
                below, above = (
                    batch.part(np.array([np.where(signs, np.abs(margin), np.inf).argmin()]))
                    for signs in (margin < 0.0, margin > 0.0)
                )
                self._signs[place] = (below, above)

    def _children(self, generation: int) -> Iterator[InputBatch]:
        open_ones = [parents for place, (parents, _) in self._best.items() if self._is_open(place)]
        each = int(np.clip(_MAX_CHILDREN // (_PARENTS * max(len(open_ones), 1)), *_CHILDREN))
        for parents in open_ones[: _MAX_CHILDREN // (_PARENTS * each)]:
            rows = np.repeat(np.arange(parents.count), each)
            yield self._move(parents.part(rows), generation)

    def _move(self, parents: InputBatch, generation: int) -> InputBatch:
        """A child of each parent, moved in one input, or in one component of it, or in all."""
        rng, count = self._rng, parents.count
        each = dict(parents.each)
        which = rng.integers(-1, max(len(self._continuous), 1), count)
        size = _START * _SHRINKING**generation
        for i, name in enumerate(self._continuous):
            domain, values = self._domains[name], each[name].astype(np.float64)
            width = 1.0 if domain.kind == "unit" else domain.high - domain.low
            step = rng.normal(size=values.shape) * width * size
            one = rng.integers(0, values.shape[1], count)[:, None] == np.arange(values.shape[1])
            step = np.where(one | (rng.random(count) < 0.5)[:, None], step, 0.0)
            moves = ((which == i) | (which == -1))[:, None]
            each[name] = domain.clip(np.where(moves, values + step, values))
        keep_in_order(each, self._domains)
        for name, one_input in self._inputs.items():  # integers are sampled anew here and there
            if one_input.workgroup is None and one_input.whole and name in each:
                values, domain = each[name], self._domains[name]
                fresh = rng.integers(int(domain.low), int(domain.high) + 1, values.shape)
                each[name] = np.where(rng.random(values.shape) < 0.3, fresh, values)
        return InputBatch(each, parents.bindings, count)

    def _find_crossing(
        self, place: Place, below: InputBatch, above: InputBatch
    ) -> Counterexample | None:
        """Follow a margin on the straight way from a negative to a positive one, to where it passes
        through 0; None where a condition excludes what lies between."""
        t = np.linspace(0.0, 1.0, _STEPS + 1)[:, None]
        for _ in range(_GENERATIONS):
            each = {n: np.repeat(values, len(t), axis=0) for n, values in below.each.items()}
            each |= interpolate_inputs(below, above, t, self._continuous, self._domains)
            batch = InputBatch(each, below.bindings, len(t))
            self.tried += batch.count
            one = watch_batch(self._program, batch).get(place)
            if one is None or not (one.bad.any() or np.isfinite(one.margin).all()):
                return None
            row = int(np.abs(one.margin).argmin())
            origin = int(find_origins(batch, self._inputs, self._domains)[row])
            found = Counterexample(place, one, batch, row, origin, crossing=not one.bad.any())
            changes = np.flatnonzero(one.margin[:-1] * one.margin[1:] < 0.0)
            if one.bad.any() or not changes.size:
                break
            below, above = (batch.part(np.array([k])) for k in (changes[0], changes[0] + 1))
        near = abs(found.watched.margin[found.row])
        return found if near <= _TINY * self._usual[place] else None


def _median(margin: Array) -> float:
    known = margin[np.isfinite(margin)]
    return float(np.median(known)) if known.size else 0.0


_ONLY_AT_0 = "; only if an input is 0"
_MAX_CAPTURED = 16_384  # invocations of a case's draws with the same textures


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How a program is audited.

    Attributes:
        ranges: "a..b", "a:b" or "unit" for inputs, by name.
        count: the number of random invocations.
        precision: whether to measure how far devices may differ, at highp and at mediump.
    """

    ranges: Mapping[str, str] = field(default_factory=dict)
    count: int = 4096
    precision: bool = False


def audit_program(
    program: Program, plan: Plan | None = None, captured: Sequence[InputBatch] = ()
) -> Audit:
    """Find what may go wrong in a program.

    Args:
        program: one stage.
        plan: how it is audited.
        captured: what a scene's draws give it. Without any, inputs are searched.

    Raises:
        NotInterpretedError: it does what the interpreter does not know, or does not end.
        FormulaError: it reads what is not given.
        UsageError: a range is wrong.
    """
    plan = plan or Plan()
    inputs = inputs_of(program)
    if captured:
        batches = merge_batches(captured, program, _MAX_CAPTURED)
        examples = [
            example
            for batch in batches
            for example in find_counterexamples(
                watch_batch(program, batch), batch, np.full(batch.count, RANDOM)
            )
        ]
        tried = sum(batch.count for batch in batches)
        words = dict.fromkeys(inputs, "as in the case")
    else:
        domains = domains_of(inputs, [program], plan.ranges)
        search = InputSearch(program, inputs, domains, plan.count)
        search.run()
        examples, tried, batches = list(search.found.values()), search.tried, [search.first]
        words = {name: f"{domain} ({domain.source})" for name, domain in domains.items()}
    hazards = [hazard for e in examples for hazard in _hazards(program, e, inputs)]
    spreads: list[Spread] = []
    for batch in batches:
        hazards += undefined_values(program, batch, inputs)
        hazards += divergent(program, batch, inputs, made_up=not captured)
        hazards += excess_vertices(program, batch, inputs)
        if plan.precision:
            spreads += find_spreads(program, batch, inputs)
    return Audit(
        file="" if program.source is None else program.source.path,
        hazards=tuple(_deduplicate(hazards)),
        tried=tried,
        inputs=words,
        spreads=tuple(widest_spreads(spreads)),
    )


def _hazards(
    program: Program, example: Counterexample, inputs: Mapping[str, Input]
) -> Sequence[Hazard]:
    """The hazard about an instruction; none where no output depends on its result."""
    place, one = example.place, example.watched
    outputs = find_dependents(program, example.batch, example.row, place)
    if not outputs and place.kind != INDEX.kind:
        return ()
    if example.crossing and not reached_by_0(
        program, example.batch, example.row, place, example.operands[-1]
    ):
        return ()
    words = one.check.words(*example.operands)
    if example.crossing:
        words = f"{words}, nearly: the divisor passes through 0 here"
    if example.origin != RANDOM:
        words += "; only if two inputs are equal" if example.origin == EQUAL else _ONLY_AT_0
    file, line = program.place(one.at.line)
    values = {name: tuple(map(float, value)) for name, value in outputs.items()}
    return (
        Hazard(
            file=file,
            line=line,
            kind=place.kind,
            message=words if words.startswith(place.kind) else f"{place.kind}: {words}",
            evident=example.origin == RANDOM,
            inputs=example.batch.example(example.row, inputs),
            outputs=values,
            calls=tuple(program.place(call)[1] for call in place.calls),
        ),
    )


def _deduplicate(hazards: Sequence[Hazard]) -> list[Hazard]:
    """One of each line and kind, evident ones before others; by line."""
    found: dict[tuple[str, int, str], Hazard] = {}
    for hazard in sorted(hazards, key=lambda f: not f.evident):
        found.setdefault((hazard.file, hazard.line, hazard.kind), hazard)
    explained = {(file, line) for file, line, kind in found if kind != OVERFLOW.kind}
    for key in [key for key in found if key[2] == OVERFLOW.kind and key[:2] in explained]:
        del found[key]
    return sorted(found.values(), key=lambda f: (f.file, f.line, f.kind))
