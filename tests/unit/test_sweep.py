"""Sweeps: how ranges are typed, the grid they span, the table, the plots, the command."""

from __future__ import annotations

import csv
import dataclasses
import json
import math
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from shaderlab.cli import cli
from shaderlab.cli.recorded_run import Grid
from shaderlab.cli.sweep_table import (
    SweepTable,
    make_grid,
    make_plots,
    parse_parameter,
    parse_parameters,
)
from shaderlab.engine.jobs import CaseInfo
from shaderlab.errors import CaseError, UsageError
from shaderlab.model import store
from shaderlab.model.records import Outcome, Record, Worst
from shaderlab.report import table

FACTS = CaseInfo(
    file="lamp.py",
    id="lamp",
    variants=("near", "far"),
    formulas=(1, 0),
    parameters={"light.linear": 1, "reach": 1, "position": 3},
)
Install = Callable[[Mapping[str, Record]], list[Any]]


@pytest.mark.parametrize(
    ("word", "values", "log"),
    [
        ("x=0:1:5", (0.0, 0.25, 0.5, 0.75, 1.0), False),
        ("x=0:0.3:4", (0.0, 0.1, 0.2, 0.3), False),
        ("x=1:-1:3", (1.0, 0.0, -1.0), False),
        ("x=0.01:1:3log", (0.01, 0.1, 1.0), True),
        ("x=-1:-100:3log", (-1.0, -10.0, -100.0), True),
        ("x = 7, 13,1e2", (7.0, 13.0, 100.0), False),
        ("x=5", (5.0,), False),
        ("x=1,1,2", (1.0, 2.0), False),
        ("size=16:256:5log", (16.0, 32.0, 64.0, 128.0, 256.0), True),
        ("size=1:4:7", (1.0, 2.0, 3.0, 4.0), False),
    ],
)
def test_ranges(word: str, values: tuple[float, ...], log: bool) -> None:
    found = parse_parameter(word)
    assert (found.values, found.log) == (values, log)


@pytest.mark.parametrize(
    ("word", "says", "remedy"),
    [
        ("x", "no name and values", "NAME=START:STOP:COUNT"),
        ("=1,2", "no name and values", "NAME=A,B,C"),
        ("x=1:2", "'1:2' is no range", "START:STOP:COUNT"),
        ("x=1:2:3lin", "is no range", "0.01:1:50log"),
        ("x=1:2:2.5", "is no range", "START:STOP:COUNT"),
        ("x=a:2:3", "'a' is no number", "NAME=START"),
        ("x=1,,2", "'' is no number", "NAME=START"),
        ("x=1,inf", "is not finite", "NAME=START"),
        ("x=1:2:1", "2 values or more", "NAME=START"),
        ("x=0:1:5log", "logarithmic", "above 0"),
        ("x=-1:1:5log", "logarithmic", "above 0"),
        ("x=0:1:1000000000000", "the limit is 100,000", "in parts"),
        ("size=0,8", "1…4096", ""),
        ("size=8,5000", "1…4096", ""),
    ],
)
def test_what_is_wrong_with_a_range_is_said(word: str, says: str, remedy: str) -> None:
    with pytest.raises(UsageError) as raised:
        parse_parameter(word)
    assert says in raised.value.message and remedy in (raised.value.remedy or "")


def test_a_grid_is_the_product_of_its_parameters() -> None:
    jobs = make_grid(FACTS, "near", parse_parameters(["reach=1,2", "size=8,16"]))
    assert [job.variant for job in jobs] == [
        "reach=1, size=8", "reach=1, size=16", "reach=2, size=8", "reach=2, size=16",
    ]  # fmt: skip
    assert [jobs.coordinates(n) for n in range(4)][2] == {"reach": 2.0, "size": 8}
    with pytest.raises(IndexError):
        jobs[4]
    assert {job.point.variant for job in jobs if job.point} == {"near"}


def test_names_tell_close_values_apart() -> None:
    jobs = make_grid(FACTS, "near", parse_parameters(["reach=1,1.0000001,2"]))
    assert [job.variant for job in jobs] == ["reach=1.0", "reach=1.0000001", "reach=2"]


