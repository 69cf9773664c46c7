"""Those who run jobs: a `Crew` of worker processes, or one `Solo` in this process.

Both are a `Team`: they load case files, say what driver they have, and give a record for each
job, whatever becomes of it.
"""

from __future__ import annotations

import contextlib
import itertools
import shutil
import tempfile
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from shaderlab import packages
from shaderlab.errors import CaseError
from shaderlab.running.jobs import (
    About,
    CaseFacts,
    Describe,
    Job,
    Limits,
    Load,
    Perform,
    Setup,
)
from shaderlab.running.sizing import loads, suitable
from shaderlab.running.steps import Steps
from shaderlab.workers import Limits as PoolLimits
from shaderlab.workers import Outcome, Pool

# Workers are started before anything that they do not need is imported here.
if TYPE_CHECKING:
    from shaderlab.evaluation import Lab
    from shaderlab.records import Record

    Heard = Callable[[Job, Record], None]


class Team(Protocol):
    """Whoever runs jobs. Give it back with `close`."""

    def about(self) -> About:
        """The driver and the packages that jobs run on."""

    def load(self, files: Sequence[Path]) -> list[CaseFacts]:
        """What is in each case file; one that is wrong costs nothing but itself."""

    def run(self, jobs: Sequence[Job], setup: Setup, heard: Heard) -> Generator[Record]:
        """Each job's record, in the jobs' order. `heard` gets each as soon as it is there, which
        may be in another order, and from another thread. Close it, and no more jobs are begun."""

    def close(self) -> None:
        """End everything, whatever it is doing."""


class Crew:
    """Worker processes. They start at once, so that they get ready while others get ready too.

    Args:
        driver: as in `shaderlab.backends.open_backend`.
        limits: what one scene may take.
        workers: how many there are; None for as many as what is asked for is worth.
        folder: their working directory, by default this process's.
        early: whether one is asked for its driver at once, and not when that is first needed.
    """

    def __init__(
        self,
        driver: str | None = None,
        limits: Limits | None = None,
        workers: int | None = 1,
        folder: Path | None = None,
        early: bool = True,
    ) -> None:
        self._driver = driver
        self._limits = limits = limits or Limits()
        self._folder = Path(tempfile.mkdtemp(prefix="shaderlab-"))
        self._pool = Pool(
            "shaderlab.running.working:answer",
            limits=PoolLimits(seconds=limits.seconds, memory=int(limits.gigabytes * (1 << 30))),
            jobs=1 if workers is None else workers,
            batch=1,
            folder=folder,
            warm="shaderlab.glsl.engines:warm_up",
        )
        self._sized = workers is not None
        self._thread = ThreadPoolExecutor(1)
        self._runs = itertools.count()
        self._early = early
        if early:
            self._pool.start()
            _ = self._asked

    def about(self) -> About:
        """See `Team`. Where the driver takes the process down, "renderer" is "none"."""
        return self._asked.result()

    @cached_property
    def _asked(self) -> Future[About]:
        return self._thread.submit(self._ask_about)

    def load(self, files: Sequence[Path]) -> list[CaseFacts]:
        """See `Team`."""
        self._widen(len(files))  # each has one variant at least
        outcomes = self._pool.each([Load(file) for file in files], batch=loads(len(files)))
        return [_facts(file, outcome) for file, outcome in zip(files, outcomes, strict=True)]

    def run(self, jobs: Sequence[Job], setup: Setup, heard: Heard) -> Generator[Record]:
        """See `Team`."""
        from shaderlab.running.lost import lost

        if not self._early:
            self.about()  # now, while workers are free: a lost job's record names the driver
        # Not the file of an earlier run, which may have been left with jobs that still write to it.
        steps = Steps.create(self._folder / f"steps-{next(self._runs)}", len(jobs))
        sound = [(slot, job) for slot, job in enumerate(jobs) if not job.broken]
        questions = [Perform(setup, job, steps.path, slot) for slot, job in sound]
        self._widen(len(questions))

        def record_of(outcome: Outcome) -> Record:
            question: Perform = outcome.item
            if outcome.status == "done":
                record: Record = outcome.result
                return record
            return self._lost(question.job, outcome, steps.read(question.slot))

        def told(outcome: Outcome) -> None:
            heard(outcome.item.job, record_of(outcome))

        with (
            steps.removed_at_end(),
            contextlib.closing(self._pool.each(questions, told)) as outcomes,
        ):
            for job in jobs:
                if job.broken:
                    record = lost(job, job.broken, job.trouble)
                    heard(job, record)
                    yield record
                else:
                    yield record_of(next(outcomes))

    def close(self) -> None:
        """See `Team`."""
        self._pool.close()
        self._thread.shutdown(wait=True, cancel_futures=True)
        shutil.rmtree(self._folder, ignore_errors=True)

    def _widen(self, variants: int) -> None:
        if not self._sized:
            self._pool.widen(suitable(variants))

    def _ask_about(self) -> About:
        versions = packages.versions()  # a worker's are the same, and it has enough to import
        (outcome,) = self._pool.each([Describe(self._driver)])
        if outcome.status == "done":
            about: About = outcome.result
            return replace(about, versions=versions)
        said = str(outcome.result) if outcome.status == "error" else outcome.message
        return About(driver={"renderer": "none", "vendor": "", "version": said, "glsl": ""})

    def _lost(self, job: Job, outcome: Outcome, step: str) -> Record:
        from shaderlab.running.lost import lost

        message = str(outcome.result) if outcome.status == "error" else outcome.message
        driver = self.about().driver.get("renderer", "")
        seconds = self._limits.seconds if outcome.status == "timeout" else 0.0
        return lost(job, outcome.status, message, step=step, driver=driver, seconds=seconds)


