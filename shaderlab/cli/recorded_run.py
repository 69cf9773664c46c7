"""Running a plan with its journal: what `shaderlab run` and `sweep` share."""

from __future__ import annotations

import contextlib
import datetime
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from shaderlab.cli import INTERRUPTED
from shaderlab.cli.journal import FILE_NAME, Journal, RunPlan, read_journal
from shaderlab.cli.outputs import (
    KEEP,
    REPORTS,
    make_report_folder,
    make_run_folder,
    mark_named,
    point_latest,
    remove_old_runs,
    report_problems,
    write_outputs,
)
from shaderlab.cli.replacing import find_unused
from shaderlab.cli.sweep_table import Grid
from shaderlab.engine.settings import load_settings
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import display_path
from shaderlab.model.options import Limits, RunOptions
from shaderlab.model.records import CodeCoverage, Record, Run

if TYPE_CHECKING:
    from shaderlab.cli.showing import Reporter, Show
    from shaderlab.engine.executors import Executor
    from shaderlab.engine.jobs import Job


@dataclass(frozen=True)
class RecordedRun:
    """A run, and its folder.

    Attributes:
        complete: whether all of the plan was run; an interrupt ends it early.
        problems: what could not be written, and files given in a shader's place that no program
            was made of.
        records: those of all drivers, where the run has several.
    """

    run: Run
    folder: Path
    complete: bool
    problems: tuple[ShaderlabError, ...] = ()
    records: tuple[Record, ...] = ()


def new_plan(jobs: Sequence[Job] | Grid, options: RunOptions, folder: str | None) -> RunPlan:
    """A plan to run these jobs, or points, now, in `folder` or a new one, which is made."""
    made = make_run_folder() if folder is None else make_report_folder(Path(folder))
    now = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    options = replace(options, folder=made)
    if isinstance(jobs, Grid):
        return RunPlan(started=now, options=options, grid=jobs)
    return RunPlan(started=now, options=options, jobs=tuple(jobs))


def load_plan(word: str, limits: Limits) -> tuple[RunPlan, list[Record]]:
    """The plan of an earlier run, to be finished with these limits, and the records there are.

    `word` is the run's folder, or "" for the last one that was begun.

    Raises:
        UsageError: there is no such run.
    """
    if not word:
        begun = sorted(REPORTS.glob(f"*/{FILE_NAME}"), key=lambda path: path.stat().st_mtime)
        if not begun:
            raise UsageError(f"there is no run in {REPORTS}/", remedy="name its folder")
    folder = Path(word) if word else begun[-1].parent
    if word:
        mark_named(folder)
    plan, done, damaged = read_journal(folder)
    report_damaged_lines(folder, damaged)
    frames = plan.options.frames and folder / plan.options.frames.name
    options = replace(plan.options, folder=folder, limits=limits, frames=frames)
    return replace(plan, options=options), done


def report_damaged_lines(folder: Path, lines: Iterable[int]) -> None:
    """Say of each damaged line of a journal that its record is made again."""
    for line in lines:
        place = display_path(folder / FILE_NAME, line)
        click.echo(f"shaderlab: {place}: this record is damaged; its job runs again", err=True)


def run_jobs(
    executor: Executor, jobs: Sequence[Job], options: RunOptions, progress: Reporter
) -> Iterator[tuple[Job, Record]]:
    """The jobs with their records as they come, with their progress shown."""
    waiting = {job.key: job for job in jobs}
    results = executor.run(jobs, options)
    while waiting:
        progress.starts(*next(iter(waiting)))
        job, record = next(results)
        yield job, record
        del waiting[job.key]
        progress.ends(record)


