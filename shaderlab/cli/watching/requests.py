"""What watching asks of workers: a verdict, and the files that it depends on."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab.engine.discovery import is_own
from shaderlab.errors import CaseError, ShaderlabError
from shaderlab.functions.evaluation import use_worker
from shaderlab.functions.library import load
from shaderlab.model.options import RunOptions
from shaderlab.mutation.function_tests import RunTestFile
from shaderlab.workers.jobs import CaseFacts, Job

if TYPE_CHECKING:
    from shaderlab.model.records import Record
    from shaderlab.workers.executor import LocalExecutor
    from shaderlab.workers.lab_worker import LabWorker


@dataclass(frozen=True)
class WarmUp:
    """Asks for a call and its judgement, so that what the first of them takes is done before."""

    def perform(self, worker: LabWorker) -> None:
        with use_worker(worker):
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
        """See `shaderlab.workers.jobs.Request`. Raises CaseError."""
        worker.lab(self.options).forget_shaders()
        with _files(worker) as files:
            record = worker.run(self.job, self.options)
        return record, files


@dataclass(frozen=True)
class RunWatchedTests:
    """Asks for the records of a file's tests of GLSL functions, and the files that they read."""

    file: Path

    def perform(self, worker: LabWorker) -> tuple[Sequence[Record], set[Path]]:
        """See `shaderlab.workers.jobs.Request`. Raises UsageError: pytest is not installed."""
        with _files(worker) as files:
            result = RunTestFile(self.file).perform(worker)
        return result.records, files


@contextmanager
def _files(worker: LabWorker) -> Iterator[set[Path]]:
    opened: OpenedFiles = worker.keep("opened files", None, OpenedFiles)
    with opened.noted() as files:
        yield files


class OpenedFiles:
    """Notes the files that this process opens for reading, those that are not there too.

    Python can't take an audit hook back: a process has one of these, and keeps it.
    """

    def __init__(self) -> None:
        self._names: set[str] | None = None
        sys.addaudithook(self._hear)

    @contextmanager
    def noted(self) -> Iterator[set[Path]]:
        """The files of the project that the block reads; filled when it ends."""
        found: set[Path] = set()
        self._names = set()
        try:
            yield found
        finally:
            names, self._names = self._names, None
            found |= {path for path in map(_source, names) if is_own(path)}

    def _hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        if event != "open" or self._names is None:
            return
        name, _, flags = arguments
        if isinstance(name, str | bytes) and flags & os.O_ACCMODE == os.O_RDONLY:
            self._names.add(os.fsdecode(name))


def _source(name: str) -> Path:
    """A file's path; that of the source where Python reads what it has compiled."""
    if name.endswith(".pyc"):
        with contextlib.suppress(ValueError, NotImplementedError):
            name = importlib.util.source_from_cache(name)
    return Path(os.path.abspath(name))
