"""Whether two shaders compute the same: interpreted on the same inputs, with noise.

    answer = compare_programs(load(old), load(new), Plan(ranges={"distance": "0..50"}))
    answer.same                                     # True, False, or None: undetermined
    print(*answer.lines(), sep="; ")

Both run in float64, once as they are and several times with noise that is a little larger than
any rounding. An output differs where the two are further apart than 16 times the spread that noise
makes at that invocation, or where only one of them draws, or is defined.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from shaderlab.compiler.diagnostics import find_declaration
from shaderlab.compiler.spirv import (
    Decoration,
    ExecutionMode,
    Op,
    interface_name,
    type_name,
    unwrap,
)
from shaderlab.engine.jobs import BareWorker
from shaderlab.errors import UsageError, in_file
from shaderlab.files import display_path

from .answer import Answer, Numerics, OutputAnswer, Plan as Plan
from .batches import InputBatch, merge_batches, run_ending
from .coverage import lines_not_run
from .differences import PAIRS, discards, first_difference, jumps, keep_defined, meet_bounds
from .inputs import (
    ALIKE,
    UNIT_VECTOR,
    Domains,
    InputDomain,
    Inputs,
    add_constants,
    coarsen_inputs,
    domains_of,
    inputs_of,
    learn_domains,
    sample_inputs,
    vary_inputs,
)
from .interpreter import Program, adopt_names
from .interpreter.running import EndlessError
from .noise import Compared, Ran, compare, confirm, run
from .portability import MOST, bands_of, compare_accuracy, find_costs
from .requests import ShaderOfFile

_PIXELS = (ExecutionMode.PixelCenterInteger, ExecutionMode.OriginUpperLeft)
_INTERPOLATED = (Decoration.NoPerspective, Decoration.Flat, Decoration.Centroid, Decoration.Sample)
_NUMBERED = (Decoration.Location, Decoration.Binding)
_LAYOUT = (Decoration.Offset, Decoration.RowMajor, Decoration.MatrixStride)
_FIXED = {"std140", "std430"}  # the layouts of blocks that don't depend on the driver
_BITS = range(Op.ShiftRightLogical, Op.BitCount + 1)
_SHORT, _LONG = 300, 3000  # blocks: programs that run more get fewer invocations, and rounds
_LEAST, _ROUNDS, _FEWEST = 256, 5, 24
_MOST_VALUES = 2**22  # of all invocations: those of a program are kept until it ends
_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class _Set:
    """What both programs gave on a set of inputs, and how their outputs compare, by name."""

    batch: InputBatch
    old: Ran
    new: Ran
    compared: dict[tuple[str, str], Compared] = field(default_factory=dict)


def compare_files(
    before: ShaderOfFile, after: ShaderOfFile, stage: str | None, plan: Plan, worker: BareWorker
) -> list[Answer]:
    """The answer on two shader files. Raises as `load` and `compare_programs`."""
    old, new = (shader.program(worker, stage) for shader in (before, after))
    old = adopt_names(old, new) if before.is_module else old
    new = adopt_names(new, old) if after.is_module else new
    with in_file(before.file.path):
        return [compare_programs(old, new, plan)]


def compare_programs(
    old: Program, new: Program, plan: Plan | None = None, captured: Sequence[InputBatch] = ()
) -> Answer:
    """Whether two programs of one stage compute the same. Inputs that a scene gave the old one
    (`captured`) are taken as they are, and varied; without any, inputs are generated. Raises
    NotInterpretedError: one does what the interpreter does not know, or does not end; FormulaError:
    one reads what is not given; UsageError: a range is wrong, or the stages differ."""
    plan = plan or Plan()
    if old.stage != new.stage:
        raise UsageError(f"a {old.stage} shader can't be compared with a {new.stage} shader")
    mine, theirs = inputs_of(old), inputs_of(new)
    inputs = {**mine, **theirs}
    for name in mine.keys() & theirs.keys():
        if mine[name].type != theirs[name].type:
            raise UsageError(
                f"{name} is {mine[name].type} in one, {theirs[name].type} in the other"
            )
    captured = merge_batches(captured, old, plan.count)
    domains = learn_domains(captured) if captured else domains_of(inputs, (old, new), plan.ranges)
    comparison = _Comparison((old, new), inputs, domains, captured, plan)
    try:
        outputs = tuple(comparison.outputs())
        if not captured:
            comparison, outputs = _assume_quaternions(comparison, outputs)
    except EndlessError as error:
        numbers = (n for n, d in domains.items() if (d.source, d.kind) == ("assumed", "number"))
        if free := dict.fromkeys(n.partition("[")[0] for n in numbers if n[:3] != "gl_"):
            error.remedy = f"state ranges for which it ends, of {', '.join(free)}: --range NAME=A:B"
        raise
    outputs = *outputs, *_compare_interfaces(old, new)
    never = list(comparison.notes()) if all(output.same for output in outputs) else []
    unknown = [o.name for o in outputs if o.same and not o.numerics] if plan.accuracy else []
    never += [f"{name}: accuracy not known" for name in unknown]
    words = {n: f"{d} ({d.source})" for n, d in comparison.domains.items() if n in inputs}
    sides = ("OLD", mine, theirs), ("NEW", theirs, mine)
    only = {which: [n for n in some if n not in others] for which, some, others in sides}
    notes = (
        *(f"only {which} reads {', '.join(own)}" for which, own in only.items() if own),
        *never,
    )
    return Answer(old=old.path, new=new.path, outputs=outputs, notes=notes, inputs=words)


def _assume_quaternions(
    comparison: _Comparison, outputs: tuple[OutputAnswer, ...]
) -> tuple[_Comparison, tuple[OutputAnswer, ...]]:
    """The comparison with vec4s of length 1 and its outputs, if they are the same then and mostly
    different else; as they are otherwise."""
    vec4s = [n for n, one in comparison.inputs.items() if one.type == "vec4" and n[:3] != "gl_"]
    turn = {n: UNIT_VECTOR for n in vec4s if comparison.domains[n].source == "assumed"}
    if turn and any(2 * output.different > output.judged for output in outputs):
        turning = replace(comparison, domains={**comparison.domains, **turn}, _freed={})
        found = tuple(turning.outputs())
        if all(o.same for o in found) and any(o.conditions for o in found):
            return turning, found
    return comparison, outputs


def _compare_interfaces(old: Program, new: Program) -> Iterator[OutputAnswer]:
    """An answer on each declaration of both that the application or a stage meets otherwise."""
    mine, theirs = (dict(_interface(program)) for program in (old, new))
    for name, words in mine.items():
        if theirs.get(name, words) != words:
            became = f"{name}: {words or 'default'} became {theirs[name] or 'default'}"
            yield OutputAnswer(name=became, why="interface")


def _interface(program: Program) -> Iterator[tuple[str, str]]:
    """How variables and blocks' members lie and are interpolated, as far as the text says so."""
    module = program.module
    if program.source is None or not program.source.text:
        return
    yield "pixels", ", ".join(mode.name for mode in _PIXELS if mode in module.modes)
    for id_, (pointee, _) in module.variables.items():
        name, element = interface_name(module, id_), unwrap(module, pointee)[1]
        declared = find_declaration(program.source, module.names.get(id_, "") or name)
        said = declared.qualifiers if declared is not None else frozenset()
        kinds = [*_INTERPOLATED, *(kind for kind in _NUMBERED if kind.name.lower() in said)]
        yield name, _format_decorations(module.decorations.get(id_, {}), kinds)
        for i, of in enumerate(module.types[element].words if said & _FIXED else ()):
            laid = _format_decorations(module.member(element, i), _LAYOUT)
            own = module.member_names.get((element, i), "")
            yield f"{name}.{own}", f"{type_name(module, of)}, {laid}"


