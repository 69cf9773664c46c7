"""What each line of a fragment shader computes at one pixel: by driver, float64 and bands.

And where a formula that fails goes wrong.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.formula import Formula
from shaderlab.engine.expectations.needs import CapturedFragments, subject_of
from shaderlab.engine.judging.banded import format_value
from shaderlab.engine.judging.references import Inputs, evaluate
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import display_path
from shaderlab.model.frame import Array, PassDraw
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Explanation, Outcome, Step

from .driver_values import driver_values
from .inputs import inputs_of
from .interpreter import Bands, Stored
from .invocations import sample_fragments
from .self_check import find_outside, shows_what_is_written
from .steps import SAMPLES, steps_at, trace_invocations, widest_row

if TYPE_CHECKING:
    from shaderlab.engine.worker import Worker


def explain(
    evaluation: Evaluation, key: PassDraw, pixel: tuple[int, int], *, if_outside: bool = False
) -> Explanation:
    """What a draw's fragment shader stores at a pixel that it is seen at.

    With `if_outside` the driver draws the shader's statements only where an output of its leaves
    the band there: else it does what the shader says, and float32 arithmetic shows that as well.
    Raises UsageError: the draw is not seen there; NotInterpretedError: the shader can't be
    interpreted; DriverError, CaseError: its inputs can't be captured."""
    given = sample_fragments(evaluation, key, among=np.array([pixel]))
    assert given.pixels is not None
    rows = np.flatnonzero((given.pixels == pixel).all(axis=-1))
    if not rows.size:
        height, width = evaluation.answer(CapturedFragments(key)).covered.shape
        raise UsageError(
            f"draw {key[1]} of pass {key[0]!r} is not seen at pixel {pixel}",
            remedy=f"its columns are 0 to {width - 1}, its rows 0 to {height - 1}",
        )
    bands = trace_invocations(given.program, given.batch, Bands())
    row = int(rows[0])
    driver, refused = dict[Stored, Array](), ""
    if not if_outside or (
        shows_what_is_written(evaluation, key)
        and any(
            (flags := find_outside(given, name, band)) is not None and flags[row]
            for name, band in bands.outputs.items()
        )
    ):
        here = [event for event in bands.stored if event.mask[row]]
        undecided = bool(bands.undecided[row])
        try:
            driver = driver_values(evaluation, key, pixel, here, undecided=undecided)
        except ShaderlabError as error:
            refused = str(error).splitlines()[0]
    return Explanation(
        pixel=pixel, steps=steps_at(given.program, given.batch, bands, driver, row), refused=refused
    )


def explain_in_case(
    file: Path,
    variant: str,
    pass_name: str | None,
    draw: int,
    pixel: tuple[int, int] | None,
    options: RunOptions,
    worker: Worker,
) -> tuple[Explanation, Mapping[str, tuple[float, ...]]]:
    """What a draw stores at a pixel, by default where its band is widest, and what that gets, by
    name. `pass_name` is None for the last pass; `draw` counts from 0, from the last if negative."""
    lab, scene = worker.lab(options), worker.scenes(str(file))[variant]
    key = scene.draw_key(pass_name, draw)
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        pixel = pixel or widest_pixel(evaluation, key)
        return explain(evaluation, key, pixel), inputs_at(evaluation, key, pixel)


def inputs_at(
    evaluation: Evaluation, key: PassDraw, pixel: tuple[int, int]
) -> dict[str, tuple[float, ...]]:
    """What a draw's fragment shader gets at a pixel that it is seen at. Raises as `explain`."""
    given = sample_fragments(evaluation, key, among=np.array([pixel]))
    row = int(np.flatnonzero(np.all(given.pixels == pixel, axis=-1))[0])
    return given.batch.example(row, inputs_of(given.program))


def widest_pixel(evaluation: Evaluation, key: PassDraw) -> tuple[int, int]:
    """The pixel of a draw where the band of what it writes is widest in ULP, of some from all over
    the picture; the first one where all are exact. Raises UsageError: the draw is not seen;
    NotInterpretedError, DriverError, CaseError: as `explain`."""
    given = sample_fragments(evaluation, key, SAMPLES)
    assert given.pixels is not None
    if not given.count:
        raise UsageError(f"draw {key[1]} of pass {key[0]!r} is not seen at any pixel")
    x, y = given.pixels[widest_row(given.program, given.batch)]
    return int(x), int(y)


