"""A program audited: what may go wrong in it, on the inputs that it may get."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from shaderlab.errors import UsageError, nearest

from .batches import InputBatch, merge_batches
from .checks import INDEX, OVERFLOW
from .hazards import Audit as Audit, Hazard as Hazard, find_dependents, reached_by_0
from .inputs import Input, InputDomain, declared_ranges, domains_of, inputs_of, unknown_names
from .interpreter import Program
from .interpreter.values import NUMBERS
from .portability import find_spreads, widest_spreads
from .search import DRAWN, EQUAL, Counterexample, InputSearch, counterexamples_of, watch_batch
from .undefined import between_invocations, divergent, undefined_values

_MOST = 16_384  # invocations that a case's draws give, of those with the same textures


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How a program is audited.

    Attributes:
        ranges: "a..b", "a:b" or "unit" for inputs, by name.
        count: invocations that are drawn at random.
        precision: whether it is asked how far devices may differ, at highp and at mediump.
    """

    ranges: Mapping[str, str] = field(default_factory=dict)
    count: int = 4096
    precision: bool = False


def audit_program(
    program: Program, plan: Plan | None = None, captured: Sequence[InputBatch] = ()
) -> Audit:
    """What may go wrong in a program.

    Args:
        program: one stage.
        plan: how it is audited.
        captured: what a scene's draws give it. Without any, inputs are made up and searched.

    Raises:
        NotInterpretedError: it does what the interpreter does not know, or does not end.
        FormulaError: it reads what is not given.
        UsageError: a range is wrong.
    """
    plan = plan or Plan()
    inputs = inputs_of(program)
    for name in unknown_names(list(plan.ranges), inputs):
        raise UsageError(f"the shader does not read {name!r}", remedy=nearest(name, inputs))
    if captured:
        captured = merge_batches(captured, program, _MOST)
        examples = [
            example
            for batch in captured
            for example in counterexamples_of(
                watch_batch(program, batch), batch, np.full(batch.count, DRAWN)
            )
        ]
        tried, domains = sum(batch.count for batch in captured), {}
        sets = list(captured)
    else:
        if program.workgroup_size > 1:
            inputs = _of_workgroups(inputs)
        domains = domains_of(inputs.values(), declared_ranges(program), plan.ranges)
        search = InputSearch(program, inputs, domains, plan.count)
        search.run()
        examples, tried = list(search.examples.values()), search.tried
        sets = [search.sample_inputs]
    hazards = [f for w in examples for f in _hazards(program, w, inputs)]
    for batch in sets:
        hazards += undefined_values(program, batch, inputs)
        hazards += divergent(program, batch, inputs, made_up=not captured)
        hazards += between_invocations(program, batch, inputs)
    spreads = (
        [s for batch in sets for s in find_spreads(program, batch, inputs)]
        if plan.precision
        else []
    )
    return Audit(
        file="" if program.source is None else program.source.path,
        hazards=tuple(_distinct(hazards)),
        tried=tried,
        inputs=_in_words(domains, inputs, captured),
        spreads=tuple(widest_spreads(spreads)),
    )


def _of_workgroups(inputs: Mapping[str, Input]) -> dict[str, Input]:
    """The inputs of whole workgroups: the group's own number in place of its invocations'."""
    found = {name: one for name, one in inputs.items() if name not in NUMBERS}
    numbers = [inputs[name] for name in NUMBERS if name in inputs]
    if numbers:
        name = NUMBERS[0]
        found[name] = Input(name, "uvec3", uniform=False, workgroup=numbers[0].workgroup)
    return found


def _in_words(
    domains: Mapping[str, InputDomain], inputs: Mapping[str, Input], captured: Sequence[InputBatch]
) -> dict[str, str]:
    if captured:
        return dict.fromkeys(inputs, "as the case gives it")
    return {name: f"{domain} ({domain.source})" for name, domain in domains.items()}


def _hazards(
    program: Program, example: Counterexample, inputs: Mapping[str, Input]
) -> Sequence[Hazard]:
    """The hazard about an instruction; none where no output depends on what it gives."""
    place, one = example.place, example.watched
    outputs = find_dependents(program, example.batch, example.row, place)
    if not outputs and place.kind != INDEX.kind:
        return ()
    if example.crossing and not reached_by_0(
        program, example.batch, example.row, place, example.operands[-1]
    ):
        return ()
    file, line = program.place(one.at.line)
    words = one.check.words(*example.operands)
    if example.crossing:
        words = f"{words}, nearly: the divisor passes through 0 here"
    if one.check.possible:
        words += f"; {one.check.possible}"
    if example.origin != DRAWN:
        words += (
            "; only if two inputs are equal"
            if example.origin == EQUAL
            else "; only if an input is 0"
        )
    return (
        Hazard(
            file=file,
            line=line,
            kind=place.kind,
            message=f"{place.kind}: {words}" if not words.startswith(place.kind) else words,
            evident=example.origin == DRAWN and not one.check.possible,
            inputs=example.batch.example(example.row, inputs),
            outputs={}
            if program.workgroup_size > 1
            else {name: tuple(map(float, value)) for name, value in outputs.items()},
            calls=tuple(program.place(call)[1] for call in place.calls),
        ),
    )


def _distinct(hazards: Sequence[Hazard]) -> list[Hazard]:
    """One of each line and kind, evident ones before others; by line."""
    found: dict[tuple[str, int, str], Hazard] = {}
    for hazard in sorted(hazards, key=lambda f: not f.evident):
        found.setdefault((hazard.file, hazard.line, hazard.kind), hazard)
    explained = {(file, line) for file, line, kind in found if kind != OVERFLOW.kind}
    for key in [key for key in found if key[2] == OVERFLOW.kind and key[:2] in explained]:
        del found[key]
    return sorted(found.values(), key=lambda f: (f.file, f.line, f.kind))
