"""Judging measures: statistics of a frame's images, each against its bound."""

from __future__ import annotations

import inspect
import math
import re
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from shaderlab.activity import doing
from shaderlab.checks.inputs import located, parameter_name, source_of
from shaderlab.checks.judgement import Judgement
from shaderlab.checks.naming import draw_key, find_image, split_output
from shaderlab.errors import CaseError, FormulaError, ShaderlabError, nearest
from shaderlab.frame import Array, Bindings, Frame
from shaderlab.model import Bound, Measure, Reading, Scene
from shaderlab.records import Outcome, Plot, PlotPoint, Row

_INDEXED = re.compile(r"\[\d+\]")


def judge_measure(expectation: Measure, scene: Scene, frame: Frame) -> Judgement:
    """Compute each reading and hold it against its bound.

    Raises:
        CaseError: the statistic asks for something unknown, or for no output at all.
        FormulaError: it fails, or does not give one number; names its file and line.
    """
    known = _known(expectation, scene, frame)
    figures = [_figure(expectation, row, known, scene, frame) for row in expectation.readings]
    rows = tuple(_row(r, v) for r, v in zip(expectation.readings, figures, strict=True))
    wrong = [row for row in rows if not row.ok]
    message = ""
    if wrong:
        first = wrong[0]
        what = "" if len(rows) == 1 else f"{first.label}: "
        others = f" (and {len(wrong) - 1} more of {len(rows)})" if len(wrong) > 1 else ""
        message = f"{what}measured {first.measured}, expected {first.expected}{others}"
    outcome = Outcome(
        name=expectation.name,
        kind="measure",
        status="fail" if wrong else "pass",
        message=message,
        judged=sum(row.bound is not None for row in expectation.readings),
        outside=len(wrong),
        rows=rows,
        rows_heading=expectation.name if len(rows) > 1 else "",
        sources=(source_of(expectation.statistic),),
    )
    return Judgement(outcome=outcome, plot=_plot(expectation, figures, rows))


def outputs_read(expectation: Measure, scene: Scene) -> frozenset[tuple[str, str]]:
    """The (pass, output) pairs that a measure may read, told from names alone.

    Where a parameter could also mean a uniform, or an output of either of two passes, all of them
    are there: nothing that it reads is missing.
    """
    found: set[tuple[str, str]] = set()
    for row in expectation.readings:
        for parameter in inspect.signature(expectation.statistic).parameters:
            if parameter in row.given:
                continue
            if parameter in row.reads:
                pass_name, name = split_output(row.reads[parameter], scene)
                found.add((scene.find_pass(pass_name).name, name))
                continue
            found.add((scene.find_pass(None).name, parameter))
            for description in scene.passes:
                head = parameter_name(description.name) + "_"
                if parameter.startswith(head):
                    found.add((description.name, parameter.removeprefix(head)))
    return frozenset(found)


def _known(expectation: Measure, scene: Scene, frame: Frame) -> dict[str, Array]:
    """Everything that parameters may mean, by their names; of two, the output is meant."""
    key = draw_key(scene, expectation.pass_name, expectation.draw)
    known = _of_draw(frame.bindings[key])
    for (pass_name, name), image in frame.images.items():
        known[parameter_name(f"{pass_name}.{name}")] = image.values
    last = frame.order[-1]
    for (pass_name, name), image in frame.images.items():
        if pass_name == last:
            known[parameter_name(name)] = image.values
    return known


def _of_draw(bindings: Bindings) -> dict[str, Array]:
    """Uniforms and textures, members of arrays of structs together as one array; where they are
    single numbers, without an axis for components."""
    known: dict[str, Array] = {}
    lists: dict[str, list[Array]] = {}
    for name, values in bindings.uniforms.items():
        known[parameter_name(name)] = values[..., 0] if values.shape[-1] == 1 else values
        if _INDEXED.search(name):
            lists.setdefault(parameter_name(_INDEXED.sub("", name)), []).append(
                known[parameter_name(name)]
            )
    known |= {name: np.stack(values) for name, values in lists.items()}
    known |= {parameter_name(n): texels.values for n, texels in bindings.textures.items()}
    return known


