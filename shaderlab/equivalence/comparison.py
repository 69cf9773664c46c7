"""Two programs compared on rounds of inputs: the same mathematics, or from where on not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from shaderlab.equivalence.answer import Answer, OutputAnswer
from shaderlab.equivalence.comparing import Compared, Ran, compare, run
from shaderlab.equivalence.drawing import Given, drawn
from shaderlab.equivalence.interface import Input, declared_ranges, inputs_of
from shaderlab.equivalence.jumps import jumps
from shaderlab.equivalence.locating import discards, first, steps
from shaderlab.equivalence.noise import Noisy
from shaderlab.equivalence.roles import Role, roles_of, unknown_names
from shaderlab.errors import UsageError, nearest
from shaderlab.files import display_path
from shaderlab.interpreter import Program

_ENDS = 1e-6  # what stored values may differ by where a step is called the same


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How two programs are compared.

    Attributes:
        ranges: "a..b", "a:b" or "unit" for inputs, by name.
        rounds: how many sets of random inputs.
        count: invocations in each.
    """

    ranges: Mapping[str, str] = field(default_factory=dict)
    rounds: int = 5
    count: int = 4096


@dataclass(frozen=True, eq=False)
class _Found:
    """A comparison of one output on one set of inputs."""

    given: Given
    compared: Compared
    old: Ran
    new: Ran


def compare_programs(old: Program, new: Program, plan: Plan | None = None) -> Answer:
    """Whether two programs of one stage compute the same.

    Raises:
        NotInterpretedError: one does what the interpreter does not know, or does not end.
        FormulaError: one reads what can't be made up.
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
    declared = {**declared_ranges(old), **declared_ranges(new)}
    roles = roles_of(inputs.values(), declared, plan.ranges)
    comparison = _Comparison((old, new), inputs, roles, plan)
    return Answer(
        old=_file(old),
        new=_file(new),
        outputs=tuple(comparison.outputs()),
        notes=tuple(_notes(mine, theirs)),
        inputs={name: f"{role} ({role.source})" for name, role in roles.items()},
    )


def _notes(mine: Mapping[str, Input], theirs: Mapping[str, Input]) -> Iterator[str]:
    for which, some, others in (("OLD", mine, theirs), ("NEW", theirs, mine)):
        only = [name for name in some if name not in others]
        if only:
            yield f"only {which} reads {', '.join(only)}"


def _file(program: Program) -> str:
    return "" if program.source is None else program.source.path


class _Comparison:
    """Two programs, and what is made up for them."""

    def __init__(
        self,
        programs: tuple[Program, Program],
        inputs: Mapping[str, Input],
        roles: Mapping[str, Role],
        plan: Plan,
    ) -> None:
        self.programs = programs
        self.inputs = inputs
        self.roles = roles
        self.plan = plan

    def outputs(self) -> Iterator[OutputAnswer]:
        """An answer for each output."""
        sets: list[tuple[Given, Ran, Ran]] = []
        for seed in range(self.plan.rounds):
            given = self._drawn(self.roles, seed)
            sets.append(self._run(given))
        around = jumps(self.programs, sets[0][0], self.inputs, self.roles)
        if around is not None:
            sets.append(self._run(around))
        for name, other in self._names(sets):
            if not name or not other:
                yield OutputAnswer(name=name or other, why="missing")
                continue
            found = [_Found(g, compare(a, b, name, other), a, b) for g, a, b in sets]
            answer = self._answer(found, name, other)
            if answer.same:
                answer = replace(answer, conditions=tuple(self._conditions(name, other)))
            yield answer

    def _drawn(self, roles: Mapping[str, Role], seed: int) -> Given:
        return drawn(self.inputs, roles, self.plan.count, seed)

    def _run(self, given: Given) -> tuple[Given, Ran, Ran]:
        return given, run(self.programs[0], given), run(self.programs[1], given)

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

    def _conditions(self, name: str, other: str) -> Iterator[str]:
        """What an output is the same under: assumptions about inputs without which it is not."""
        freed = {n: free for n, role in self.roles.items() if (free := role.freed) is not None}
        seed = self.plan.rounds
        if not freed or not self._differs({**self.roles, **freed}, seed, name, other):
            return
        for input_, role in freed.items():
            if self._differs({**self.roles, input_: role}, seed, name, other):
                yield self.roles[input_].condition(input_)

    def _differs(self, roles: Mapping[str, Role], seed: int, name: str, other: str) -> bool:
        _, old, new = self._run(self._drawn(roles, seed))
        return bool(compare(old, new, name, other).different.any())


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