def run_plan(
    executor: Executor,
    plan: RunPlan,
    show: Show,
    done: Sequence[Record] | None = None,
) -> RecordedRun:
    """Run all jobs of the plan, with their records in its order; write each to the journal.

    An interrupt ends it early: what was finished by then is in the journal and in the result.

    Args:
        executor, plan, show: what runs it, what is run, and what shows how far that is.
        done: the records of a run that is resumed; their jobs are not run again.
    """
    assert plan.options.folder is not None
    records = {record.key: record for record in done or ()}
    waiting = [job for job in plan.jobs if job.key not in records]
    with (
        Journal(plan.options.folder, plan if done is None else None) as journal,
        show.progress(len(waiting)) as progress,
        contextlib.suppress(KeyboardInterrupt),
    ):
        clock = time.perf_counter()
        for job, record in run_jobs(executor, waiting, plan.options, progress):
            records[job.key] = record
            journal.add(record)
    about = executor.about()
    made = tuple(records[job.key] for job in plan.jobs if job.key in records)
    first = plan.jobs[0].driver if plan.jobs else ""
    run = Run(
        driver=about.driver,
        versions=about.versions,
        started=plan.started,
        seconds=time.perf_counter() - clock,
        records=tuple(record for record in made if record.driver_name == first),
        replaced={name: display_path(file) for name, file in plan.options.shaders.items()},
        missing=len(plan.jobs) - len(made),
    )
    ignored = () if run.missing else find_unused(plan.options.shaders, run.records)
    problems = [ShaderlabError(journal.problem)] if journal.problem else []
    return RecordedRun(run, plan.options.folder, not run.missing, (*problems, *ignored), made)


def measure_coverage(
    recorded: RecordedRun, executor: Executor, plan: RunPlan, show: Show
) -> RecordedRun:
    """The run with the code coverage of its cases that passed, measured now."""
    from shaderlab.engine.executors import LocalExecutor, format_error
    from shaderlab.mutation.code_coverage import CoverCase

    assert isinstance(executor, LocalExecutor)
    passed = {record.key for record in recorded.run.records if record.status == "pass"}
    cases: dict[tuple[str, str], list[str]] = {}
    for job in plan.jobs:
        if job.key in passed:
            cases.setdefault((job.id, job.file), []).append(job.variant)
    ids = [case_id for case_id, _ in cases]
    requests = [CoverCase(Path(f), tuple(v), plan.options) for (_, f), v in cases.items()]
    found: dict[int, CodeCoverage] = {}
    with show.progress(len(requests)) as progress, contextlib.suppress(KeyboardInterrupt):
        for result in executor.perform(requests):
            progress.advance()
            if result.status == "done":
                found[result.number] = replace(result.value, id=ids[result.number])
            else:
                message = format_error(result) or result.status
                found[result.number] = CodeCoverage(id=ids[result.number], message=message)
    ordered = tuple(found[number] for number in sorted(found))
    return replace(recorded, run=replace(recorded.run, code_coverage=ordered))


def finish(
    recorded: RecordedRun,
    show: Show,
    command: str,
    *,
    verdict: int,
    is_latest: bool,
    outputs: Mapping[str, str] | None = None,
    open_report: bool = False,
) -> int:
    """Write and show where everything is; returns the exit status.

    Args:
        recorded, show: the run, and what says where it is.
        command: what resumes it, "run" or "sweep".
        verdict: the exit status of its records. One that failed stays so whatever can't be
            written.
        is_latest: whether `latest` is to point to its folder.
        outputs: files to write besides the page, by format.
        open_report: whether the page is opened in a browser.
    """
    page, problems = write_report(recorded, outputs or {})
    if is_latest:
        point_latest(recorded.folder)
        _remove_old(recorded.folder.parent)
    if page is not None:
        problems += _write_index(recorded.folder.parent, new=is_latest)
    if page is not None:
        show.where(page)
    unwritten = report_problems(problems)
    if not recorded.complete:
        folder = display_path(recorded.folder)
        show.console.print(f"resume with: shaderlab {command} --resume {folder}")
        return INTERRUPTED
    if problems:
        return verdict or unwritten
    if open_report and page is not None:
        click.launch(page.resolve().as_uri())
    return verdict


def _remove_old(parent: Path) -> None:
    keep = load_settings(Path()).keep
    count = remove_old_runs(parent, KEEP if keep is None else keep)
    if count:
        what = "an old run" if count == 1 else f"{count} old runs"
        click.echo(f"removed {what} from {parent}/ (keep in [tool.shaderlab])", err=True)


def _write_index(parent: Path, *, new: bool) -> list[ShaderlabError]:
    """Write the list of all runs there, made where it is `new` only; what was wrong with that."""
    from shaderlab.report import html

    try:
        if new or html.is_run_list(parent / html.FILE_NAME):
            html.write_run_list(parent)
    except ShaderlabError as error:
        return [error]
    return []


def write_report(
    recorded: RecordedRun, outputs: Mapping[str, str]
) -> tuple[Path | None, list[ShaderlabError]]:
    """Write the run, its page and its outputs; return the page, and what can't be written."""
    from shaderlab.model import store
    from shaderlab.report import html

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