def _figure(
    expectation: Measure, row: Reading, known: Mapping[str, Array], scene: Scene, frame: Frame
) -> float:
    arguments = _arguments(expectation, row, known, scene, frame)
    try:
        with doing("reference"), np.errstate(all="ignore"), warnings.catch_warnings():
            # The mean of nothing is NaN, which fails; NumPy need not say so as well.
            warnings.simplefilter("ignore", RuntimeWarning)
            got = expectation.statistic(**arguments)
    except ShaderlabError:
        raise
    except Exception as error:
        raise located(
            expectation.statistic,
            error,
            "a statistic gets arrays (height, width, components) and returns one number",
        ) from error
    try:
        array = np.asarray(got, np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.size != 1:
        place = source_of(expectation.statistic)
        raise FormulaError(
            f"{expectation.name}: the statistic gives {type(got).__name__} of shape "
            f"{np.shape(array)}, not one number",
            file=place.file,
            line=place.line,
        )
    return float(array.reshape(()))


def _arguments(
    expectation: Measure, row: Reading, known: Mapping[str, Array], scene: Scene, frame: Frame
) -> dict[str, Any]:
    arguments: dict[str, Any] = {}
    parameters = inspect.signature(expectation.statistic).parameters
    images = {id(image.values) for image in frame.images.values()}
    drawn = False
    for name in (*row.reads, *row.given):
        if name not in parameters:
            raise CaseError(
                f"measure {expectation.name!r}: its function has no parameter {name!r}",
                remedy=nearest(name, parameters),
            )
    for parameter in parameters.values():
        name = parameter.name
        if name in row.given:
            value = row.given[name]
            arguments[name] = value if np.isscalar(value) else np.asarray(value, np.float64)
        elif name in row.reads:
            arguments[name] = find_image(row.reads[name], scene, frame).values.astype(np.float64)
            drawn = True
        elif name in known:
            arguments[name] = np.asarray(known[name], np.float64)
            drawn = drawn or id(known[name]) in images
        elif parameter.default is parameter.empty:
            choices = [*known, *row.given]
            raise CaseError(
                f"measure {expectation.name!r}: its function asks for {name!r}, which is no "
                "output, no uniform and not given",
                remedy=nearest(name, choices),
            )
    if not drawn:
        raise CaseError(
            f"measure {expectation.name!r} reads no output, so no shader could fail it",
            remedy="computed(…) is for figures of formulas alone",
        )
    return arguments


def _row(row: Reading, figure: float) -> Row:
    label = f"{row.series}, {row.label}" if row.series else row.label
    more = 6 if row.bound is None or row.bound.digits is None else row.bound.digits + 3
    exact = row.bound is not None and row.bound.digits is not None
    return Row(
        label=label,
        expected=_expected(row.bound),
        measured=f"{figure:.{min(more, 9)}f}" if exact else f"{figure:.{more}g}",
        ok=_within(row.bound, figure),
        note=row.note,
    )


def _within(bound: Bound | None, figure: float) -> bool:
    if not math.isfinite(figure):
        return False
    return bound is None or bound.low <= figure <= bound.high


def _expected(bound: Bound | None) -> str:
    if bound is None:
        return "–"
    if bound.digits is not None:
        return f"{(bound.low + bound.high) / 2:.{bound.digits}f}"
    if math.isinf(bound.low):
        return f"≤ {bound.high:g}"
    if math.isinf(bound.high):
        return f"≥ {bound.low:g}"
    return f"{bound.low:g} … {bound.high:g}"


def _plot(expectation: Measure, figures: list[float], rows: tuple[Row, ...]) -> Plot | None:
    """The curve of the readings that have an x; None unless there are two."""
    points = tuple(
        PlotPoint(
            series=reading.series,
            x=reading.x,
            y=figure,
            low=-math.inf if reading.bound is None else reading.bound.low,
            high=math.inf if reading.bound is None else reading.bound.high,
            ok=row.ok,
        )
        for reading, figure, row in zip(expectation.readings, figures, rows, strict=True)
        if reading.x is not None
    )
    if len(points) < 2:
        return None
    return Plot(
        title=expectation.name,
        x_label=expectation.x_label,
        y_label=expectation.y_label,
        points=points,
        log_x=expectation.log_x,
        log_y=expectation.log_y,
    )
