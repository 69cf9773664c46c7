"""A program audited: what may go wrong in it, on the inputs that it may get."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from shaderlab.errors import UsageError, nearest

from ..equivalence.comparison import example
from ..inputs import Given, Input, Role, declared_ranges, inputs_of, merged, roles_of, unknown_names
from ..interpreter import Program
from ..interpreter.values import NUMBERS
from .consequences import depending, reached_by_0
from .hazard import Audit, Hazard
from .mediump import mediump
from .portability import Spread, portability, sample
from .searching import DRAWN, EQUAL, Hunt, Witness, watched, witnesses_of
from .undefined import between_invocations, divergent, undefined_values
from .watching import INDEX, OVERFLOW

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
    program: Program, plan: Plan | None = None, captured: Sequence[Given] = ()
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
        captured = merged(captured, program, _MOST)
        witnesses = [
            witness
            for given in captured
            for witness in witnesses_of(watched(program, given), given, np.full(given.count, DRAWN))
        ]
        tried, roles = sum(given.count for given in captured), {}
        sets = list(captured)
    else:
        if program.workgroup_size > 1:
            inputs = _of_workgroups(inputs)
        roles = roles_of(inputs.values(), declared_ranges(program), plan.ranges)
        hunt = Hunt(program, inputs, roles, plan.count)
        hunt.run()
        witnesses, tried = list(hunt.witnesses.values()), hunt.tried
        sets = [hunt.drawn]
    hazards = [f for w in witnesses for f in _hazards(program, w, inputs)]
    for given in sets:
        hazards += undefined_values(program, given, inputs)
        hazards += divergent(program, given, inputs, made_up=not captured)
        hazards += between_invocations(program, given, inputs)
    spreads = (
        [s for given in sets for s in spread(program, given, inputs)] if plan.precision else []
    )
    return Audit(
        file="" if program.source is None else program.source.path,
        hazards=tuple(_distinct(hazards)),
        tried=tried,
        inputs=_in_words(roles, inputs, captured),
        spreads=tuple(widest(spreads)),
    )


def _of_workgroups(inputs: Mapping[str, Input]) -> dict[str, Input]:
    """The inputs of whole workgroups: the group's own number in place of its invocations'."""
    found = {name: one for name, one in inputs.items() if name not in NUMBERS}
    numbers = [inputs[name] for name in NUMBERS if name in inputs]
    if numbers:
        name = NUMBERS[0]
        found[name] = Input(name, "uvec3", uniform=False, workgroup=numbers[0].workgroup)
    return found


def spread(
    program: Program,
    given: Given,
    inputs: Mapping[str, Input],
    precisions: Sequence[str] = ("highp", "mediump"),
) -> list[Spread]:
    """How far devices may differ at each float output, on some of the invocations."""
    if program.stage not in ("vertex", "fragment"):
        return []
    some = sample(given)
    found = portability(program, some, inputs) if "highp" in precisions else []
    if "mediump" in precisions and program.stage == "fragment":
        found += mediump(program, some, inputs)
    return found


def widest(spreads: Sequence[Spread]) -> list[Spread]:
    """The widest of each output and precision."""
    found: dict[tuple[str, str], Spread] = {}
    for one in spreads:
        known = found.setdefault((one.output, one.precision), one)
        if (one.codes, one.ulp) > (known.codes, known.ulp):
            found[one.output, one.precision] = one
    return list(found.values())


def _in_words(
    roles: Mapping[str, Role], inputs: Mapping[str, Input], captured: Sequence[Given]
) -> dict[str, str]:
    if captured:
        return dict.fromkeys(inputs, "as the case gives it")
    return {name: f"{role} ({role.source})" for name, role in roles.items()}


def _hazards(program: Program, witness: Witness, inputs: Mapping[str, Input]) -> Sequence[Hazard]:
    """The hazard about an instruction; none where no output depends on what it gives."""
    place, one = witness.place, witness.watched
    outputs = depending(program, witness.given, witness.row, place)
    if not outputs and place.kind != INDEX.kind:
        return ()
    if witness.crossing and not reached_by_0(
        program, witness.given, witness.row, place, witness.operands[-1]
    ):
        return ()
    file, line = program.place(one.at.line)
    words = one.check.words(*witness.operands)
    if witness.crossing:
        words = f"{words}, nearly: the divisor passes through 0 here"
    if one.check.possible:
        words += f"; {one.check.possible}"
    if witness.origin != DRAWN:
        words += (
            "; only if two inputs are equal"
            if witness.origin == EQUAL
            else "; only if an input is 0"
        )
    return (
        Hazard(
            file=file,
            line=line,
            kind=place.kind,
            message=f"{place.kind}: {words}" if not words.startswith(place.kind) else words,
            evident=witness.origin == DRAWN and not one.check.possible,
            inputs=example(witness.given, witness.row, inputs),
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