class Solo:
    """Runs jobs in this very process: nothing is isolated, and debuggers work."""

    def __init__(self, driver: str | None = None) -> None:
        self._setup = Setup(driver=driver)
        self._open: Lab | None = None

    def about(self) -> About:
        """See `Team`."""
        lab = self._lab()
        return About(driver=dict(lab.driver), versions=dict(lab.versions))

    def load(self, files: Sequence[Path]) -> list[CaseFacts]:
        """See `Team`."""
        from shaderlab.running.working import facts

        found = []
        for file in files:
            try:
                found.append(facts(file))
            except CaseError as error:
                found.append(_wrong(file, "error", error))
        return found

    def run(self, jobs: Sequence[Job], setup: Setup, heard: Heard) -> Generator[Record]:
        """See `Team`."""
        from shaderlab.running.lost import lost
        from shaderlab.running.working import perform

        self._setup = setup
        for job in jobs:
            if job.broken:
                record = lost(job, job.broken, job.trouble)
            else:
                try:
                    record = perform(self._lab(), setup, job)
                except CaseError as error:
                    record = lost(job, "error", str(error))
            heard(job, record)
            yield record

    def close(self) -> None:
        """See `Team`."""
        if self._open is not None:
            self._open.close()

    def _lab(self) -> Lab:
        from shaderlab import evaluation
        from shaderlab.running.working import options_of

        if self._open is None:
            self._open = evaluation.Lab(options_of(self._setup))
        return self._open


def _facts(file: Path, outcome: Outcome) -> CaseFacts:
    if outcome.status == "done":
        found: CaseFacts = outcome.result
        return found
    if isinstance(outcome.result, CaseError):
        return _wrong(file, outcome.status, outcome.result)
    said = outcome.message or str(outcome.result)
    return _wrong(file, outcome.status, CaseError(f"importing the case file: {said}", file=file))


def _wrong(file: Path, status: str, error: CaseError) -> CaseFacts:
    return CaseFacts(file=str(file), id=file.stem.replace("_", "-"), error=error, status=status)
