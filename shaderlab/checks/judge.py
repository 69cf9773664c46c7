"""Frame and expectation in, judgement out: finds what an expectation is about, and judges it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from shaderlab.checks import plain as exactly
from shaderlab.checks.banded import (
    Banded,
    figure_row,
    judge_band,
    rounds_to,
    second_opinions,
)
from shaderlab.checks.inputs import Inputs, evaluate
from shaderlab.checks.judgement import Judgement, shown
from shaderlab.errors import CaseError, nearest
from shaderlab.frame import Array, Frame, Image, PassDraw
from shaderlab.model import (
    CompileFails,
    Computed,
    Coverage,
    Exact,
    Expectation,
    Formula,
    GlError,
    Output,
    Pixel,
    Scene,
    Sweep,
    Value,
    output_of,
)
from shaderlab.records import Curve, Diagnostic, Outcome

Refusals = Mapping[str, tuple[Sequence[Diagnostic], bool]]


def judge(index: int, scene: Scene, frame: Frame, refusals: Refusals) -> Judgement:
    """Judge expectation `index` of the scene.

    Args:
        index: its place in `scene.expect`.
        scene: what was run.
        frame: what it gave.
        refusals: for each shader that must be refused, its diagnostics and whether it compiles.

    Raises:
        CaseError, FormulaError: the expectation asks for what is not there.
    """
    expectation: Expectation = scene.expect[index]
    match expectation:
        case Formula():
            return _formula(expectation, scene, frame)
        case Sweep():
            return _sweep(expectation, index, scene, frame)
        case Value():
            return _value(expectation, index, scene, frame)
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
            return exactly.judge_compile_fails(expectation, *refusals[expectation.shader])
        case GlError():
            key = draw_key(scene, expectation.pass_name, expectation.draw)
            return exactly.judge_gl_error(expectation, frame.gl_errors.get(key, ()))


def draw_key(scene: Scene, pass_name: str | None, draw: int) -> PassDraw:
    """The (pass, draw) that an expectation means; negative draws count from the last one."""
    description = scene.find_pass(pass_name)
    count = len(description.draws)
    if not -count <= draw < count:
        raise CaseError(f"pass {description.name!r} has {count} draws, there is no draw {draw}")
    return description.name, draw % count


def find_image(name: str, scene: Scene, frame: Frame) -> Image:
    """The attachment an output's name means; without a pass, the last pass's."""
    split = output_of(name)
    key = (split.pass_name, split.name) if isinstance(split, Output) else (frame.order[-1], split)
    if key not in frame.images:
        known = [f"{p}.{n}" for p, n in frame.images]
        raise CaseError(f"there is no output {name!r}", remedy=nearest(name, known))
    return frame.images[key]


def is_vertex_output(name: str, key: PassDraw, frame: Frame) -> bool:
    """Whether `name` was captured from the draw's vertex stage, and is no attachment."""
    return key in frame.vertices and (key[0], name) not in frame.images


def reference_for(expectation: Value, scene: Scene) -> Any:
    """The value's own reference, or that of the formula of the same output."""
    if expectation.reference is not None:
        return expectation.reference
    for other in scene.expect:
        if isinstance(other, Formula | Sweep) and other.output == expectation.output:
            return other.reference
    return None


def split_output(name: str) -> tuple[str | None, str]:
    """An output's pass (None for the last) and its own name."""
    split = output_of(name)
    return (split.pass_name, split.name) if isinstance(split, Output) else (None, split)


def _formula(expectation: Formula, scene: Scene, frame: Frame) -> Judgement:
    pass_name, name = split_output(expectation.output)
    key = draw_key(scene, pass_name, expectation.draw)
    if is_vertex_output(name, key, frame):
        samples = frame.vertices[key]
        each, measured, format = dict(samples.inputs), samples.outputs[name], "rgba32f"
        pixels, image = None, None
    else:
        image = find_image(expectation.output, scene, frame)
        each = covered_inputs(frame, key)
        covered = frame.fragments[key].covered
        measured, format = image.values[covered], image.format
        pixels = [(int(x), int(y)) for y, x in np.argwhere(covered)]
    inputs = Inputs.of(frame.bindings[key], each=each, given=expectation.given)
    banded = judge_band(
        measured, expectation.reference, inputs, rules=expectation.rules, format=format
    )
    rows = second_opinions(banded, expectation.also)
    status, message = banded.verdict()
    if status == "pass" and not all(row.ok for row in rows):
        status, message = "fail", "an independent implementation leaves the band"
    pictures = {} if image is None else _pictures(image, frame.fragments[key].covered, banded)
    return Judgement(
        outcome=_outcome(expectation.name, "formula", status, message, banded, pixels, rows),
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
        outcome=_outcome(expectation.name, "sweep", status, message, banded, None, []), curve=curve
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
    return Judgement(
        outcome=_outcome(expectation.name, "value", status, message, banded, None, [row])
    )


def _measured_figure(expectation: Value, index: int, scene: Scene, frame: Frame) -> Judgement:
    """A figure without a reference: the measured value itself must round to it."""
    _, name = split_output(expectation.output)
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
    pass_name, name = split_output(expectation.output)
    key = draw_key(scene, pass_name, expectation.draw)
    format, decimal = "rgba32f", None
    if isinstance(expectation, Value) and isinstance(expectation.at, Pixel):
        image = find_image(expectation.output, scene, frame)
        x, y = expectation.at.x, expectation.at.y
        measured, format = _pixel(image, expectation.at)[None], image.format
        each = {n: v[y, x][None] for n, v in _images_of(frame, key).items()}
    else:
        samples = frame.probes[index]
        measured, each, decimal = samples.outputs[name], dict(samples.inputs), samples.decimal
    inputs = Inputs.of(frame.bindings[key], each=each, given=expectation.given, decimal=decimal)
    return (
        judge_band(measured, reference, inputs, rules=expectation.rules, format=format),
        inputs,
    )


def covered_inputs(frame: Frame, key: PassDraw) -> dict[str, Array]:
    """Captured inputs of the pixels a draw covers, each (count, components)."""
    covered = frame.fragments[key].covered
    return {name: values[covered] for name, values in _images_of(frame, key).items()}


def _images_of(frame: Frame, key: PassDraw) -> dict[str, Array]:
    fragments = frame.fragments[key]
    return {**fragments.inputs, "frag_coord": fragments.frag_coord}


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
    height, width, components = image.values.shape
    reference = np.full((height, width, components), np.nan)
    reference[covered] = banded.reference
    if image.values.dtype.kind in "iu":
        reference = np.nan_to_num(np.rint(reference)).astype(image.values.dtype)
    distance = np.full((height, width), np.nan)
    distance[covered] = banded.signed_distance()
    measured = np.where(covered[..., None], image.values, 0).astype(image.values.dtype)
    return {"measured": measured, "reference": reference, "distance": distance}


def _outcome(
    name: str,
    kind: str,
    status: Any,
    message: str,
    banded: Banded,
    pixels: list[tuple[int, int]] | None,
    rows: list[Any],
) -> Outcome:
    return Outcome(
        name=name,
        kind=kind,
        status=status,
        message=message,
        judged=int(banded.measured.size),
        outside=int((~banded.inside).sum()),
        worst=banded.worst(pixels),
        vacuous=banded.vacuous_share,
        undecided=banded.undecided_share,
        rows=tuple(rows),
        sources=(banded.source,),
    )
