"""What watching asks of workers: a verdict, and the files that it depends on."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.errors import CaseError, ShaderlabError
from shaderlab.execution.jobs import CaseFacts, Job
from shaderlab.function_tests.running import RunTestFile
from shaderlab.functions.calling import called_in
from shaderlab.functions.library import load
from shaderlab.lazy_dataclass import dataclass
from shaderlab.options import RunOptions
from shaderlab.watching.opened import OpenedFiles

if TYPE_CHECKING:
    from shaderlab.execution.executor import LocalExecutor
    from shaderlab.execution.lab_worker import LabWorker
    from shaderlab.records import Record


@dataclass(frozen=True)
class WarmUp:
    """Asks for a call and its judgement, so that what the first of them takes is done before."""

    def perform(self, worker: LabWorker) -> None:
        """See `shaderlab.execution.jobs.Request`."""
        with called_in(worker):
            same = load("float same(float x) { return x; }").same
            same.check(lambda x: x, [1.0, 2.0])


def warm_up(executor: LocalExecutor) -> None:
    """Have an executor's worker get ready, in the background."""

    def perform() -> None:
        with contextlib.suppress(ShaderlabError):  # the next request reports it
            list(executor.perform([WarmUp()]))

    threading.Thread(target=perform, daemon=True).start()


@dataclass(frozen=True)
class LoadWatched:
    """Asks for a file's `CaseFacts`, or why there are none, and the files that it reads."""

    file: Path

    def perform(self, worker: LabWorker) -> tuple[CaseFacts | CaseError, set[Path]]:
        """See `shaderlab.execution.jobs.Request`."""
        with _files(worker) as files:
            try:
                found: CaseFacts | CaseError = worker.facts(self.file)
            except CaseError as error:
                found = error
        return found, files


@dataclass(frozen=True)
class RunWatched:
    """Asks for a job's `Record`, of its shaders as they are now, and the files that it reads."""

    job: Job
    options: RunOptions

    def perform(self, worker: LabWorker) -> tuple[Record, set[Path]]:
        """See `shaderlab.execution.jobs.Request`. Raises CaseError."""
        worker.lab(self.options).forget_shaders()
        with _files(worker) as files:
            record = worker.run(self.job, self.options)
        return record, files


@dataclass(frozen=True)
class RunWatchedTests:
    """Asks for the records of a file's tests of GLSL functions, and the files that they read."""

    file: Path

    def perform(self, worker: LabWorker) -> tuple[Sequence[Record], set[Path]]:
        """See `shaderlab.execution.jobs.Request`. Raises UsageError: pytest is not installed."""
        with _files(worker) as files:
            result = RunTestFile(self.file).perform(worker)
        return result.records, files


@contextmanager
def _files(worker: LabWorker) -> Iterator[set[Path]]:
    opened: OpenedFiles = worker.keep("opened files", None, OpenedFiles)
    with opened.noted() as files:
        yield files
