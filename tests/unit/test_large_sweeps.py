"""Sweeps of many points: memory that does not grow, interrupts, and what the page shows of them."""

from __future__ import annotations

import dataclasses
import itertools
import math
import tracemalloc
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner, Result

from shaderlab.cli import cli, sweep, sweep_table
from shaderlab.cli.options import FILE_NAME
from shaderlab.cli.recorded_run import Grid, Journal, Parameter, RunPlan
from shaderlab.cli.sweep import PointRecords, run_points
from shaderlab.cli.sweep_table import SweepTable
from shaderlab.engine import worker
from shaderlab.engine.jobs import DriverInfo, Job, make_failed_record
from shaderlab.model import store
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record
from tests.unit.test_report_samples import Page
from tests.unit.test_sweep import measured

Install = Callable[[Mapping[str, Record]], list[Any]]


def points(count: int) -> Grid:
    reach = Parameter("reach", tuple(map(float, range(count))))
    return Grid(file="lamp.py", id="lamp", title="A lamp", section="", variant="near",
                parameters=(reach,))  # fmt: skip


class Made:
    """An executor that makes a record of each job when it is asked for it."""

    def __init__(self, template: Record, looks: Callable[[int], None]) -> None:
        self._template = template
        self._looks = looks
        self._count = itertools.count()

    def about(self) -> DriverInfo:
        return DriverInfo()

    def run(self, jobs: Sequence[Job], options: RunOptions) -> Generator[tuple[Job, Record]]:
        for job in jobs:
            number = next(self._count)
            self._looks(number)
            made = measured(self._template, job.variant, 0.5 + 1e-6 * number, 1.0)
            text = f"{number}" + "said" * 50
            yield job, dataclasses.replace(made, id=job.id, notices=(text,))


class Quiet:
    """Shows nothing."""

    def progress(self, total: int, most_said: float) -> AbstractContextManager[Any]:
        ignore = SimpleNamespace(follow=lambda _, results: results)
        return nullcontext(ignore)


def test_memory_does_not_grow_with_the_points(
    tmp_path: Path, passing: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep, "AT_ONCE", 100)
    monkeypatch.setattr(sweep_table, "ALL_LISTED", 100)
    used: dict[int, int] = {}

    def look(number: int) -> None:
        if number in (150, 499):
            used[number] = tracemalloc.get_traced_memory()[0]

    plan = RunPlan(started="", options=RunOptions(folder=tmp_path), grid=points(500))
    tracemalloc.start()
    try:
        recorded, table = run_points(Made(passing, look), plan, Quiet(), resume=False)  # type: ignore[arg-type]
    finally:
        tracemalloc.stop()
    assert used[499] - used[150] < 50_000, used  # 56 bytes a point; a record has thousands
    assert len(recorded.run.records) == sweep_table.OTHERS_LISTED
    assert table.listed() == list(range(499, 449, -1))
    assert (tmp_path / FILE_NAME).read_bytes().count(b"\n") == 501


def test_records_come_back_from_the_journal(tmp_path: Path, passing: Record) -> None:
    """Whatever they are, and in whatever order they came; a damaged line costs its own point."""
    grid = points(8)
    made = {
        3: make_failed_record(grid[3], "crash", "gone"),  # nothing in common with the others
        0: measured(passing, "reach=0", 0.5, 0.0),
        1: dataclasses.replace(measured(passing, "reach=1", 0.5, -0.0), seconds=-0.0),
        7: measured(passing, "reach=7", 9.0, 1e9),
        2: make_failed_record(grid[2], "timeout", "late"),
        4: measured(passing, "reach=4", math.nan, math.inf),
    }
    with Journal(tmp_path, RunPlan(started="", options=RunOptions(), grid=grid)) as journal:
        records = PointRecords(tmp_path, journal, len(grid))
        for point, record in made.items():
            records.add(point, record)

    def same(found: list[Record], points: list[int]) -> bool:
        """To the bit: 0.0 and -0.0 are two."""
        return repr([*map(store.to_plain, found)]) == repr(
            [store.to_plain(made[n]) for n in points]
        )

    assert same(records.read([7, 5, 4, 3, 2, 1, 0]), [7, 4, 3, 2, 1, 0])

    def resumed() -> tuple[list[int], list[int], list[Record]]:
        table = SweepTable(grid)
        with Journal(tmp_path, None) as journal:
            again = PointRecords(tmp_path, journal, len(grid))
            damaged = list(again.resume(table.add))
            return damaged, list(table.points()), again.read(table.points())

    damaged, there, found = resumed()
    assert (damaged, there) == ([], sorted(made)) and same(found, there)
    lines = (tmp_path / FILE_NAME).read_bytes().splitlines(keepends=True)
    for damage in (
        b"{}\n",
        lines[3].replace(b"[1,", b"[99,"),
        lines[1][:20] + b"\n",
        lines[3].replace(b"reach=1", b'x"]'),
        b"[1,[]]\n",
        b"[1,5,{}]\n",
        b'["1",{}]\n',
    ):
        (tmp_path / FILE_NAME).write_bytes(b"".join([*lines[:3], damage, *lines[4:]]))
        assert resumed()[:2] == ([4], [0, 2, 3, 4, 7]), damage
    (tmp_path / FILE_NAME).write_bytes(b"".join([*lines[:2], b"[0,{}]\n", *lines[3:]]))
    assert resumed()[:2] == ([3], [1, 2, 3, 4, 7])


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Result]:
    """Calls the lab in an empty folder, where few points are many."""
    monkeypatch.chdir(tmp_path)
    for name, value in (("ALL_LISTED", 5), ("FAILURES_LISTED", 2), ("OTHERS_LISTED", 1)):
        monkeypatch.setattr(sweep_table, name, value)
    monkeypatch.setattr(sweep, "AT_ONCE", 2)
    return lambda *args: CliRunner().invoke(cli, [*map(str, args)], catch_exceptions=False)


