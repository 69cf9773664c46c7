"""Audit a program: what may go wrong in it, on the inputs that it may get.

    audit = audit_program(load(source), Plan(ranges={"distance": "0..50"}))
    audit.clean                                             # no hazard was shown
    print(*audit.lines(), sep="; ")

A hazard is shown by an invocation: in float32 an instruction's operands are ones for which GLSL
defines no result there, and an output depends on what the instruction gives.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from shaderlab.errors import UsageError, nearest

from .batches import InputBatch, merge_batches
from .checks import INDEX, OVERFLOW
from .hazards import Audit as Audit, Hazard as Hazard, find_dependents, reached_by_0
from .inputs import Input, declared_ranges, domains_of, inputs_of, unknown_names
from .interpreter import Program
from .interpreter.values import NUMBERS
from .portability import Spread, find_spreads, widest_spreads
from .search import EQUAL, RANDOM, Counterexample, InputSearch, find_counterexamples, watch_batch
from .undefined import between_invocations, divergent, undefined_values

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
    for name in unknown_names(list(plan.ranges), inputs):
        raise UsageError(f"the shader does not read {name!r}", remedy=nearest(name, inputs))
    if captured:
        batches = merge_batches(captured, program, _MAX_CAPTURED)
        examples = [e for batch in batches for e in _captured_examples(program, batch)]
        tried = sum(batch.count for batch in batches)
        words = dict.fromkeys(inputs, "as the case gives it")
    else:
        if program.workgroup_size > 1:
            inputs = _of_workgroups(inputs)
        domains = domains_of(inputs.values(), declared_ranges(program), plan.ranges)
        search = InputSearch(program, inputs, domains, plan.count)
        search.run()
        examples, tried, batches = list(search.found.values()), search.tried, [search.first]
        words = {name: f"{domain} ({domain.source})" for name, domain in domains.items()}
    hazards = [hazard for e in examples for hazard in _hazards(program, e, inputs)]
    spreads: list[Spread] = []
    for batch in batches:
        hazards += undefined_values(program, batch, inputs)
        hazards += divergent(program, batch, inputs, made_up=not captured)
        hazards += between_invocations(program, batch, inputs)
        if plan.precision:
            spreads += find_spreads(program, batch, inputs)
    return Audit(
        file="" if program.source is None else program.source.path,
        hazards=tuple(_distinct(hazards)),
        tried=tried,
        inputs=words,
        spreads=tuple(widest_spreads(spreads)),
    )


def _captured_examples(program: Program, batch: InputBatch) -> Iterator[Counterexample]:
    origins = np.full(batch.count, RANDOM)
    return find_counterexamples(watch_batch(program, batch), batch, origins)


def _of_workgroups(inputs: Mapping[str, Input]) -> dict[str, Input]:
    """The inputs of whole workgroups: the group's own number in place of its invocations'."""
    found = {name: one for name, one in inputs.items() if name not in NUMBERS}
    numbers = [inputs[name] for name in NUMBERS if name in inputs]
    if numbers:
        name = NUMBERS[0]
        found[name] = Input(name, "uvec3", uniform=False, workgroup=numbers[0].workgroup)
    return found


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
    words = one.check.words(*example.operands)
    if example.crossing:
        words = f"{words}, nearly: the divisor passes through 0 here"
    if one.check.possible:
        words += f"; {one.check.possible}"
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
            evident=example.origin == RANDOM and not one.check.possible,
            inputs=example.batch.example(example.row, inputs),
            outputs=values if program.workgroup_size == 1 else {},
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
