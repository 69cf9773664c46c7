"""Checking a function: against a reference's bands, or against a law."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from shaderlab.engine.judging.banded import judge_band
from shaderlab.engine.judging.inputs import Inputs
from shaderlab.engine.judging.laws import Finding, Law
from shaderlab.errors import CallError
from shaderlab.functions.binding import Call
from shaderlab.functions.laws import CallLaw, judge_law
from shaderlab.functions.parts import Part, Reference, parts
from shaderlab.functions.reference_inputs import leaves, reference_inputs
from shaderlab.model.frame import Array
from shaderlab.model.records import Outcome, SourceText
from shaderlab.report.plain_text import numbers, outcome_details

if TYPE_CHECKING:
    from shaderlab.functions.function import Function


def judged(function: Function, law: Law | CallLaw | Reference, call: Call) -> list[Outcome]:
    """The outcomes of a check: one, or with a reference one for each part of the result.

    Args:
        function: what is checked.
        law: a law, or a reference: a formula written with `shaderlab.glslmath`.
        call: the arguments.

    Raises:
        CallError: the reference's parameters are not the function's.
        FormulaError: the reference fails.
    """
    outputs = call.signature.outputs
    if not outputs:
        raise CallError(f"{function.__name__} gives nothing", remedy="check what it should write")
    got = function.evaluate(call)
    found = parts(outputs, got)
    kept: Array = np.ones(call.batch, np.bool_)
    if isinstance(found[0].values, np.ma.MaskedArray):
        mask = np.ma.getmaskarray(found[0].values)
        kept = np.asarray(~mask.all(axis=tuple(range(len(call.batch), mask.ndim))))
    if not isinstance(law, Law | CallLaw):
        inputs = reference_inputs(law, call, kept.reshape(-1), function.folder)
        return [_of_reference(function, law, call, part, inputs, kept) for part in found]
    if not isinstance(got, np.ndarray | np.generic):
        names = ", ".join(part.name for part in found)
        raise CallError(
            f"{law.title} is a law of one value; {function.__name__} gives {names}",
            remedy="check a reference that gives them all, or call it, and compare what it gives",
        )
    return [_of_law(function, law, call, found[0], kept)]


def text_of(call: Call, outcomes: Sequence[Outcome]) -> str:
    """Why a check failed, for people."""
    lines = [str(call.signature)]
    for outcome in outcomes:
        if outcome.status != "pass":
            lines += [f"{outcome.name}:"] * (len(outcomes) > 1) + [*outcome_details(outcome)]
    return "\n".join(lines)


def source_of_glsl(function: Function, call: Call) -> SourceText:
    """The function's definition."""
    file, line = function.place_of(call.signature)
    return SourceText(file=file, line=line, language="glsl", text=call.signature.definition)


def _of_reference(
    function: Function,
    reference: Reference,
    call: Call,
    part: Part,
    inputs: Inputs,
    kept: Array,
) -> Outcome:
    measured = part.rows(kept)
    banded = judge_band(measured, part.of(reference), inputs, rules=None)
    status, message = banded.verdict()
    return Outcome(
        name=part.named(function.__name__),
        kind="formula",
        status=status,  # type: ignore[arg-type]
        message=message,
        judged=int(measured.size),
        outside=banded.outside,
        worst=banded.worst(),
        vacuous=banded.vacuous_share,
        undecided=banded.undecided_share,
        informative=banded.informative_share,
        sources=(source_of_glsl(function, call), banded.source),
    )


def _of_law(function: Function, law: Law | CallLaw, call: Call, part: Part, kept: Array) -> Outcome:
    got = part.values.data if isinstance(part.values, np.ma.MaskedArray) else part.values
    finding = judge_law(law, function, call, got)
    holds = finding.holds.all(axis=tuple(range(len(call.batch), finding.holds.ndim)))
    wrong = np.flatnonzero(~holds & kept)
    name = law.title
    judged = int(np.count_nonzero(kept))
    message = ""
    if wrong.size:
        message = f"{name} does not hold of {wrong.size} of {judged} elements\n"
        message += "\n".join(_shown(call, finding, int(wrong[0])))
    elif not judged:
        message = "nothing was judged: there is no element, or all are discarded"
    elif finding.trivial:
        message = f"{name} could hardly fail: {finding.trivial}"
    return Outcome(
        name=function.__name__,
        kind=name,
        status="fail" if message else "pass",
        message=message,
        judged=judged,
        outside=int(wrong.size),
        sources=(source_of_glsl(function, call),),
    )


def _shown(call: Call, finding: Finding, index: int) -> Iterator[str]:
    """One element: what it got, what was expected, its inputs, and a line that calls it again."""
    count = math.prod(call.batch)
    rows = finding.values.reshape(count, -1)[index]
    yield f"  got        {numbers(rows)}"
    if finding.expected:
        yield f"  expected   {finding.expected}"
    else:
        other = finding.reference.reshape(count, -1)[index]
        yield f"  expected   {numbers(other)}"
        with np.errstate(all="ignore"):
            apart = np.abs(rows.astype(np.float64) - other) / np.spacing(np.abs(np.float32(other)))
        yield f"  apart      {np.max(apart):.3g} ulp"
    for name, values in inputs_at(call, index).items():
        yield f"  {name} = {numbers(values)}"


def inputs_at(call: Call, index: int) -> dict[str, tuple[float, ...]]:
    """The numbers that an element of a call got, by name."""
    found = {}
    for name, leaf in leaves(call):
        rows = np.broadcast_to(leaf, (*call.batch, leaf.shape[-1])).reshape(-1, leaf.shape[-1])
        values = rows[index]
        found[name] = tuple(float(np.float32(v)) if values.dtype.kind == "f" else v for v in values)
    return found
