"""Running a plan with its journal: what `shaderlab run` and `sweep` share."""

from __future__ import annotations

import contextlib
import datetime
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.cli.files import REPORTS, new_run_folder, report_folder, write_outputs
from shaderlab.cli.replacing import unread
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.execution.journal import FILE_NAME, Journal, RunPlan, read
from shaderlab.files import display_path
from shaderlab.options import Limits, RunOptions
from shaderlab.records import Record, Run

if TYPE_CHECKING:
    from shaderlab.cli.showing import Show
    from shaderlab.execution import Executor, Job


@dataclass(frozen=True)
class RecordedRun:
    """A run, and its folder.

    Attributes:
        complete: whether all of the plan was run; an interrupt ends it early.
        problems: what could not be written, and files given in a shader's place that no program
            was made of.
    """

    run: Run
    folder: Path
    complete: bool
    problems: tuple[ShaderlabError, ...] = ()


def new_plan(jobs: Sequence[Job], options: RunOptions, folder: str | None) -> RunPlan:
    """A plan to run these jobs now, in `folder` or a new one, which is made."""
    made = new_run_folder() if folder is None else report_folder(Path(folder))
    now = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    return RunPlan(started=now, options=replace(options, folder=made), jobs=tuple(jobs))


def resumed_plan(folder: Path, limits: Limits) -> tuple[RunPlan, list[Record]]:
    """The plan of an earlier run, to be finished with these limits, and the records there are.

    Raises:
        UsageError: there is no such run.
    """
    plan, done = read(folder)
    return replace(plan, options=replace(plan.options, folder=folder, limits=limits)), done


def resumed_folder(word: str) -> Path:
    """The folder of the run to resume: the one that is named, or the last that was begun."""
    if word:
        return Path(word)
    begun = sorted(REPORTS.glob(f"*/{FILE_NAME}"), key=lambda path: path.stat().st_mtime)
    if not begun:
        raise UsageError(f"there is no run in {REPORTS}/", remedy="name its folder")
    return begun[-1].parent


def run_plan(
    executor: Executor, plan: RunPlan, done: Sequence[Record], journal: Journal, show: Show
) -> RecordedRun:
    """Run all jobs of the plan but those that are `done`; the records are in the plan's order.

    An interrupt ends it early: what was finished by then is in the journal and in the result.
    """
    clock = time.perf_counter()
    records = {(record.id, record.variant): record for record in done}
    waiting = {job.key: job for job in plan.jobs if job.key not in records}
    with show.progress(len(waiting)) as progress, contextlib.suppress(KeyboardInterrupt):
        results = executor.run(list(waiting.values()), plan.options)
        while waiting:
            progress.starts(*next(iter(waiting)))
            job, record = next(results)
            records[job.key] = record
            journal.add(record)
            del waiting[job.key]
            progress.ends(record)
    ordered = tuple(records[job.key] for job in plan.jobs if job.key in records)
    about = executor.about()
    run = Run(
        driver=about.driver,
        versions=about.versions,
        started=plan.started,
        seconds=time.perf_counter() - clock,
        records=ordered,
        replaced={name: display_path(file) for name, file in plan.options.shaders.items()},
        missing=len(waiting),
    )
    assert plan.options.folder is not None
    ignored = () if waiting else unread(plan.options.shaders, ordered)
    problems = [ShaderlabError(journal.problem)] if journal.problem else []
    return RecordedRun(run, plan.options.folder, not waiting, (*problems, *ignored))


def write_report(
    recorded: RecordedRun, outputs: Mapping[str, str]
) -> tuple[Path | None, list[ShaderlabError]]:
    """Write the run, its page and its outputs; return the page, and what can't be written."""
    from shaderlab.report import html, store

    problems: list[ShaderlabError] = []
    page: Path | None = None
    try:
        store.save(recorded.run, recorded.folder)
    except ShaderlabError as error:
        problems.append(error)
    try:
        page = html.write(recorded.run, recorded.folder)
    except ShaderlabError as error:
        problems.append(error)
    problems += write_outputs(recorded.run, outputs)
    return page, [*problems, *recorded.problems]