def widths(passing: Record, far: Mapping[int, float]) -> dict[str, Record]:
    return {f"reach={n}": measured(passing, "", far.get(n, 0.01 * n), n) for n in range(9)}


def words(path: Path) -> str:
    return " ".join(Page(path).words().split())


def test_the_page_of_many_points_lists_the_worst_and_says_so(
    call: Callable[..., Result], ramp: Path, fake_lab: Install, passing: Record, tmp_path: Path
) -> None:
    fake_lab(widths(passing, {2: 3.0, 4: 5.0, 6: 4.0, 8: 0.9}))
    swept = ("sweep", ramp, "--param", "reach=0:8:9", "--report")
    result = call(*swept, "out")
    assert result.exit_code == 1 and "9 points: 6 passed, 3 failed" in result.output
    run = store.load("out")
    assert [record.variant for record in run.records] == ["reach=4", "reach=6", "reach=8"]
    assert run.points is not None and run.points.statuses == {"pass": 6, "fail": 3}
    assert (run.points.judged, run.points.outside, run.points.checks) == (90, 3, 18)
    assert len(Path("out/sweep.csv").read_text().splitlines()) == 10
    (page,) = Path("out/cases").iterdir()
    listed = (
        "3 of 9 points are listed: the 2 worst of 3 that did not pass and the 1 worst of 6 that"
    )
    for file in (page, Path("out/index.html")):
        assert f"{listed} passed; all are in sweep.csv" in words(file)
    assert "../sweep.csv" in Page(page).attributes("href")
    assert "18 expectations" in words(Path("out/index.html"))
    assert [plot.points[8].y for plot in run.plots] == [0.9, 8.0]
    # Made again, compared, in another format, and a smaller one that lists all.
    assert "And 1 more point, in sweep.csv." in words(Path("out/index.html"))
    for name in ("markdown", "junit", "sarif"):
        assert call("report", "out", f"--{name}", "-").output.count("3 of 9 points are listed") == 1
    assert "- and 1 more variant\n" in call("report", "out", "--markdown", "-").output
    fake_lab(widths(passing, {2: 3.0, 4: 5.0, 6: 4.0, 7: 0.9}))
    assert call(*swept, "later", "--table", tmp_path / "else.csv").exit_code == 1
    assert call("report", "later", "--against", "out").exit_code == 0
    assert "2 points of a sweep are listed in only one of the two runs" in words(
        Path("later/against.html")
    )
    assert str(tmp_path / "else.csv") in words(next(Path("later/cases").iterdir()))
    fake_lab({})
    assert call("sweep", ramp, "--param", "reach=0:4:5", "--report", "small").exit_code == 0
    assert store.load("small").points is None and "listed" not in words(Path("small/index.html"))


def test_an_interrupted_sweep_keeps_what_was_judged(
    call: Callable[..., Result],
    ramp: Path,
    fake_lab: Install,
    passing: Record,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    log = fake_lab(widths(passing, {1: 3.0}))
    lab = worker.SceneRunner()
    run, stops = type(lab).run, ["reach=5"]

    def interrupt(self: Any, scene: Any) -> Record:
        if scene.variant in stops:
            stops.clear()
            raise KeyboardInterrupt
        record: Record = run(self, scene)
        return record

    monkeypatch.setattr(type(lab), "run", interrupt)
    result = call("sweep", ramp, "--param", "reach=0:8:9", "--report", "out")
    assert result.exit_code == 130 and "5 points: 4 passed, 1 failed, 4 not run" in result.output
    assert "shaderlab sweep --resume out" in result.output
    assert "2 of 5 points are listed: all 1 that did not pass" in words(Path("out/index.html"))
    log.clear()
    result = call("run", "--resume", "out")
    assert result.exit_code == 2 and "use shaderlab sweep --resume out" in result.output
    result = call("sweep", "--resume", "out")
    assert result.exit_code == 1 and "9 points: 8 passed, 1 failed" in result.output
    done: Iterable[str] = (entry for entry in log if isinstance(entry, str))
    assert list(done) == [*(f"lamp[reach={n}]" for n in range(5, 9)), "closed"]
    assert [record.variant for record in store.load("out").records] == ["reach=1", "reach=8"]
    rows = Path("out/sweep.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows[1:]] == [f"{n}.0" for n in range(9)]