def test_what_a_case_does_not_have_is_named() -> None:
    for words, says, remedy in [
        (["light.liner=1,2"], "no uniform or ramp 'light.liner'", "light.linear"),
        (["sise=1,2"], "no uniform or ramp 'sise'", "size"),
        (["position=1,2"], "3 components", "reach"),
    ]:
        with pytest.raises(UsageError, match=says) as raised:
            make_grid(FACTS, "near", parse_parameters(words))
        assert remedy in (raised.value.remedy or "")
    with pytest.raises(UsageError, match="given twice"):
        parse_parameters(["x=1", "x=2"])
    with pytest.raises(
        UsageError, match=r"1,000,000 points \(1,000 × 1,000\), the limit is 100,000"
    ):
        parse_parameters(["x=0:1:1000", "y=0:1:1000"])
    with pytest.raises(UsageError, match="has no formula"):
        make_grid(FACTS, "far", parse_parameters(["reach=1,2"]))
    fixed = dataclasses.replace(FACTS, sized=False)
    with pytest.raises(UsageError, match="fixed size"):
        make_grid(fixed, "near", parse_parameters(["size=1,2"]))


def worst(widths: float, ulp: float) -> Worst:
    return Worst(pixel=(0, 0), component=0, measured=(0.0,), reference=(0.0,), low=(0.0,),
                 high=(0.0,), ulp=ulp, widths=widths)  # fmt: skip


def measured(template: Record, variant: str, widths: float, ulp: float) -> Record:
    fine = Outcome(
        name="a", kind="formula", status="pass", judged=4, vacuous=0.5, worst=worst(0.0, 0.0)
    )
    other = Outcome(name="b", kind="formula", status="fail", judged=6, outside=int(widths > 1),
                    worst=worst(widths, ulp))  # fmt: skip
    return dataclasses.replace(
        template, variant=variant, expectations=(fine, other), timings={"draw": 0.25},
        status="fail" if widths > 1 else "pass",
    )  # fmt: skip


def filled(jobs: Grid, records: Mapping[int, Record]) -> SweepTable:
    """The table of some points."""
    made = SweepTable(jobs)
    for point, record in records.items():
        made.add(point, store.to_plain(record))
    return made


def test_a_row_has_the_worst_of_all_formulas(passing: Record) -> None:
    jobs = make_grid(FACTS, "near", parse_parameters(["reach=1,2", "size=8"]))
    lost = dataclasses.replace(passing, variant="reach=2, size=8", status="crash", message="gone",
                               expectations=())  # fmt: skip
    table = list(filled(jobs, {1: lost, 0: measured(passing, "", math.nan, 3.0)}).rows())
    assert [row["reach"] for row in table] == [1.0, 2.0]
    assert list(table[0])[:5] == ["reach", "size", "status", "widths", "ulp"]
    assert (table[0]["widths"], table[0]["ulp"], table[0]["judged"]) == (math.inf, 3.0, 10)
    assert (table[0]["vacuous"], table[0]["draw"], table[0]["read"]) == (0.5, 0.25, 0.0)
    assert (table[1]["widths"], table[1]["status"], table[1]["message"]) == (None, "crash", "gone")
    assert list(table[0]) == list(table[1])


def test_plots_are_over_the_longest_parameter_with_few_series(passing: Record) -> None:
    jobs = make_grid(
        FACTS, "near", parse_parameters(["size=8,16", "reach=1,10,100", "light.linear=1,2"])
    )
    records = {
        n: measured(passing, "", 0.001 * jobs.coordinates(n)["reach"] * (1 + n % 2), 4.0)
        for n in range(len(jobs))
    }
    widths, ulp = make_plots(filled(jobs, records))
    assert (widths.x_label, widths.log_x, widths.y_label) == ("reach", True, "half band widths")
    assert widths.title.endswith("largest over size")
    assert {point.series for point in widths.points} == {"light.linear 1", "light.linear 2"}
    assert [point.y for point in widths.points[:3]] == pytest.approx([0.001, 0.01, 0.1])
    assert all(point.high == 1.0 for point in widths.points)
    assert all(point.high == math.inf for point in ulp.points)
    bad = make_plots(filled(jobs, {**records, 0: measured(passing, "", 2.0, 4.0)}))
    assert [point.ok for point in bad[0].points].count(False) == 1
    assert make_plots(filled(jobs, {0: records[0]})) == ()