def _format_decorations(given: Mapping[int, Sequence[int]], kinds: Iterable[Decoration]) -> str:
    return ", ".join(" ".join([k.name, *map(str, given[k])]) for k in kinds if k in given)


@dataclass(eq=False)
class _Comparison:
    """Two programs, and where their inputs come from."""

    programs: tuple[Program, Program]
    inputs: Inputs
    domains: Domains
    captured: Sequence[InputBatch]
    plan: Plan
    _in_bands: tuple[Mapping[str, Any] | None, ...] = ()
    _labels: tuple[set[int], set[int]] = field(default_factory=lambda: (set(), set()))
    _freed: dict[tuple[str, ...], list[_Set]] = field(default_factory=dict)
    _blocks: int = _SHORT  # the most that a program ran
    _endless: int = 0  # invocations that were left out

    def outputs(self) -> Iterator[OutputAnswer]:
        """An answer for each output, on captured inputs and on rounds of others."""
        sets: list[_Set] = []
        pairs: list[tuple[str, str]] = []
        if not self.captured:
            few = sample_inputs(self.inputs, self.domains, _LEAST, 0)
            self._blocks = max(_SHORT, *(run(one, few, 0).blocks for one in self.programs))
        for batch in self._inputs():
            sets.append(self._run(batch))
            pairs = self._names(sets)
            if all(self._is_settled(sets, *pair) for pair in pairs):
                break
        else:
            if not self.captured and self.plan.rounds:
                domains = add_constants(self.domains, self.inputs, self.programs)
                for batch in self._split_long(self._make(domains, self.plan.rounds + 1)):
                    sets += self._end(self._run, batch)
        for name, other in pairs:
            if not name or not other:
                yield OutputAnswer(name=name or other, why="missing")
                continue
            answer = self._answer(sets, name, other)
            if answer.same and self.plan.accuracy:
                answer = replace(answer, numerics=self._numerics(sets[0], name, other))
            if answer.same and self.plan.rounds:
                answer = self._add_conditions(answer, name, other)
            yield answer

    def _inputs(self) -> Iterator[InputBatch]:
        """Captured inputs, rounds of others, and both sides of jumps between those."""
        batch = None
        count = min(self.plan.rounds, max(_ROUNDS * _LONG // self._blocks, 1))
        rounds = (self._make(self.domains, seed) for seed in range(count))
        for batch in itertools.chain(self.captured, rounds):
            yield batch
        if batch is not None and self.plan.rounds:
            coarse = coarsen_inputs(batch, self.domains)
            # Of 0 a loop may have no end.
            yield from (one for one in self._end(self._meet_bounds, coarse) if one.count)
            pairs = min(PAIRS, max(PAIRS * _LONG // self._blocks, _FEWEST))
            around = jumps(self.programs, batch, self.domains, pairs)
            if around is not None:
                yield around

    def _make(self, domains: Domains, seed: int) -> InputBatch:
        """Other inputs; of generated ones fewer where the programs run long, in whole quads."""
        if self.captured:
            return vary_inputs(self.captured[seed % len(self.captured)], domains, seed)
        values = max(len(program.definitions) for program in self.programs)
        most = min(self.plan.count * _SHORT // self._blocks, _MOST_VALUES // (1 + values))
        count = max(most // 128 * 128, _LEAST)
        return sample_inputs(self.inputs, domains, min(count, self.plan.count), seed)

    def _split_long(self, batch: InputBatch) -> Iterator[InputBatch]:
        """The invocations whose integers lie within their domains, and the others: loops of those
        may be long, and all of a batch runs as long as one of it."""
        far = np.zeros(batch.count, np.bool_)
        for name, domain in self.domains.items():
            if name in self.inputs and self.inputs[name].whole and name in batch.each:
                own = batch.each[name].reshape(batch.count, -1)
                far |= ((own < domain.low) | (own > domain.high)).any(axis=1)
        for program in self.programs:
            far[batch.rows_with(np.flatnonzero(far), program)] = True
        yield from (batch.part(np.flatnonzero(rows)) for rows in (~far, far) if rows.any())

    def _run(self, batch: InputBatch) -> _Set:
        one = _Set(batch, run(self.programs[0], batch), run(self.programs[1], batch))
        for labels, ran in zip(self._labels, (one.old, one.new), strict=True):
            labels.update(ran.labels)
        return one

    def _meet_bounds(self, batch: InputBatch) -> InputBatch:
        for program in self.programs:
            batch = meet_bounds(program, batch, self.domains)
        return keep_defined(self.programs, batch)

    def _end(self, act: Callable[[InputBatch], _T], batch: InputBatch) -> Iterator[_T]:
        found, rest = run_ending(self.programs, act, batch)
        self._endless += batch.count - (rest.count if found is not None else 0)
        yield from () if found is None else (found,)

    def notes(self) -> Iterator[str]:
        """Which lines no input came to, of those that were tried; numbers that nearly agree."""
        pairs = list(zip(self.programs, self._labels, strict=True))
        places = [_format_place(p, line) for p, ran in pairs for line in lines_not_run(p, ran)]
        if places:
            yield f"never run: {', '.join(dict.fromkeys(places))}"
        if self._endless:
            yield f"not compared: {self._endless:,} inputs for which a shader goes on for too long"
        old, new = (program.numbers for program in self.programs)
        for a, b in itertools.product(old - new, new - old):
            if abs(a - b) < ALIKE * abs(a):
                whole = a % 1.0 == b % 1.0 == 0.0
                why = "no input shows" if whole else "changes less than rounding may"
                yield f"{a:.{10 if whole else 7}g} became {b:.{10 if whole else 7}g}, which {why}"

    def _is_settled(self, sets: Sequence[_Set], name: str, other: str) -> bool:
        """Whether an output is known to be another one: more inputs add nothing."""
        if not name or not other:
            return True
        return any(self._compare(one, name, other).different.any() for one in sets)

    def _compare(self, one: _Set, name: str, other: str) -> Compared:
        """How an output compares on a batch; computed once."""
        if (name, other) not in one.compared:
            first_difference = compare(one.old, one.new, name, other)
            names = (name, other)
            one.compared[names] = confirm(self.programs, one.batch, first_difference, names)
        return one.compared[name, other]

    def _names(self, sets: Sequence[_Set]) -> list[tuple[str, str]]:
        """The outputs' names in pairs: of the same name, or the only ones that are left over.
        Built-in outputs to which neither program writes are none."""
        mine = list(dict.fromkeys(n for one in sets for n in one.old.outputs))
        theirs = list(dict.fromkeys(n for one in sets for n in one.new.outputs))
        pairs = [(n, n) for n in mine if n in theirs and not _is_unwritten(sets, n)]
        only, others = [n for n in mine if n not in theirs], [n for n in theirs if n not in mine]
        if len(only) == len(others) == 1:
            return [*pairs, (only[0], others[0])]
        return [*pairs, *((n, "") for n in only), *(("", n) for n in others)]

    def _answer(self, sets: Sequence[_Set], name: str, other: str) -> OutputAnswer:
        called = name if name == other else f"{name} → {other}"
        found = [self._compare(one, name, other) for one in sets]
        judged = sum(int(compared.judged.sum()) for compared in found)
        different = sum(int(compared.different.sum()) for compared in found)
        if not different:
            return OutputAnswer(name=called, judged=judged)
        one, compared = next(
            pair for pair in zip(sets, found, strict=True) if pair[1].different.any()
        )
        row = _worst(compared)
        apart = np.concatenate([compared.apart[compared.different] for compared in found])
        finite = apart[np.isfinite(apart)]
        return OutputAnswer(
            name=called,
            judged=judged,
            different=different,
            apart=float(finite.max()) if finite.size else float("inf"),
            why="value" if finite.size else compared.why,
            example=one.batch.example(row, self.inputs),
            place=self._place(one, row),
            gives=(_value(one.old, name, row), _value(one.new, other, row)),
        )

    def _place(self, one: _Set, row: int) -> str:
        """The first line that stores another value at an invocation; where only one program
        discards, the line where it does."""
        found, old, new = first_difference(self.programs, one.batch, row)
        if found is not None:
            return _format_place(self.programs[1], found.line)
        for program, ran, taken in zip(self.programs, (one.old, one.new), (old, new), strict=True):
            if ran.discarded[0, row]:
                last = taken[-1].line if taken else 0
                lines = discards(program)
                return _format_place(program, next((n for n in lines if n >= last), lines[-1]))
        return ""

    def _numerics(self, one: _Set, name: str, other: str) -> Numerics | None:
        """How the accuracy changes, on some of the first inputs."""
        rows = np.arange(min(one.batch.count, MOST))
        if not self._in_bands:
            some = one.batch.part(rows)
            self._in_bands = tuple(bands_of(p, some, unwritten=False) for p in self.programs)
        old, new = self._in_bands
        if old is None or new is None or name not in old or other not in new:
            return None
        values = one.old.outputs[name][0, rows]
        found = compare_accuracy((old[name], new[other]), values)
        if found is None:
            return None
        worse, better, row = found
        some = one.batch.part(rows)
        each = [find_costs(program, some, row) for program in self.programs]
        costs = tuple(max(a - b, default=None) for a, b in itertools.permutations(each))
        near = some.example(row, self.inputs)
        return Numerics(worse=worse, better=better, near=near, costs=costs)

    def _add_conditions(self, answer: OutputAnswer, name: str, other: str) -> OutputAnswer:
        """The answer with what it holds under: assumptions about inputs without which the output is
        another one, and inputs that show it."""
        relaxed = self._relaxed
        found = self._find_without(relaxed, name, other) if relaxed else None
        if found is None:
            return answer
        one, compared = found
        alone = {n: self._find_without((n,), name, other) for n in relaxed}
        needed = [n for n, shown in alone.items() if shown is not None]
        if needed:
            one, compared = alone[needed[0]] or found
        row = _worst(compared)
        return replace(
            answer,
            conditions=tuple(self.domains[n].condition(n) for n in needed or relaxed),
            example=one.batch.example(row, self.inputs),
            gives=(_value(one.old, name, row), _value(one.new, other, row)),
        )

    @cached_property
    def _relaxed(self) -> tuple[str, ...]:
        """The inputs of which something is assumed."""
        return tuple(n for n, domain in self.domains.items() if domain.relaxed is not None)

    def _find_without(
        self, relaxed: tuple[str, ...], name: str, other: str
    ) -> tuple[_Set, Compared] | None:
        """Where an output differs without what is assumed of some inputs; None if it does not."""
        if relaxed not in self._freed:
            self._freed[relaxed] = list(self._sets_without(relaxed))
        for one in self._freed[relaxed]:
            compared, old = self._compare(one, name, other), one.old.outputs.get(name)
            if old is not None:  # what it leaves undefined there, the new one may define
                defined = np.isfinite(old[0]).all(axis=-1) | one.old.discarded[0]
                compared = replace(compared, different=compared.different & defined)
            if compared.different.any():
                return one, compared
        return None

    def _sets_without(self, relaxed: tuple[str, ...]) -> Iterator[_Set]:
        domains = {
            n: (n in relaxed and domain.relaxed) or domain for n, domain in self.domains.items()
        }
        # A loop that ends because of what is assumed goes on without it: no condition then.
        yield from self._end(self._run, self._make(domains, self.plan.rounds))
        whole = {
            n: InputDomain("number", -(2.0**31), 2.0**31 - 1.0)
            for n in relaxed
            if n in self.inputs and self.inputs[n].whole and domains[n].source == "assumed"
        }
        if whole and any(program.line_of(op) for program in self.programs for op in _BITS):
            yield from self._end(self._run, self._make({**domains, **whole}, self.plan.rounds))


def _is_unwritten(sets: Sequence[_Set], name: str) -> bool:
    return name.startswith("gl_") and all(
        np.isnan(ran.outputs[name]).all()
        for one in sets
        for ran in (one.old, one.new)
        if name in ran.outputs
    )


def _format_place(program: Program, line: int) -> str:
    file, number = program.place(line)
    return f"{display_path(file)}:{number}" if file else f"line {number}"


def _worst(compared: Compared) -> int:
    """The invocation to show: of those that differ, the one where both are farthest apart."""
    apart = np.where(compared.different, compared.apart, -1.0)
    finite = np.where(np.isfinite(apart), apart, -1.0)
    return int(finite.argmax() if finite.max() >= 0.0 else apart.argmax())


def _value(ran: Ran, name: str, row: int) -> tuple[float, ...]:
    if ran.discarded[0, row]:
        return ()
    return tuple(float(v) for v in ran.outputs[name][0, row])
