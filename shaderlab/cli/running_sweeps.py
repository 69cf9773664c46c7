"""Running the points of a sweep: as many as there are, and a few of them in memory."""

from __future__ import annotations

import contextlib
import itertools
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.cli.recorded_run import RecordedRun, each_record, tell_damaged
from shaderlab.errors import ShaderlabError
from shaderlab.model.records import Run
from shaderlab.workers.journal import Journal, RunPlan
from shaderlab.workers.sweep_plots import plots
from shaderlab.workers.sweep_records import PointRecords
from shaderlab.workers.sweep_table import SweepTable

if TYPE_CHECKING:
    from shaderlab.cli.showing import Show
    from shaderlab.workers import Executor

AT_ONCE = 4096
"""So many points are given to an executor, which keeps all that it is given."""
MOST_SAID = 40
"""So many points that do not pass are named as they come; the table has all."""


def run_points(
    executor: Executor, plan: RunPlan, show: Show, *, resume: bool
) -> tuple[RecordedRun, SweepTable]:
    """Run all points of a sweep, and write each to the journal; with `resume`, those that it lacks.

    An interrupt ends it early: what was finished by then is in the journal and in the table. The
    run has the records of the points that the table lists.
    """
    folder, grid = plan.options.folder, plan.grid
    assert folder is not None and grid is not None
    table = SweepTable(grid)
    with Journal(folder, None if resume else plan) as journal:
        records = PointRecords(folder, journal, len(grid))
        if resume:
            tell_damaged(folder, records.resume(table.add))
        done = sum(table.statuses.values())
        clock = time.perf_counter()
        with (
            show.progress(len(grid) - done, most_said=MOST_SAID) as progress,
            contextlib.suppress(KeyboardInterrupt),
        ):
            for points in _some(point for point in range(len(grid)) if point not in table):
                jobs = [grid[point] for point in points]
                point_of = {job.key: point for job, point in zip(jobs, points, strict=True)}
                for job, record in each_record(executor, jobs, plan.options, progress):
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
        plots=plots(table),
        missing=len(grid) - sum(table.statuses.values()),
    )
    problems = (ShaderlabError(journal.problem),) if journal.problem else ()
    return RecordedRun(run, folder, not run.missing, problems), table


def with_points(recorded: RecordedRun, table: SweepTable, file: Path) -> RecordedRun:
    """The run with what all points were, where it has not the records of all; `file` has them."""
    if len(recorded.run.records) == sum(table.statuses.values()):
        return recorded
    where = file.resolve()
    folder = recorded.folder.resolve()
    name = where.relative_to(folder).as_posix() if where.is_relative_to(folder) else str(where)
    return replace(recorded, run=replace(recorded.run, points=table.summary(name)))


def _some(points: Iterator[int]) -> Iterator[list[int]]:
    return iter(lambda: list(itertools.islice(points, AT_ONCE)), [])