def locate_failure(
    evaluation: Evaluation, formula: Formula, outcome: Outcome
) -> Explanation | None:
    """What the shader computes at a failing formula's worst pixel, and where that goes wrong; None
    of what is no pixel. Raises ShaderlabError: the shader can't be interpreted, or its inputs can't
    be captured."""
    if outcome.worst is None or outcome.worst.pixel is None:
        return None
    key = formula.key(evaluation.scene)
    if formula.is_of_depth(evaluation.scene, evaluation.programs):
        return None
    explained = explain(evaluation, key, outcome.worst.pixel, if_outside=True)
    for step in explained.steps:
        if step.by_driver and not step.inside:
            words = "the driver is outside the shader's band"
            return _add_verdict(explained, step, words, "allowed")
    numbers, result = _reference_at(evaluation, formula, outcome.worst.pixel)
    own = normalize_name(formula.own_name(evaluation.scene))
    numbers.setdefault(own, []).append(result)
    by_name: dict[str, list[Step]] = {}
    for step in explained.steps:
        by_name.setdefault(normalize_name(step.name), []).append(step)
    for name, steps in by_name.items():
        known = numbers.get(name)
        # A name may be stored to several times, and a reference may have any of the values.
        if known and not any(_agrees(step, values) for step in steps for values in known):
            words = "the driver follows the shader, which differs from the reference"
            expected = format_value(known[-1])
            return _add_verdict(explained, steps[-1], words, "in the reference", expected)
    agreed = "every value that has a name in the reference agrees with it"
    return replace(explained, verdict=f"the driver follows the shader, and {agreed}")


def _add_verdict(
    explained: Explanation, step: Step, words: str, other: str, expected: str = ""
) -> Explanation:
    file = display_path(step.file, step.line)
    value = format_value(step.value)
    if not expected:
        pairs = zip(step.low, step.high, strict=True)
        expected = ", ".join(f"{low:.9g} … {high:.9g}" for low, high in pairs)
    verdict = f"{words}; first at {file}: {step.name} is {value}, {other} {expected}"
    return replace(explained, verdict=verdict, file=step.file, line=step.line)


def _reference_at(
    evaluation: Evaluation, formula: Formula, pixel: tuple[int, int]
) -> tuple[dict[str, list[Any]], Any]:
    """The reference's values at one pixel, computed with those of its quad."""
    scene = evaluation.scene
    subject = subject_of(formula, formula.given, scene, evaluation.frame)
    captured = evaluation.answer(CapturedFragments(formula.key(scene)))
    y, x = np.nonzero(captured.covered)
    rows = np.flatnonzero((x >> 1 == pixel[0] >> 1) & (y >> 1 == pixel[1] >> 1))
    row = int(np.flatnonzero((x[rows] == pixel[0]) & (y[rows] == pixel[1]))[0])
    found, result = reference_locals(formula.reference, subject.inputs.part(rows))

    def at(value: Any) -> Any:
        array = np.asarray(value, np.float64)
        return array[row] if array.ndim > 1 and len(array) == len(rows) else array

    return {name: [at(v) for v in values] for name, values in found.items()}, at(result)


def _agrees(step: Step, values: Any) -> bool:
    """Whether a reference's value lies in the band of a step's, or has another shape."""
    array = np.ravel(values)
    if array.size not in (1, len(step.low)):
        return True
    low, high = np.array(step.low), np.array(step.high)
    give = 2.0**-23 * np.maximum(np.abs(low), np.abs(high))
    inside = (array >= low - give) & (array <= high + give)
    return bool((inside | np.isnan(array)).all())


_LAB = str(Path(__file__).parents[1])
_FORMULAS = str(Path(_LAB) / "reference")


def normalize_name(name: str) -> str:
    """A name as shaders and references are compared by it: `lightDir` is `light_dir`.

    >>> normalize_name("lightDir") == normalize_name("light_dir")
    True
    """
    return name.replace("_", "").lower()


def reference_locals(
    reference: Callable[..., Any], inputs: Inputs
) -> tuple[Mapping[str, list[Any]], Any]:
    """What the functions of a reference, and those that it calls, assign and return, in float64:
    values by normalized name, those of a function's result by "name()"; and the reference's own
    result. Its parameters are left out: they are what the shader gets. Raises FormulaError: the
    reference fails."""
    found: dict[str, list[Any]] = {}

    def note(frame: FrameType, event: str, result: Any) -> None:
        code = frame.f_code
        if event != "return" or not _is_formula(code.co_filename):
            return
        given = set(code.co_varnames[: code.co_argcount + code.co_kwonlyargcount])
        for name, value in frame.f_locals.items():
            if name not in given and _is_number(value):
                found.setdefault(normalize_name(name), []).append(value)
        if _is_number(result):
            found.setdefault(normalize_name(code.co_name) + "()", []).append(result)

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        result = evaluate(reference, inputs, rules=None, decimal=False)
    finally:
        sys.setprofile(before)
    return found, result


def _is_formula(file: str) -> bool:
    """Whether a file is a case's or holds formulas of the lab: neither Python's nor NumPy's, nor
    the lab's other files."""
    if file.startswith("<") or "site-packages" in file:
        return False
    return not file.startswith((_LAB, sys.base_prefix)) or file.startswith(_FORMULAS)


def _is_number(value: Any) -> bool:
    return isinstance(value, float | int | np.ndarray) and not isinstance(value, bool)
