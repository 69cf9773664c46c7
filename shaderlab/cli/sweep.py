"""`shaderlab sweep`: one case over a grid of inputs, as a table and as plots."""

from __future__ import annotations

import contextlib
import itertools
import json
import time
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from shaderlab.cli import FAILED, OK
from shaderlab.cli.options import FILE_NAME, RunningOptions, collect, make_executor, running_options
from shaderlab.cli.recorded_run import (
    Journal,
    Parameter,
    RecordedRun,
    RunPlan,
    encode_line,
    finish,
    load_plan,
    new_plan,
    read_lines,
    report_damaged_lines,
)
from shaderlab.cli.sweep_table import SweepTable, make_grid, make_plots, parse_parameters
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import open_regular
from shaderlab.model import store
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record, Run

if TYPE_CHECKING:
    from shaderlab.cli.showing import Show
    from shaderlab.engine.jobs import Executor


TABLE = "sweep.csv"


@dataclass(frozen=True, kw_only=True)
class SweepArguments:
    """The arguments and options of `shaderlab sweep`, as its help describes them."""

    target: str | None
    params: tuple[str, ...]
    table: str | None
    running: RunningOptions
    resume: str | None
    pictures: bool

    @property
    def run_options(self) -> RunOptions:
        """How points are run."""
        running = self.running
        return RunOptions(
            pictures=self.pictures,
            include=running.includes,
            targets=running.compile_targets,
            driver=running.driver,
            limits=running.limits,
        )


@click.command("sweep")
@click.argument("target", required=False, metavar="ID | ID[VARIANT] | FILE.py")
@click.option(
    "--param", "params", multiple=True, metavar="NAME=VALUES",
    help="Sweep a uniform or ramp over A:B:N, A:B:Nlog or A,B,C; several make a grid.",
)  # fmt: skip
@click.option(
    "--table",
    metavar="FILE",
    help=f"Write the table to FILE: .csv or .parquet.  [default: {TABLE}]",
)
@running_options("point")
@click.option("--resume", metavar="FOLDER", help="Resume the unfinished sweep in FOLDER.")
@click.option("--pictures/--no-pictures", default=False, help="Render pictures of each point.")
@collect(SweepArguments, "arguments")
def command(arguments: SweepArguments) -> int:
    """Run one case at every point of a grid of parameters, and show how close results come to
    the limits of their bands.

    NAME is a uniform, a member of a uniform block or a ramp, as the case names it (a swept ramp has
    one value on the whole screen), or `size`, the side of the judged frame in pixels. All other
    inputs are those of the variant, by default the first. VALUES are

    \b
      0:1:11          11 values from 0 to 1, evenly spaced
      0.01:1:50log    50 values from 0.01 to 1, logarithmically spaced
      7,13,20         these values

    \b
    Examples:
      shaderlab sweep attenuation --param light.linear=0.01:1:50log --param size=64,256,1024
      shaderlab sweep 'blinn-phong[shininess 8]' --param shininess=1:1024:11log --table s.parquet

    The table has a row per point: the parameters, the status, the largest distance in half band
    widths (up to 1 is inside) and in ULP, the number of values outside and of those judged, the
    share of bands that allow any value, and the seconds of each phase. Only formulas are judged,
    because a case's figures hold for its own inputs alone.

    Exit code: 0 every point passed, 1 one did not, 2 wrong usage.
    """
    from shaderlab.report import table as tables

    if arguments.table is not None:
        tables.check(Path(arguments.table))
    running, resume = arguments.running, arguments.resume is not None
    plan = _resume(arguments) if resume else None
    swept = _parse_parameters(arguments)
    options = arguments.run_options if plan is None else plan.options
    with contextlib.closing(
        make_executor(options.driver, running.limits, running.workers)
    ) as executor:
        from shaderlab.cli.selecting import select_one
        from shaderlab.cli.showing import Show

        show = Show()
        if plan is None:
            facts, variant = select_one(arguments.target or "", executor.load)
            plan = new_plan(make_grid(facts, variant, swept), options, running.folder)
        recorded, points = run_points(executor, plan, show, resume=resume)
    show.sweep(points, recorded.run)
    file = recorded.folder / TABLE if arguments.table is None else Path(arguments.table)
    try:
        tables.write_table(points.rows, file)
        show.console.print(f"table: {file}")
    except ShaderlabError as error:  # the report is written all the same
        recorded = replace(recorded, problems=(*recorded.problems, error))
        file = recorded.folder / FILE_NAME
    recorded = summarise_points(recorded, points, file)
    is_latest = running.folder is None and not resume
    verdict = FAILED if points.failed else OK
    return finish(recorded, show, "sweep", verdict=verdict, is_latest=is_latest)


def _resume(arguments: SweepArguments) -> RunPlan:
    """Return the plan of the sweep that is resumed. Raises UsageError."""
    if arguments.target or arguments.params:
        raise UsageError("--resume takes neither a case nor parameters; the sweep has its own")
    plan, _ = load_plan(arguments.resume or "", arguments.running.limits)
    if plan.grid is None:
        raise UsageError(
            "this run is not a sweep", file=arguments.resume, remedy="use shaderlab run --resume"
        )
    return plan