def test_a_plot_of_many_points_has_the_worst_of_each_part(
    passing: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shaderlab.cli.sweep_table.MOST_DOTS", 5)
    monkeypatch.setattr("shaderlab.cli.sweep_table.PARTS", 3)
    jobs = make_grid(FACTS, "near", parse_parameters(["reach=1:6:6"]))
    far = {4: 1.5}
    made = {n: measured(passing, "", far.get(n, 0.1 + 0.01 * n), 1.0) for n in range(6)}
    widths, _ = make_plots(filled(jobs, made))
    assert widths.title.endswith("middle, largest in each of 3 parts")
    assert [(p.x, p.y, p.ok) for p in widths.points] == [
        (2.0, pytest.approx(0.11), True), (4.0, pytest.approx(0.13), True), (5.0, 1.5, False),
    ]  # fmt: skip


def test_tables_are_csv_or_parquet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = [
        {"x": 0.1, "status": "pass", "widths": None},
        {"x": 1.0, "status": "a\nb", "widths": 2.0},
    ]
    table.write_table(lambda: iter(data), tmp_path / "sub" / "t.csv")
    with open(tmp_path / "sub" / "t.csv", newline="") as file:
        assert list(csv.DictReader(file)) == [
            {"x": "0.1", "status": "pass", "widths": ""},
            {"x": "1.0", "status": "a\nb", "widths": "2.0"},
        ]
    parquet = pytest.importorskip("pyarrow.parquet")
    table.write_table(lambda: iter(data), tmp_path / "t.parquet")
    assert parquet.read_table(tmp_path / "t.parquet").to_pylist() == data
    with pytest.raises(UsageError, match=r"not \.xlsx"):
        table.check(tmp_path / "t.xlsx")
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(UsageError, match="needs pyarrow") as raised:
        table.check(tmp_path / "t.parquet")
    assert "shaderlab[sweep]" in (raised.value.remedy or "")


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Result]:
    """Calls `shaderlab sweep` in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return lambda *args: CliRunner().invoke(cli, ["sweep", *map(str, args)], catch_exceptions=False)


def test_each_point_is_run_and_told(
    call: Callable[..., Result], ramp: Path, fake_lab: Install, passing: Record
) -> None:
    fake_lab({f"reach={n}, size=8": measured(passing, "", n / 4, n) for n in (1, 2, 8)})
    result = call(ramp, "--param", "reach=1,2,8", "--param", "size=8", "--report", "out")
    assert result.exit_code == 1
    assert "3 points: 2 passed, 1 failed" in result.output
    lines = Path("out/sweep.csv").read_text().splitlines()
    assert lines[0].startswith(
        "reach,size,status,widths,ulp,outside,judged,vacuous,seconds,compile"
    )
    assert [line.split(",")[:4] for line in lines[1:]] == [
        ["1.0", "8", "pass", "0.25"],
        ["2.0", "8", "pass", "0.5"],
        ["8.0", "8", "fail", "2.0"],
    ]
    run = json.loads(Path("out/run.json").read_text())
    assert [plot["x_label"] for plot in run["plots"]] == ["reach", "reach"]
    assert "half band widths over reach" in next(Path("out/cases").iterdir()).read_text()


def test_a_sweep_that_was_cut_short_goes_on(
    call: Callable[..., Result], ramp: Path, fake_lab: Install
) -> None:
    log = fake_lab({})
    assert call(ramp, "--param", "reach=1:3:3", "--report", "out").exit_code == 0
    journal = Path("out/records.jsonl")
    journal.write_text("".join(journal.read_text().splitlines(keepends=True)[:2]))
    log.clear()
    assert call("--resume", "out").exit_code == 0
    assert [e for e in log if isinstance(e, str)] == ["lamp[reach=2]", "lamp[reach=3]", "closed"]
    assert len(Path("out/sweep.csv").read_text().splitlines()) == 4
    assert call("--resume", "out", ramp).exit_code == 2


def test_wrong_usage_says_what_is_right(
    call: Callable[..., Result], ramp: Path, fake_lab: Install
) -> None:
    fake_lab({})
    for words, says in [
        ((), "no case to sweep"),
        ((ramp,), "--param light.linear=0.01:1:50log"),
        ((ramp, "--param", "raech=1,2"), "did you mean reach?"),
        ((ramp, "--param", "reach=1:2"), "START:STOP:COUNT"),
        ((ramp, "--param", "reach=1", "--table", "t.txt"), ".csv or .parquet"),
        (("no-such-case", "--param", "reach=1"), "there is no case"),
    ]:
        result = call(*words)
        assert result.exit_code == 2 and says in result.output, result.output
    assert not Path("reports").exists()


def test_a_changed_scene_is_that_of_a_variant(ramp: Path) -> None:
    from shaderlab.engine.catalogue import load_case

    scene = load_case(ramp).scene("far")
    changed = scene.changed("reach=7", {"reach": 7.0})
    assert (scene.inputs["reach"], changed.inputs["reach"], changed.variant) == (
        50.0,
        7.0,
        "reach=7",
    )
    with pytest.raises(CaseError, match="raech"):
        scene.changed("x", {"raech": 7.0})
