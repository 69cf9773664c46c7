"""Two programs compared on rounds of inputs: the same mathematics, or from where on not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from shaderlab.equivalence.answer import Answer, Numerics, OutputAnswer
from shaderlab.equivalence.comparing import Compared, Ran, compare, confirmed, run
from shaderlab.equivalence.drawing import drawn
from shaderlab.equivalence.given import Given, merged
from shaderlab.equivalence.interface import Input, declared_ranges, inputs_of
from shaderlab.equivalence.jumps import jumps
from shaderlab.equivalence.locating import discards, first, steps
from shaderlab.equivalence.noise import Noisy
from shaderlab.equivalence.numerics import MOST, accuracy, bands_of
from shaderlab.equivalence.roles import Role, roles_of, unknown_names
from shaderlab.equivalence.varying import learned, varied
from shaderlab.errors import UsageError, nearest
from shaderlab.files import display_path
from shaderlab.interpreter import Program

_ENDS = 1e-6  # what stored values may differ by where a step is called the same


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How two programs are compared.

    Attributes:
        ranges: "a..b", "a:b" or "unit" for inputs, by name.
        rounds: how many sets of inputs are made up, or captured ones varied.
        count: invocations in each that is made up.
        accuracy: whether bands are asked how accurate both are.
    """

    ranges: Mapping[str, str] = field(default_factory=dict)
    rounds: int = 5
    count: int = 4096
    accuracy: bool = True


@dataclass(frozen=True, eq=False)
class _Found:
    """A comparison of one output on one set of inputs."""

    given: Given
    compared: Compared
    old: Ran
    new: Ran


def compare_programs(
    old: Program, new: Program, plan: Plan | None = None, captured: Sequence[Given] = ()
) -> Answer:
    """Whether two programs of one stage compute the same.

    Args:
        old, new: the programs.
        plan: how they are compared.
        captured: inputs that a scene gave the old one. They are taken as they are, and varied;
            without any, inputs are made up.

    Raises:
        NotInterpretedError: one does what the interpreter does not know, or does not end.
        FormulaError: one reads what is not given.
        UsageError: a range is wrong, or the stages differ.
    """
    plan = plan or Plan()
    if old.stage != new.stage:
        raise UsageError(f"a {old.stage} shader can't be compared with a {new.stage} shader")
    mine, theirs = inputs_of(old), inputs_of(new)
    inputs = {**mine, **theirs}
    for name in unknown_names(list(plan.ranges), inputs):
        raise UsageError(f"no shader reads {name!r}", remedy=nearest(name, inputs))
    for name in mine.keys() & theirs.keys():
        if mine[name].type != theirs[name].type:
            raise UsageError(
                f"{name} is {mine[name].type} in one, {theirs[name].type} in the other"
            )
    if captured:
        captured = merged(captured, old, plan.count)
        roles = learned(captured)

        def make(roles: Mapping[str, Role], seed: int) -> Given:
            return varied(captured[seed % len(captured)], roles, seed)
    else:
        declared = {**declared_ranges(old), **declared_ranges(new)}
        roles = roles_of(inputs.values(), declared, plan.ranges)

        def make(roles: Mapping[str, Role], seed: int) -> Given:
            return drawn(inputs, roles, plan.count, seed)

    comparison = _Comparison((old, new), inputs, roles, make, plan)
    return Answer(
        old=_file(old),
        new=_file(new),
        outputs=tuple(comparison.outputs(captured)),
        notes=tuple(_notes(mine, theirs)),
        inputs={name: f"{role} ({role.source})" for name, role in roles.items() if name in inputs},
    )


def _notes(mine: Mapping[str, Input], theirs: Mapping[str, Input]) -> Iterator[str]:
    for which, some, others in (("OLD", mine, theirs), ("NEW", theirs, mine)):
        only = [name for name in some if name not in others]
        if only:
            yield f"only {which} reads {', '.join(only)}"


def _file(program: Program) -> str:
    return "" if program.source is None else program.source.path


