"""Frame and expectation in, judgement out: finds what an expectation is about, and judges it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from shaderlab.checks import plain as exactly
from shaderlab.checks.banded import Banded, judge_band, second_opinions
from shaderlab.checks.counts import judge_cost, judge_query
from shaderlab.checks.figures import figure_row, rounds_to
from shaderlab.checks.inputs import Inputs, evaluate
from shaderlab.checks.judgement import Judgement, Lazy, shown
from shaderlab.checks.layouts import judge_attributes, judge_block
from shaderlab.checks.measured import judge_measure
from shaderlab.checks.naming import (
    draw_key,
    find_image,
    inputs_of,
    pixel_inputs,
    reference_for,
    split_output,
    subject_of,
)
from shaderlab.checks.properties import judge_property
from shaderlab.checks.refusals import (
    Answer,
    Complaint,
    judge_compile_fails,
    judge_inactive,
    judge_refused,
)
from shaderlab.errors import CaseError
from shaderlab.frame import Array, Frame, Image
from shaderlab.model import (
    AttributeLayout,
    BlockLayout,
    CompileFails,
    Computed,
    Cost,
    Coverage,
    Exact,
    Expectation,
    Formula,
    GlCall,
    GlError,
    InactiveUniforms,
    Measure,
    Output,
    Pixel,
    Property,
    Query,
    Refused,
    Scene,
    Sweep,
    Value,
)
from shaderlab.records import Curve, Outcome

Refusals = Mapping[int, Answer | Complaint]


def judge(index: int, scene: Scene, frame: Frame, refusals: Refusals) -> Judgement:
    """Judge expectation `index` of the scene.

    Args:
        index: its place in `scene.expect`.
        scene: what was run.
        frame: what it gave.
        refusals: what was said of that which must be refused, by the expectation's place.

    Raises:
        CaseError, FormulaError: the expectation asks for what is not there.
    """
    expectation: Expectation = scene.expect[index]
    match expectation:
        case Formula():
            return _formula(expectation, scene, frame)
        case Property():
            _, name = split_output(expectation.output, scene)
            return judge_property(expectation, frame.probes[index], name)
        case Sweep():
            return _sweep(expectation, index, scene, frame)
        case Value():
            return _value(expectation, index, scene, frame)
        case Measure():
            return judge_measure(expectation, scene, frame)
        case Exact():
            image = find_image(expectation.output, scene, frame)
            expected = expectation.equals
            if isinstance(expected, Output):
                expected = find_image(f"{expected.pass_name}.{expected.name}", scene, frame).values
            return exactly.judge_exact(expectation, image, expected)
        case Coverage():
            key = draw_key(scene, expectation.pass_name, expectation.draw)
            return exactly.judge_coverage(expectation, frame.fragments[key].covered)
        case Computed():
            return exactly.judge_computed(expectation)
        case CompileFails():
            answer = refusals[index]
            assert isinstance(answer, Answer)
            return judge_compile_fails(expectation, answer)
        case Refused():
            complaint = refusals[index]
            assert isinstance(complaint, Complaint)
            return judge_refused(expectation, complaint)
        case InactiveUniforms():
            key = draw_key(scene, expectation.pass_name, expectation.draw)
            return judge_inactive(expectation, frame.locations[key])
        case GlError():
            key = draw_key(scene, expectation.pass_name, expectation.draw)
            return exactly.judge_gl_error(expectation, frame.gl_errors.get(key, ()))
        case GlCall():
            return exactly.judge_gl_call(expectation, frame.replies[index])
        case Query():
            key = draw_key(scene, expectation.pass_name, expectation.draw)
            return judge_query(expectation, frame.queries[*key, expectation.counter])
        case Cost():
            return judge_cost(expectation, frame.timings)
        case AttributeLayout():
            key = draw_key(scene, expectation.pass_name, expectation.draw)
            return judge_attributes(expectation, frame.attributes[key])
        case BlockLayout():
            key = draw_key(scene, expectation.pass_name, expectation.draw)
            return judge_block(expectation, frame.blocks[key])


def _formula(expectation: Formula, scene: Scene, frame: Frame) -> Judgement:
    subject = subject_of(expectation, scene, frame)
    banded = judge_band(
        subject.measured,
        expectation.reference,
        subject.inputs,
        rules=expectation.rules,
        format=subject.format,
    )
    covered, image = subject.covered, subject.image
    rows = second_opinions(banded, expectation.also)
    status, message = banded.verdict()
    if status == "pass" and not all(row.ok for row in rows):
        status, message = "fail", "an independent implementation leaves the band"
    pictures: Mapping[str, Array] = {}
    if image is not None and covered is not None:
        pictures = Lazy(lambda: _pictures(image, covered, banded))
    return Judgement(
        outcome=_outcome(expectation.name, "formula", status, message, banded, rows, covered),
        pictures=pictures,
    )


def _sweep(expectation: Sweep, index: int, scene: Scene, frame: Frame) -> Judgement:
    banded, _ = _probe(expectation, expectation.reference, index, scene, frame)
    status, message = banded.verdict()
    c = int(np.argmax(np.ptp(banded.reference, axis=0)))
    curve = Curve(
        title=expectation.name,
        x_label=expectation.over,
        y_label=expectation.output if banded.measured.shape[1] == 1
        else f"{expectation.output}.{'xyzw'[c]}",
        x=expectation.values,
        measured=tuple(banded.measured[:, c].tolist()),
        reference=tuple(banded.reference[:, c].tolist()),
        low=tuple(banded.low[:, c].tolist()),
        high=tuple(banded.high[:, c].tolist()),
        log_x=expectation.log_x,
    )  # fmt: skip
    return Judgement(
        outcome=_outcome(expectation.name, "sweep", status, message, banded, []), curve=curve
    )


def _value(expectation: Value, index: int, scene: Scene, frame: Frame) -> Judgement:
    reference = reference_for(expectation, scene)
    if reference is None:
        return _measured_figure(expectation, index, scene, frame)
    banded, inputs = _probe(expectation, reference, index, scene, frame)
    computed = evaluate(reference, inputs, rules=None, decimal=True)
    agrees = rounds_to(computed, expectation.equals, expectation.digits)
    status, message = banded.verdict()
    if not agrees:
        status = "fail"
        message = f"the reference gives {shown(computed, expectation.digits + 3)}"
    row = figure_row(
        _label(expectation),
        expectation.equals,
        expectation.digits,
        computed,
        banded.measured[0],
        status == "pass",
        expectation.note,
    )
    outcome = _outcome(expectation.name, "value", status, message, banded, [row])
    return Judgement(outcome=replace(outcome, rows_show_worst=True))


def _measured_figure(expectation: Value, index: int, scene: Scene, frame: Frame) -> Judgement:
    """A figure without a reference: the measured value itself must round to it."""
    _, name = split_output(expectation.output, scene)
    if isinstance(expectation.at, Pixel):
        image = find_image(expectation.output, scene, frame)
        measured = _pixel(image, expectation.at)
    else:
        measured = frame.probes[index].outputs[name][0]
    ok = rounds_to(measured, expectation.equals, expectation.digits)
    row = figure_row(
        _label(expectation), expectation.equals, expectation.digits, measured, measured, ok,
        expectation.note,
    )  # fmt: skip
    return Judgement(
        outcome=Outcome(
            name=expectation.name,
            kind="value",
            status="pass" if ok else "fail",
            message="" if ok else f"measured {shown(measured)}",
            judged=int(np.size(measured)),
            outside=0 if ok else 1,
            rows=(row,),
        )
    )


def _probe(
    expectation: Value | Sweep, reference: Any, index: int, scene: Scene, frame: Frame
) -> tuple[Banded, Inputs]:
    pass_name, name = split_output(expectation.output, scene)
    key = draw_key(scene, pass_name, expectation.draw)
    format, decimal = "rgba32f", None
    if isinstance(expectation, Value) and isinstance(expectation.at, Pixel):
        image = find_image(expectation.output, scene, frame)
        x, y = expectation.at.x, expectation.at.y
        measured, format = _pixel(image, expectation.at)[None], image.format
        each = {n: v[y, x][None] for n, v in pixel_inputs(frame, key).items()}
    else:
        samples = frame.probes[index]
        measured, each, decimal = samples.outputs[name], dict(samples.inputs), samples.decimal
    inputs = inputs_of(frame, key, each=each, given=expectation.given, decimal=decimal)
    return (
        judge_band(measured, reference, inputs, rules=expectation.rules, format=format),
        inputs,
    )


def _pixel(image: Image, at: Pixel) -> Array:
    height, width = image.values.shape[:2]
    if not (0 <= at.x < width and 0 <= at.y < height):
        raise CaseError(f"{at} lies outside the {width} × {height} target")
    found: Array = image.values[at.y, at.x]
    return found


def _label(expectation: Value) -> str:
    if isinstance(expectation.at, Pixel):
        where = f"pixel ({expectation.at.x}, {expectation.at.y})"
    else:
        where = ", ".join(f"{k} = {shown(v)}" for k, v in expectation.at.items())
    name = expectation.name
    return f"{name} at {where}" if name == expectation.output else f"{name} ({where})"


def _pictures(image: Image, covered: Array, banded: Banded) -> dict[str, Array]:
    whole = bool(covered.all())

    def laid_out(values: Array, nothing: float) -> Array:
        """Judged values at their pixels; `nothing` elsewhere."""
        if whole:  # as most draws are: then nothing need be copied
            return values.reshape(*covered.shape, *values.shape[1:])
        full = np.full((*covered.shape, *values.shape[1:]), nothing, values.dtype)
        full[covered] = values
        return full

    exact = laid_out(banded.reference, np.nan)
    reference, kind = exact, image.values.dtype
    if kind.kind in "iu":
        reference = np.nan_to_num(np.rint(exact)).astype(kind)
    return {
        "measured": laid_out(banded.measured, 0),
        "reference": reference,
        "distance": laid_out(banded.signed(), np.nan),
        "covered": covered,
        "exact": exact,
        "low": laid_out(banded.low, np.nan),
        "high": laid_out(banded.high, np.nan),
        "outside": laid_out(~banded.inside, False),
        "unit": np.asarray(banded.unit or 0.0),
    }


def _outcome(
    name: str,
    kind: str,
    status: Any,
    message: str,
    banded: Banded,
    rows: list[Any],
    covered: Array | None = None,
) -> Outcome:
    return Outcome(
        name=name,
        kind=kind,
        status=status,
        message=message,
        judged=int(banded.measured.size),
        outside=banded.outside,
        worst=banded.worst(covered),
        vacuous=banded.vacuous_share,
        undecided=banded.undecided_share,
        rows=tuple(rows),
        sources=(banded.source,),
    )
