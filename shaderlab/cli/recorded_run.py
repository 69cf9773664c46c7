"""Running a plan with its journal, writing its report, resuming it.

The journal, `records.jsonl`, begins with a line with the plan, then has a line for each record,
written as soon as it is there. A line that was cut short counts as not written.
"""

import contextlib
import datetime
import fcntl
import json
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO

import click

from shaderlab.cli import INTERRUPTED, options as shared
from shaderlab.cli.selecting import find_unused
from shaderlab.cli.showing import Show
from shaderlab.engine.jobs import Executor, Job, package_versions
from shaderlab.engine.settings import load_settings
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import display_path, open_regular, read_regular, refuse_links, write_bytes
from shaderlab.model.options import Limits, RunOptions
from shaderlab.model.records import Record, Run


@dataclass(frozen=True, kw_only=True)
class RunPlan:
    """What was asked for, so that it can be resumed."""

    started: str
    options: RunOptions
    jobs: tuple[Job, ...] = ()


class Journal(contextlib.AbstractContextManager["Journal"]):
    """The file of a run that is going on. A context manager.

    Only one run at a time may write to a folder; the lock goes with the process. Raises UsageError:
    another run is writing there, or it can't be written to. `plan` is what is run; None resumes the
    run that is there. `problem` is why records are no longer written, such as a full disk, or None.
    """

    def __init__(self, folder: Path, plan: RunPlan | None) -> None:
        path = self._path = folder / shared.FILE_NAME
        self._synced = time.monotonic()
        self.problem: ShaderlabError | None = None
        try:
            if path.exists() and path.stat().st_nlink > 1:  # a copy by links is not written to
                write_bytes(path, read_regular(path))
            descriptor = open_regular(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        except OSError as error:
            raise UsageError(f"can't write here: {error.strerror}", file=path) from error
        self._file = open(descriptor, "ab", buffering=0)  # noqa: SIM115
        try:
            _lock(self._file, folder)
            if plan is None:
                whole = path.read_bytes().rfind(b"\n") + 1
                self._file.truncate(whole)  # a line that was cut short
            else:
                for name in ("run.json", "index.html"):  # they must not pass for this run's
                    (folder / name).unlink(missing_ok=True)
                self._file.truncate(0)
                self.add(plan)
        except BaseException:
            self._file.close()
            raise

    def __exit__(self, *_: object) -> None:
        self._sync()
        self._file.close()

    def add(self, value: RunPlan | Record) -> None:
        """Append one line. A full disk sets `problem`: the run goes on, for its verdicts."""
        from shaderlab.model import store  # not before workers get ready: it takes its time

        line = (store.encode(value) + "\n").encode("utf-8", "replace")
        try:
            while line and self.problem is None:
                line = line[self._file.write(line) or 0 :]
            if time.monotonic() > self._synced + SYNC_SECONDS:
                self._sync()
        except OSError as error:
            problem = f"{error.strerror}: records are no longer written here"
            self.problem = ShaderlabError(problem, file=self._path)

    def _sync(self) -> None:
        with contextlib.suppress(OSError):  # what is no disk has nothing to write
            os.fsync(self._file.fileno())
        self._synced = time.monotonic()


SYNC_SECONDS = 1.0
"""How much of a run a power cut may cost. Each sync takes some milliseconds."""


def _lock(file: IO[bytes], folder: Path) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise UsageError(
            "another run is writing to this folder",
            file=folder,
            remedy="give each run a folder with --report, or wait",
        ) from error


def read_journal(folder: Path) -> tuple[RunPlan, list[Record], list[int]]:
    """Return what the journal of a run holds: what was asked for, the records that there are, and
    the numbers of lines that are damaged. Raises UsageError: there is none, or not even its first
    line is whole; ShaderlabError: it was written by another version."""
    from shaderlab.model import store

    path = folder / shared.FILE_NAME
    try:
        with open(open_regular(path), "rb") as file:
            *lines, _ = file.read().split(b"\n")
    except OSError as error:
        missing = isinstance(error, FileNotFoundError | NotADirectoryError)
        said = "there is no run to resume" if missing else f"can't resume this: {error.strerror}"
        raise UsageError(said, file=path, remedy="name the folder of a run") from error
    if not lines:
        raise UsageError("this run never began", file=path, remedy="start it again")
    try:
        first = json.loads(lines[0])
    except (ValueError, RecursionError) as error:
        raise UsageError(
            "the first line, which holds the plan of the run, is damaged",
            file=path,
            line=1,
            remedy="start it again",
        ) from error
    plan: RunPlan = store.parse(first, RunPlan, path)
    records: list[Record] = []
    damaged: list[int] = []
    for number, line in enumerate(lines[1:], 2):
        try:
            records.append(store.parse(json.loads(line), Record))
        except (ValueError, RecursionError, ShaderlabError):
            damaged.append(number)
    return plan, records, damaged


@dataclass(frozen=True)
class RecordedRun:
    """A run, and its folder. It is `complete` unless an interrupt ended it early. `problems` are
    records that could not be written, and files given in a shader's place that no program was made
    of; `records` are those of all drivers, where the run has several."""

    run: Run
    folder: Path
    complete: bool
    problems: tuple[ShaderlabError, ...] = ()
    records: tuple[Record, ...] = ()


def new_plan(jobs: Sequence[Job], options: RunOptions, folder: str | None) -> RunPlan:
    """A plan to run these jobs now, in `folder` or a new one, which is made."""
    made = shared.make_run_folder() if folder is None else shared.make_report_folder(Path(folder))
    now = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    return RunPlan(started=now, options=replace(options, folder=made), jobs=tuple(jobs))


def load_plan(word: str, limits: Limits) -> tuple[RunPlan, list[Record]]:
    """The plan of an earlier run, to be finished with these limits, and the records there are.

    `word` is the run's folder, or "" for the last one that was begun. Raises UsageError: there is
    no such run."""
    if word:
        folder = Path(word)
        shared.mark_named(folder)
    else:
        begun = shared.REPORTS.glob(f"*/{shared.FILE_NAME}")
        if not (runs := sorted(begun, key=lambda path: path.stat().st_mtime)):
            raise UsageError(f"there is no run in {shared.REPORTS}/", remedy="name its folder")
        folder = runs[-1].parent
    refuse_links(folder)
    plan, done, damaged = read_journal(folder)
    for line in damaged:
        place = display_path(folder / shared.FILE_NAME, line)
        click.echo(f"shaderlab: {place}: this record is damaged; its job runs again", err=True)
    frames = plan.options.frames and folder / plan.options.frames.name
    options = replace(plan.options, folder=folder, limits=limits, frames=frames)
    return replace(plan, options=options), done


def run_plan(
    executor: Executor, plan: RunPlan, show: Show, done: Sequence[Record] | None = None
) -> RecordedRun:
    """Run all jobs of the plan, with their records in its order; write each to the journal.

    An interrupt ends it early: what was finished by then is in the journal and in the result.

    `done` has the records of a run that is resumed; their jobs are not run again.
    """
    assert plan.options.folder is not None
    records = {record.key: record for record in done or ()}
    waiting = [job for job in plan.jobs if job.key not in records]
    clock = time.perf_counter()
    with (
        Journal(plan.options.folder, plan if done is None else None) as journal,
        show.progress(len(waiting)) as progress,
        contextlib.suppress(KeyboardInterrupt),
    ):
        results = executor.run(waiting, plan.options)
        for job, record in progress.follow(waiting, results):
            records[job.key] = record
            journal.add(record)
    made = tuple(records[job.key] for job in plan.jobs if job.key in records)
    first = plan.jobs[0].driver if plan.jobs else ""
    run = Run(
        driver=executor.about(),
        versions=package_versions(),
        started=plan.started,
        seconds=time.perf_counter() - clock,
        records=tuple(record for record in made if record.driver_name == first),
        replaced={name: display_path(file) for name, file in plan.options.shaders.items()},
        missing=len(plan.jobs) - len(made),
    )
    problems = [] if journal.problem is None else [journal.problem]
    if not run.missing:
        problems += find_unused(plan.options.shaders, run.records)
    return RecordedRun(run, plan.options.folder, not run.missing, tuple(problems), made)


def finish(
    recorded: RecordedRun, show: Show, *, verdict: int, is_latest: bool, outputs: Mapping[str, str]
) -> int:
    """Write and show where everything is; return the exit status.

    Args:
        recorded, show: the run, and what says where it is.
        verdict: the exit status of its records. One that failed stays so whatever can't be
            written.
        is_latest: whether `latest` is to point to its folder.
        outputs: files to write besides the page, by format.
    """
    page, problems = write_report(recorded, outputs)
    if is_latest:
        shared.point_latest(recorded.folder)
        _remove_old(recorded.folder.parent)
    if page is not None:
        show.where(page)
    unwritten = shared.report_problems(problems)
    if not recorded.complete:
        folder = display_path(recorded.folder)
        show.console.print(f"resume with: shaderlab run --resume {folder}")
        return INTERRUPTED
    return verdict or unwritten


def _remove_old(parent: Path) -> None:
    keep = load_settings(Path()).keep
    count = shared.remove_old_runs(parent, shared.KEEP if keep is None else keep)
    if count:
        what = "an old run" if count == 1 else f"{count} old runs"
        click.echo(f"removed {what} from {parent}/ (keep in [tool.shaderlab])", err=True)


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
    except ShaderlabError as error:  # what took a place meanwhile is no wrong usage
        problems.append(ShaderlabError(error.message, file=error.file, remedy=error.remedy))
    problems += shared.write_outputs(recorded.run, outputs)
    return page, [*problems, *recorded.problems]