class _Comparison:
    """Two programs, and where their inputs come from."""

    def __init__(
        self,
        programs: tuple[Program, Program],
        inputs: Mapping[str, Input],
        roles: Mapping[str, Role],
        make: Callable[[Mapping[str, Role], int], Given],
        plan: Plan,
    ) -> None:
        self.programs = programs
        self.inputs = inputs
        self.roles = roles
        self.make = make
        self.rounds = plan.rounds
        self.accuracy = plan.accuracy
        self._in_bands: tuple[Mapping[str, Any] | None, ...] = ()

    def outputs(self, captured: Sequence[Given]) -> Iterator[OutputAnswer]:
        """An answer for each output, on captured inputs and on rounds of others."""
        sets = [self._run(given) for given in captured]
        sets += [self._run(self.make(self.roles, seed)) for seed in range(self.rounds)]
        around = jumps(self.programs, sets[-1][0], self.roles) if self.rounds else None
        if around is not None:
            sets.append(self._run(around))
        for name, other in self._names(sets):
            if not name or not other:
                yield OutputAnswer(name=name or other, why="missing")
                continue
            found = [_Found(g, self._compared(g, a, b, name, other), a, b) for g, a, b in sets]
            answer = self._answer(found, name, other)
            if answer.same and self.accuracy:
                answer = replace(answer, numerics=self._numerics(sets[0], name, other))
            if answer.same and self.rounds:
                answer = replace(answer, conditions=tuple(self._conditions(name, other)))
            yield answer

    def _run(self, given: Given) -> tuple[Given, Ran, Ran]:
        return given, run(self.programs[0], given), run(self.programs[1], given)

    def _compared(self, given: Given, old: Ran, new: Ran, name: str, other: str) -> Compared:
        first = compare(old, new, name, other)
        return confirmed(self.programs, given, first, (name, other))

    def _names(self, sets: Sequence[tuple[Given, Ran, Ran]]) -> list[tuple[str, str]]:
        """The outputs' names in pairs: of the same name, or the only ones that are left over."""
        mine = list(dict.fromkeys(n for _, ran, _ in sets for n in ran.outputs))
        theirs = list(dict.fromkeys(n for _, _, ran in sets for n in ran.outputs))
        pairs = [(n, n) for n in mine if n in theirs]
        only, others = [n for n in mine if n not in theirs], [n for n in theirs if n not in mine]
        if len(only) == len(others) == 1:
            return [*pairs, (only[0], others[0])]
        return [*pairs, *((n, "") for n in only), *(("", n) for n in others)]

    def _answer(self, found: Sequence[_Found], name: str, other: str) -> OutputAnswer:
        called = name if name == other else f"{name} → {other}"
        judged = sum(int(one.compared.judged.sum()) for one in found)
        different = sum(int(one.compared.different.sum()) for one in found)
        if not different:
            return OutputAnswer(name=called, judged=judged)
        one = next(one for one in found if one.compared.different.any())
        row = _worst(one)
        far = [f.compared.apart[f.compared.different] for f in found if f.compared.different.any()]
        apart = np.concatenate(far)
        finite = apart[np.isfinite(apart)]
        return OutputAnswer(
            name=called,
            judged=judged,
            different=different,
            apart=float(finite.max()) if finite.size else float("inf"),
            why="value" if finite.size else one.compared.why,
            example=example(one.given, row, self.inputs),
            gives=(_value(one.old, name, row), _value(one.new, other, row)),
            place=self._place(one, row),
        )

    def _place(self, one: _Found, row: int) -> str:
        """The first line that stores another value at an invocation; where only one program
        discards, the line where it does."""
        old, new = (steps(program, one.given, row, Noisy()) for program in self.programs)
        found = first(old, new, _apart)
        if found is not None:
            return _written(self.programs[1], found.line)
        for program, ran, taken in zip(self.programs, (one.old, one.new), (old, new), strict=True):
            if ran.discarded[0, row]:
                last = taken[-1].line if taken else 0
                lines = discards(program)
                return _written(program, next((n for n in lines if n >= last), lines[-1]))
        return ""

    def _numerics(self, one: tuple[Given, Ran, Ran], name: str, other: str) -> Numerics | None:
        """How the accuracy changes, on some of the first inputs."""
        some, ran = one[0].part(np.arange(min(one[0].count, MOST))), one[1]
        old, new = self._bands(some)
        if old is None or new is None or name not in old or other not in new:
            return None
        values = ran.outputs[name][0, : some.count]
        found = accuracy(self.programs, some, (old[name], new[other]), values)
        if found is None:
            return None
        return Numerics(
            worse=found.worse,
            better=found.better,
            near=example(some, found.row, self.inputs),
            place="" if found.step is None else _written(self.programs[1], found.step.line),
        )

    def _bands(self, given: Given) -> tuple[Mapping[str, Any] | None, ...]:
        if not self._in_bands:
            self._in_bands = tuple(bands_of(program, given) for program in self.programs)
        return self._in_bands

    def _conditions(self, name: str, other: str) -> Iterator[str]:
        """What an output is the same under: assumptions about inputs without which it is not."""
        freed = {n: free for n, role in self.roles.items() if (free := role.freed) is not None}
        seed = self.rounds
        if not freed or not self._differs({**self.roles, **freed}, seed, name, other):
            return
        for input_, role in freed.items():
            if self._differs({**self.roles, input_: role}, seed, name, other):
                yield self.roles[input_].condition(input_)

    def _differs(self, roles: Mapping[str, Role], seed: int, name: str, other: str) -> bool:
        given, old, new = self._run(self.make(roles, seed))
        return bool(self._compared(given, old, new, name, other).different.any())


def _written(program: Program, line: int) -> str:
    file, number = program.place(line)
    return f"{display_path(file)}:{number}" if file else f"line {number}"


def _worst(found: _Found) -> int:
    """The invocation to show: of those that differ, the one where both are farthest apart."""
    apart = np.where(found.compared.different, found.compared.apart, -1.0)
    finite = np.where(np.isfinite(apart), apart, -1.0)
    return int(finite.argmax() if finite.max() >= 0.0 else apart.argmax())


def example(given: Given, row: int, inputs: Mapping[str, Input]) -> dict[str, tuple[float, ...]]:
    """The inputs of one invocation, by name."""
    found = {}
    for name in inputs:
        values = given.each.get(name)
        if values is not None:
            one = values[row if len(values) > 1 else 0]
        elif name in given.bindings.uniforms:
            one = np.asarray(given.bindings.uniforms[name])
        else:
            continue
        found[name] = tuple(float(v) for v in np.ravel(one))
    return found


def _value(ran: Ran, name: str, row: int) -> tuple[float, ...]:
    if ran.discarded[0, row]:
        return ()
    return tuple(float(v) for v in ran.outputs[name][0, row])


def _apart(a: object, b: object) -> bool:
    """Whether two stored values are other ones, as far as a reader would say so."""
    x, y = (np.asarray(getattr(v, "lo", getattr(v, "all_true", v)), np.float64) for v in (a, b))
    if x.shape[1:] != y.shape[1:]:
        return True
    with np.errstate(all="ignore"):
        near = np.abs(x - y) <= _ENDS * np.maximum(np.abs(x), np.abs(y)) + 1e-12
    return not bool((near | (np.isnan(x) & np.isnan(y)) | (x == y)).all())
