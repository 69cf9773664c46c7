"""Where a formula that fails goes wrong: the first line at which the driver leaves what the shader
allows, or else the first value that has a name in the reference and another number."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from shaderlab.files import display_path
from shaderlab.model.records import Explanation, Outcome, Step

from .evaluation import Evaluation
from .expectations.formula import Formula
from .expectations.needs import CapturedFragments
from .expectations.subject import subject_of
from .explaining import explain
from .judging.inputs import Inputs, evaluate


def located(evaluation: Evaluation, formula: Formula, outcome: Outcome) -> Explanation | None:
    """What the shader computes at a failing formula's worst pixel, and where that goes wrong; None
    of what is no pixel.

    Raises:
        ShaderlabError: the shader can't be interpreted, or its inputs can't be captured.
    """
    if outcome.worst is None or outcome.worst.pixel is None:
        return None
    key = formula.key(evaluation.scene)
    if formula.is_of_depth(evaluation.scene, evaluation.programs):
        return None
    explained = explain(evaluation, key, outcome.worst.pixel, if_outside=True)
    for step in explained.steps:
        if step.by_driver and not step.inside:
            return _blaming(explained, step, "the driver leaves what the shader allows", "allowed")
    numbers, result = _reference_at(evaluation, formula, outcome.worst.pixel)
    own = compared(formula.own_name(evaluation.scene))
    numbers.setdefault(own, []).append(result)
    for name, steps in _by_name(explained).items():
        known = numbers.get(name)
        # A name may be stored to several times, and a reference may have any of the values.
        if known and not any(_agrees(step, values) for step in steps for values in known):
            words = "the driver computes what the shader says"
            return _blaming(explained, steps[-1], words, "the reference's", _shown(known[-1]))
    return replace(
        explained,
        verdict="the driver computes what the shader says, and each value that has a name in the "
        "reference is the reference's",
    )


def _by_name(explained: Explanation) -> dict[str, list[Step]]:
    """The steps that store to each name, in the order of their first ones."""
    found: dict[str, list[Step]] = {}
    for step in explained.steps:
        found.setdefault(compared(step.name), []).append(step)
    return found


def _blaming(
    explained: Explanation, step: Step, words: str, other: str, shown: str = ""
) -> Explanation:
    file = display_path(step.file, step.line)
    value = _shown(np.array(step.value))
    if step.name == "condition":
        value, shown = ("true", "false") if step.value[0] else ("false", "true")
    elif not shown:
        pairs = zip(step.low, step.high, strict=True)
        shown = ", ".join(f"{low:.9g} … {high:.9g}" for low, high in pairs)
    return replace(
        explained,
        verdict=f"{words}; first at {file}: {step.name} is {value}, {other} {shown}",
        file=step.file,
        line=step.line,
    )


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


def _shown(values: Any) -> str:
    numbers = [f"{float(v):.9g}" for v in np.ravel(values)]
    return numbers[0] if len(numbers) == 1 else f"({', '.join(numbers)})"


_LAB = str(Path(__file__).parents[1])
_FORMULAS = str(Path(_LAB) / "reference")


def compared(name: str) -> str:
    """A name as shaders and references are compared by it: `lightDir` is `light_dir`.

    >>> compared("lightDir") == compared("light_dir")
    True
    """
    return name.replace("_", "").lower()


def reference_locals(
    reference: Callable[..., Any], inputs: Inputs
) -> tuple[Mapping[str, list[Any]], Any]:
    """What the functions of a reference, and those that it calls, assign and return, in float64.

    Returns:
        Values by `compared` name, those of a function's result by "name()"; and the reference's
        own result. Its parameters are left out: they are what the shader gets.

    Raises:
        FormulaError: the reference fails.
    """
    found: dict[str, list[Any]] = {}

    def note(frame: FrameType, event: str, result: Any) -> None:
        code = frame.f_code
        if event != "return" or not _is_formula(code.co_filename):
            return
        given = set(code.co_varnames[: code.co_argcount + code.co_kwonlyargcount])
        for name, value in frame.f_locals.items():
            if name not in given and _is_number(value):
                found.setdefault(compared(name), []).append(value)
        if _is_number(result):
            found.setdefault(compared(code.co_name) + "()", []).append(result)

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
