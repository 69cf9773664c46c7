"""What `shaderlab run` does between reading its options and writing the report."""

from __future__ import annotations

import contextlib
import datetime
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.cli.files import new_run_folder, report_folder, uses_stdout
from shaderlab.cli.replacing import named, parsed, unread
from shaderlab.cli.requesting import Request, place_of
from shaderlab.cli.selecting import choose
from shaderlab.cli.showing import Show
from shaderlab.errors import UsageError
from shaderlab.records import Record, Run
from shaderlab.report.html import load_libraries
from shaderlab.running import Setup, Team
from shaderlab.running.drivers import disagreements, results
from shaderlab.running.journal import Heading, Journal, read

if TYPE_CHECKING:
    from shaderlab.running import Job


@dataclass(frozen=True)
class Performed:
    """A run, and whether all of it was done; `problem` is what could not be written, `unread` the
    errors for files given in a shader's place that nothing read."""

    run: Run
    folder: Path
    complete: bool
    problem: str = ""
    unread: tuple[UsageError, ...] = ()


def finish(request: Request, team: Team) -> tuple[Performed, Show]:
    """Do what was asked for, or the rest of it. Raises UsageError, CaseError."""
    load_libraries()
    show = Show(to_stderr=uses_stdout(request.outputs))
    done: list[Record] = []
    if request.resume is None:
        heading, folder = _begun(request, team)
    else:
        if request.targets or request.every or request.variants or request.folder:
            raise UsageError("--resume runs what was asked for then: name nothing else")
        folder = place_of(request.resume)
        heading, done = read(folder)
        heading = replace(heading, setup=replace(heading.setup, folder=folder))
    with Journal(folder, heading if request.resume is None else None) as journal:
        if not request.rivals():
            return perform(team, heading, journal, done, show), show
        with tempfile.TemporaryDirectory(prefix="shaderlab-") as frames:
            return _compared(request, team, heading, journal, Path(frames), show), show


def _compared(
    request: Request, team: Team, heading: Heading, journal: Journal, frames: Path, show: Show
) -> Performed:
    """Run everything on each driver; the first one's run gets what sets the others apart."""
    names = request.rivals()
    setup = replace(heading.setup, frames=frames / names[0])
    first = perform(team, replace(heading, setup=setup), journal, (), show)
    run, complete = first.run, first.complete
    found = list(results(names[0], run.driver["renderer"], run.records))
    for name in names[1:] if complete else ():
        other = request.on(name)
        try:
            setup = replace(heading.setup, driver=name, pictures=False, frames=frames / name)
            records: list[Record] = []
            with show.progress(len(heading.jobs)) as progress:
                for record in other.run(heading.jobs, setup, lambda job, record: None):
                    progress.ends(record)
                    records.append(record)
            found += results(name, other.about().driver["renderer"], records)
        finally:
            other.close()
    kept = {name: frames / name for name in names}
    apart = tuple(disagreements(heading.jobs, kept)) if complete else ()
    return replace(first, run=replace(run, drivers=tuple(found), disagreements=apart))


def perform(
    team: Team, heading: Heading, journal: Journal, done: Sequence[Record], show: Show
) -> Performed:
    """Run all jobs of `heading` but those that are `done`, and gather everything in their order.

    An interrupt ends it early: what was finished by then is in the journal and in the result.
    """
    clock = time.perf_counter()
    records = {(record.id, record.variant): record for record in done}
    rest = [job for job in heading.jobs if job.key not in records]

    def heard(job: Job, record: Record) -> None:
        records[job.key] = record
        journal.add(record)

    with show.progress(len(rest)) as progress, contextlib.suppress(KeyboardInterrupt):
        results = team.run(rest, heading.setup, heard)
        for job in rest:
            progress.starts(job.id, job.variant)
            progress.ends(next(results))
    ordered = tuple(records[job.key] for job in heading.jobs if job.key in records)
    about = team.about()
    run = Run(
        driver=about.driver,
        versions=about.versions,
        started=heading.started,
        seconds=time.perf_counter() - clock,
        records=ordered,
    )
    assert heading.setup.folder is not None
    complete = len(ordered) == len(heading.jobs)
    ignored = unread(heading.setup.shaders, ordered) if complete else []
    return Performed(run, heading.setup.folder, complete, journal.problem, tuple(ignored))


def _begun(request: Request, team: Team) -> tuple[Heading, Path]:
    """What is to be run, and the folder for it, made now that there is something to run."""
    replacements = parsed(request.shaders)
    jobs = choose(request.targets, request.every, request.variants, team.load)
    driver = request.rivals()[0] if request.drivers else request.driver
    folder = new_run_folder() if request.folder is None else report_folder(Path(request.folder))
    setup = Setup(
        size=request.size,
        folder=folder,
        pictures=request.pictures,
        shaders=named(replacements, jobs),
        driver=driver,
    )
    now = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    return Heading(started=now, setup=setup, jobs=tuple(jobs)), folder