def _parse_parameters(arguments: SweepArguments) -> tuple[Parameter, ...]:
    """Return the parameters; none for a sweep that is resumed. Raises UsageError."""
    if arguments.resume is None and arguments.target is None:
        raise UsageError("no case to sweep", remedy="name a case; `shaderlab list` shows all")
    if arguments.resume is None and not arguments.params:
        raise UsageError(
            "no parameter to sweep", remedy="add one, such as --param light.linear=0.01:1:50log"
        )
    return parse_parameters(arguments.params)


AT_ONCE = 4096
"""The number of points given to an executor at once, which keeps all of them."""
MOST_SAID = 40
"""The number of failing points named during the run; the table has all."""


def run_points(
    executor: Executor, plan: RunPlan, show: Show, *, resume: bool
) -> tuple[RecordedRun, SweepTable]:
    """Run all points of a sweep and write each to the journal; with `resume`, the missing ones.

    An interrupt ends it early: what was finished by then is in the journal and in the table. The
    run has the records of the points that the table lists.
    """
    folder, points = plan.options.folder, plan.grid
    assert folder is not None and points is not None
    table = SweepTable(points)
    with Journal(folder, None if resume else plan) as journal:
        records = PointRecords(folder, journal, len(points))
        if resume:
            report_damaged_lines(folder, records.resume(table.add))
        done = sum(table.statuses.values())
        clock = time.perf_counter()
        with (
            show.progress(len(points) - done, most_said=MOST_SAID) as progress,
            contextlib.suppress(KeyboardInterrupt),
        ):
            for some in _batches(point for point in range(len(points)) if point not in table):
                jobs = [points[point] for point in some]
                point_of = {job.key: point for job, point in zip(jobs, some, strict=True)}
                results = executor.run(jobs, plan.options)
                for job, record in progress.follow(jobs, results):
                    point = point_of[job.key]
                    table.add(point, records.add(point, record))
        seconds = time.perf_counter() - clock
        about = executor.about()
        listed = records.read(table.listed())
    run = Run(
        driver=about.driver,
        versions=about.versions,
        started=plan.started,
        seconds=seconds,
        records=tuple(listed),
        plots=make_plots(table),
        missing=len(points) - sum(table.statuses.values()),
    )
    problems = (ShaderlabError(journal.problem),) if journal.problem else ()
    return RecordedRun(run, folder, not run.missing, problems), table


def summarise_points(recorded: RecordedRun, table: SweepTable, file: Path) -> RecordedRun:
    """Add a summary of all points to a run that lists only some of them; `file` has them all."""
    if len(recorded.run.records) == sum(table.statuses.values()):
        return recorded
    where = file.resolve()
    folder = recorded.folder.resolve()
    name = where.relative_to(folder).as_posix() if where.is_relative_to(folder) else str(where)
    return replace(recorded, run=replace(recorded.run, points=table.summary(name)))


def _batches(points: Iterator[int]) -> Iterator[list[int]]:
    return iter(lambda: list(itertools.islice(points, AT_ONCE)), [])


Plain = Mapping[str, Any]


class PointRecords:
    """Writes and reads the records of `count` points in the journal of a sweep.

    A line is `[point, record]`. Only where it begins is kept in memory.

    Args:
        folder: the run's folder.
        journal: the journal that is open there.
        count: how many points there are.
    """

    def __init__(self, folder: Path, journal: Journal, count: int) -> None:
        self._folder = folder
        self._journal = journal
        self._starts = array("q", [-1]) * count

    def add(self, point: int, record: Record) -> Plain:
        """Write a point's record; return it as plain data."""
        plain: Plain = store.to_plain(record)
        start = self._journal.write(encode_line([point, plain]))
        self._starts[point] = -1 if start is None else start
        return plain

    def resume(self, use: Callable[[int, Plain], None]) -> Iterator[int]:
        """Call `use` with each point and record that an earlier command wrote.

        Yields:
            The numbers of lines that are damaged, or for which `use` raises.
        """
        for number, start, line in read_lines(self._folder):
            try:
                point, plain = json.loads(line)
                if type(point) is not int or not 0 <= point < len(self._starts):
                    raise ValueError(f"there is no point {point}")
                store.parse(plain, Record)
                use(point, plain)
            except (ValueError, LookupError, TypeError, AttributeError, ShaderlabError):
                yield number
            else:
                self._starts[point] = start

    def read(self, points: Iterable[int]) -> list[Record]:
        """Read the records of some points, without those that could not be written."""
        found = []
        with open(open_regular(self._folder / FILE_NAME), "rb") as file:
            for point in points:
                if self._starts[point] >= 0:
                    file.seek(self._starts[point])
                    _, plain = json.loads(file.readline())
                    found.append(store.parse(plain, Record))
        return found
