"""Measures: statistics of a frame against bounds, and every way in which they can be wrong."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Case, Pass, Texture, Variant, computed, exact, fullscreen, measure, reading
from shaderlab.engine.expectations.measure import Measure
from shaderlab.errors import CaseError, FormulaError
from shaderlab.model.expectation import Judgement
from shaderlab.model.frame import Bindings, Frame, Image, Texels
from shaderlab.model.records import Plot, PlotPoint
from shaderlab.model.store import load, save
from tests.unit.test_report_samples import NAN, Page, record, run, write

LIT = np.linspace(0.0, 1.0, 16, dtype=np.float32).reshape(4, 4, 1)


def passes() -> tuple[Pass, ...]:
    return (*fullscreen("a.frag", name="near"), *fullscreen("b.frag", name="far"))


def frame(lit: Any = LIT) -> Frame:
    uniforms = {
        "light.gain": np.array([2.0], np.float32),
        "lights[0].reach": np.array([3.0], np.float32),
        "lights[1].reach": np.array([5.0], np.float32),
        "offsets": np.arange(6, dtype=np.float32).reshape(3, 2),
    }
    white = Texels(np.ones((2, 2, 4), np.float32), ("nearest",) * 2, ("repeat",) * 2, (0.0,) * 4)
    return Frame(
        images={
            ("near", "lit"): Image(np.asarray(lit), "r32f"),
            ("far", "lit"): Image(LIT / 2.0, "r32f"),
        },
        order=("near", "far"),
        bindings={
            ("near", 0): Bindings(),
            ("far", 0): Bindings(
                uniforms=uniforms, textures={"map": white}, arrays=frozenset({"offsets"})
            ),
        },
    )


def judged(expectation: Measure, given: Frame | None = None) -> Judgement:
    case = Case(title="T", passes=passes(), expect=[expectation])
    return expectation.judge(next(case.scenes()), given or frame())


def share_above(near_lit: Any, limit: Any = 0.5) -> Any:
    return (near_lit > limit).mean()


def test_a_share_at_edges_may_go_by_the_grid_of_corners() -> None:
    def per_step(near_lit: Any, subpixel_step: Any) -> Any:
        return (near_lit > 0.5).mean() / (256.0 * subpixel_step)

    share = float((LIT > 0.5).mean())
    assert share > 0.0
    check = measure("share", per_step, at_most=share / 16.0)
    fine, coarse = frame(), replace(frame(), subpixel_step=1 / 16)
    assert judged(check, fine).outcome.status == "fail"
    assert judged(check, coarse).outcome.status == "pass"


@pytest.mark.parametrize("own_types", [False, True])
@pytest.mark.parametrize("reads", [{}, {"far_lit": "far.lit"}])
def test_outputs_come_as_copies_or_as_they_were_read_back(
    own_types: bool, reads: dict[str, str]
) -> None:
    given, seen = frame(), []

    def least(far_lit: Any, offsets: Any) -> Any:
        seen.extend((far_lit, offsets))
        return far_lit.min()

    judged(measure("least", least, reads=reads, own_types=own_types, at_most=0.0), given)
    output, uniform = seen
    drawn = given.images["far", "lit"].values
    assert uniform.dtype == np.float64
    assert output.dtype == (np.float32 if own_types else np.float64)
    assert np.shares_memory(output, drawn) == own_types == (not output.flags.writeable)
    assert drawn.flags.writeable


def test_what_all_expectations_see_can_not_be_written_to() -> None:
    def spoils(near_lit: Any) -> Any:
        near_lit[:] = 1.0
        return near_lit.mean()

    with pytest.raises(FormulaError, match="read-only"):
        judged(measure("spoiled", spoils, own_types=True, at_least=1.0))
    assert judged(measure("copied", spoils, at_least=1.0)).outcome.status == "pass"


def test_outputs_are_found_by_pass_and_name() -> None:
    found = judged(measure("bright", share_above, equals=0.5, digits=3))
    assert found.outcome.status == "pass" and found.outcome.kind == "measure"
    (row,) = found.outcome.rows
    assert (row.label, row.expected, row.measured, row.ok) == ("bright", "0.500", "0.500000", True)
    assert found.plot is None
    assert found.outcome.sources[0].file.endswith("test_expectations_measure.py")


def test_images_are_float64_and_keep_their_shape() -> None:
    def size(near_lit: Any) -> float:
        assert near_lit.dtype == np.float64
        return float(near_lit.ndim)

    assert judged(measure("axes", size, at_least=3.0, at_most=3.0)).outcome.status == "pass"


def test_a_bare_name_is_the_last_pass_and_reads_binds_any() -> None:
    def largest(lit: Any) -> Any:
        return lit.max()

    here = measure("last", largest, equals=0.5, digits=6)
    there = measure("first", largest, reads={"lit": "near.lit"}, equals=1.0, digits=6)
    assert judged(here).outcome.status == judged(there).outcome.status == "pass"
    assert judged(measure("last", largest, equals=1.0, digits=6)).outcome.status == "fail"


def test_uniforms_textures_and_constants_are_found_by_name() -> None:
    def total(
        lit: Any, light_gain: float, lights_reach: Any, offsets: Any, map: Any, steps: float
    ) -> Any:
        assert lights_reach.shape == (2,) and offsets.shape == (3, 2)
        return light_gain + lights_reach.sum() + offsets.sum() + map.sum() + steps + 0 * lit.sum()

    found = judged(measure("sum", total, given={"steps": 4.0}, equals=45.0, digits=0))
    assert found.outcome.status == "pass", found.outcome.message


def test_readings_are_a_table_and_numbers_a_curve() -> None:
    rows = [
        reading(2, reads={"near_lit": "near.lit"}, series="near", at_most=0.6),
        reading(1, given={"limit": 0.75}, series="near", between=(0.2, 0.3)),
        reading(1, reads={"near_lit": "far.lit"}, series="far"),
    ]
    found = judged(measure("bright", share_above, readings=rows, x_label="size", log_y=True))
    assert [r.label for r in found.outcome.rows] == ["near, 2", "near, 1", "far, 1"]
    assert [r.expected for r in found.outcome.rows] == ["≤ 0.6", "0.2 … 0.3", "–"]
    assert found.outcome.status == "pass" and found.outcome.judged == 2
    plot = found.plot
    assert plot is not None and plot.log_y and plot.x_label == "size" and plot.y_label == "bright"
    assert [(p.series, p.x, p.y) for p in plot.points] == [
        ("near", 2.0, 0.5),
        ("near", 1.0, 0.25),
        ("far", 1.0, 0.0),
    ]


def test_a_bound_of_the_measure_holds_for_rows_without_one() -> None:
    rows = [reading("all"), reading("some", given={"limit": 0.9}, at_most=0.2)]
    found = judged(measure("bright", share_above, readings=rows, at_most=0.1))
    assert [row.ok for row in found.outcome.rows] == [False, True]
    assert found.outcome.message == "all: measured 0.5, expected ≤ 0.1"
    assert found.outcome.outside == 1


@pytest.mark.parametrize(
    "bound",
    [{"at_most": 0.49}, {"at_least": 0.51}, {"between": (0.6, 0.7)}, {"equals": 0.6, "digits": 1}],
)
def test_a_missed_bound_is_caught(bound: Any) -> None:
    assert judged(measure("bright", share_above, **bound)).outcome.status == "fail"


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_fails_even_where_no_bound_is(bad: float) -> None:
    def worst(near_lit: Any, times: float) -> Any:
        return near_lit[0, 0] * times + near_lit[0, 1]

    rows = [
        reading("bounded", given={"times": 1.0}, at_most=9.0),
        reading("free", given={"times": 0.0}),
    ]
    lit = LIT.copy()
    assert judged(measure("m", worst, readings=rows), frame(lit)).outcome.status == "pass"
    lit[0, 1] = bad
    found = judged(measure("m", worst, readings=rows), frame(lit))
    assert [row.ok for row in found.outcome.rows] == [False, False]


def wrong_names() -> list[tuple[Measure, str]]:
    def misspelt(near_lid: Any) -> Any:
        return near_lid.mean()

    def alone(light_gain: Any) -> Any:
        return light_gain

    return [
        (measure("m", misspelt, at_most=1.0), "did you mean near_lit"),
        (measure("m", share_above, reads={"near_lit": "near.lid"}, at_most=1.0), "near.lit"),
        (measure("m", share_above, reads={"near_litt": "near.lit"}, at_most=1.0), "near_lit"),
        (measure("m", share_above, given={"limitt": 1.0}, at_most=1.0), "did you mean limit"),
        (measure("m", alone, at_most=1.0), "computed"),
        (measure("m", share_above, pass_name="neer", at_most=1.0), "near"),
    ]


@pytest.mark.parametrize("which", range(6))
def test_wrong_names_are_errors_that_name_the_right_ones(which: int) -> None:
    expectation, remedy = wrong_names()[which]
    with pytest.raises(CaseError) as caught:
        judged(expectation)
    assert remedy in str(caught.value)


def test_a_statistic_must_give_one_number_and_must_not_raise() -> None:
    def vector(near_lit: Any) -> Any:
        return near_lit[0, :, 0]

    def word(near_lit: Any) -> Any:
        return "dark"

    def broken(near_lit: Any) -> Any:
        return near_lit[99].mean()

    for statistic in (vector, word, broken):
        with pytest.raises(FormulaError) as caught:
            judged(measure("m", statistic, at_most=1.0))
        assert (caught.value.file or "").endswith(
            "test_expectations_measure.py"
        ) and caught.value.line


@pytest.mark.parametrize(
    "make",
    [
        lambda: measure("m", share_above),
        lambda: measure("m", share_above, readings=[reading("a"), reading("b")]),
        lambda: measure("m", share_above, at_most=1.0, readings=[reading(1), reading(1)]),
        lambda: measure("m", share_above, at_most=1.0, equals=1.0, digits=1),
        lambda: measure("m", share_above, equals=1.0),
        lambda: measure("m", share_above, digits=1),
        lambda: measure("m", share_above, between=(2.0, 1.0)),
        lambda: measure("m", share_above, at_most=float("nan")),
        lambda: measure("m", share_above, at_most=float("inf")),
        lambda: measure("m", share_above, at_most=1.0, reads={"a": "b"}, given={"a": 1.0}),
        lambda: measure("m", 0.5, at_most=1.0),  # type: ignore[arg-type]
    ],
)
def test_a_measure_that_makes_no_sense_is_refused_when_it_is_written(make: Any) -> None:
    with pytest.raises(CaseError, match="measure"):
        make()


def test_what_a_measure_reads_is_known_before_it_is_run() -> None:
    def several(near_lit: Any, lit: Any, other: Any) -> Any:
        return 0.0

    expectation = measure("m", several, reads={"other": "far.depth"}, at_most=1.0)
    scene = next(Case(title="T", passes=passes(), expect=[expectation]).scenes())
    read = {(r.pass_name, r.output) for r in expectation.find_reads(scene)}
    assert {("near", "lit"), ("far", "lit"), ("far", "depth")} <= read


def test_figures_of_formulas_are_judged_with_the_first_variant_alone() -> None:
    case = Case(
        title="T",
        passes=fullscreen("a.frag", textures={"map": Texture(image=LIT)}),
        expect=[exact("y", 1.0), computed("two", lambda: 2.0, equals=2.0, digits=1)],
        variants=[
            Variant("a"),
            Variant("b", expect=[computed("own", lambda: 1.0, equals=1.0, digits=1)]),
        ],
    )
    assert [[e.name for e in s.expect] for s in case.scenes()] == [["y", "two"], ["y", "own"]]


def plot(**changes: Any) -> Plot:
    points = [
        ("A", 1.0, 0.5, 0.6, True),
        ("A", 2.0, 0.05, 0.01, False),
        ("B", 1.0, NAN, 1.0, False),
    ]
    fields: dict[str, Any] = {
        "title": "Wrongly dark",
        "x_label": "bias",
        "y_label": "share",
        "points": tuple(
            PlotPoint(series=s, x=x, y=y, low=-float("inf"), high=high, ok=ok)
            for s, x, y, high, ok in points
        ),
    }
    return Plot(**(fields | changes))


def test_plots_are_drawn_with_series_bounds_and_a_table(tmp_path: Path) -> None:
    page = Page(write(run(record(plots=(plot(),))), tmp_path))
    words = page.words()
    assert "Wrongly dark" in words and "2 outside" in words and "NaN" in words
    assert "1 point outside this chart" in words and "≤ 0.01" in words
    lines = [
        str(a["d"]) for t, a in page.tags if t == "path" and str(a.get("class")).startswith("line ")
    ]
    tile, shown = lines[:2], lines[2:]
    assert tile == shown and shown[0].count("L") == 1 and shown[1:] == [""]


def test_a_logarithmic_axis_spreads_small_figures(tmp_path: Path) -> None:
    points = tuple(
        PlotPoint(series="", x=float(n), y=10.0**-n, low=0.0, high=1.0, ok=True) for n in range(4)
    )
    heights = {}
    for log in (False, True):
        page = Page(write(run(record(plots=(plot(points=points, log_y=log),))), tmp_path))
        line = next(
            str(a["d"])
            for t, a in page.tags
            if t == "path" and str(a.get("class")).startswith("line ")
        )
        ys = [float(y) for y in re.findall(r"[ML][\d.]+ ([\d.]+)", line)]
        heights[log] = ys[3] - ys[2]
    assert heights[True] > 40 > heights[False]


def test_plots_are_saved_and_read_again(tmp_path: Path) -> None:
    saved = run(record(plots=(plot(points=plot().points[:2]),)))
    save(saved, tmp_path)
    assert load(tmp_path).records == saved.records


def test_an_output_is_not_measured_against_itself() -> None:
    with pytest.raises(CaseError, match="compared with itself"):
        measure("d", lambda a, b: 0.0, reads={"a": "main.y", "b": "main.y"}, at_most=1.0)
