"""Executors turn jobs into records: a `ProcessExecutor` in worker processes, an
`InProcessExecutor` in this one, a `shaderlab.workers.dask_executor.DaskExecutor` on a cluster.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Generator, Hashable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from shaderlab.engine import package_versions
from shaderlab.errors import CaseError
from shaderlab.model.options import Limits, RunOptions

from .jobs import About, CaseFacts, DescribeDriver, Job, LoadCase, RunJob, failed_record
from .pool import ItemResult, WorkerPool
from .sizing import loads, suitable

# Workers are started before anything that they do not need is imported here.
if TYPE_CHECKING:
    from shaderlab.model.records import Record

    from .lab_worker import LabWorker

LAB_WORK = "shaderlab.workers.lab_worker:LabWorker"
"""What workers that judge scenes call, as of `shaderlab.workers.pool.WorkerPool`."""
Key = Callable[[Any], Hashable]


class Executor(Protocol):
    """Turns jobs into records. Give it back with `close`."""

    def about(self) -> About:
        """The driver and the packages that jobs run on."""

    def load(self, files: Sequence[Path]) -> list[CaseFacts]:
        """What is in each case file; one that is wrong costs nothing but itself."""

    def run(self, jobs: Sequence[Job], options: RunOptions) -> Generator[tuple[Job, Record]]:
        """The jobs with their records, as they complete. Every job gets a record, also one whose
        process dies. Close the generator, and no more jobs are begun.

        Raises:
            ShaderlabError: no worker can be started at all.
        """

    def close(self) -> None:
        """End everything, whatever it is doing."""


class LocalExecutor(Executor):
    """An `Executor` on this machine, which also performs the requests of other rooms."""

    limits = Limits()
    """Of each job."""

    def perform(
        self, requests: Iterable[Any], *, batch: int = 1, key: Key | None = None
    ) -> Generator[ItemResult]:
        """The results of requests as they complete; see `WorkerPool.run`."""
        raise NotImplementedError

    def load(self, files: Sequence[Path]) -> list[CaseFacts]:
        results = self.perform([LoadCase(file) for file in files], batch=loads(len(files)))
        found = {result.number: _facts(files[result.number], result) for result in results}
        return [found[number] for number in range(len(files))]

    def run(self, jobs: Sequence[Job], options: RunOptions) -> Generator[tuple[Job, Record]]:
        for job in jobs:
            if job.broken:
                yield job, failed_record(job, job.broken, job.trouble)
        requests = [RunJob(job, options) for job in jobs if not job.broken]
        # Of several drivers each has processes of its own: a worker stays with one while it can.
        key = (lambda request: request.job.driver) if any(job.driver for job in jobs) else None
        with contextlib.closing(self.perform(requests, key=key)) as results:
            for result in results:
                yield result.item.job, self.record_of(result)

    def record_of(self, result: ItemResult) -> Record:
        """The record of a request with a `job`, also of one that came to no end."""
        if result.status == "done":
            record: Record = result.value
            return record
        return failed_record(
            result.item.job,
            result.status,
            error_text(result),
            step=result.step,
            driver=self._driver_of(result.item.job) if result.status != "error" else "",
            seconds=self.limits.seconds if result.status == "timeout" else 0.0,
        )

    def _driver_of(self, job: Job) -> str:
        return job.driver or self.about().driver.get("renderer", "")


class ProcessExecutor(LocalExecutor):
    """Runs jobs in worker processes. The first one starts at once, so that it gets ready while
    the caller does.

    Args:
        driver: as in `shaderlab.drivers.open_backend`.
        limits: of each job.
        workers: how many there are; None for as many as the jobs are worth.
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
        self.limits = limits or Limits()
        self._pool = WorkerPool(
            LAB_WORK,
            limits=self.limits,
            jobs=1 if workers is None else workers,
            batch=1,
            folder=folder,
        )
        self._workers = workers
        self._thread = ThreadPoolExecutor(1)
        self._early = early
        if early:
            self._pool.start()
            _ = self._asked

    def about(self) -> About:
        """See `Executor`. Where the driver takes the process down, "renderer" is "none"."""
        return self._asked.result()

    def run(self, jobs: Sequence[Job], options: RunOptions) -> Generator[tuple[Job, Record]]:
        if not self._early:
            self.about()  # now, while workers are free: a failed job's record names the driver
        yield from super().run(jobs, options)

    def perform(
        self, requests: Iterable[Any], *, batch: int = 1, key: Key | None = None
    ) -> Generator[ItemResult]:
        requests = list(requests)
        if self._workers is None:
            self._pool.widen(suitable(len(requests)))
        yield from self._pool.run(requests, batch, key)

    def close(self) -> None:
        self._pool.close()
        self._thread.shutdown(wait=True, cancel_futures=True)

    @cached_property
    def _asked(self) -> Future[About]:
        return self._thread.submit(self._ask_about)

    def _ask_about(self) -> About:
        versions = package_versions()  # a worker's are the same, and it has enough to import
        (result,) = self._pool.run([DescribeDriver(self._driver)])
        if result.status == "done":
            found: About = result.value
            return replace(found, versions=versions)
        said = error_text(result)
        return About(driver={"renderer": "none", "vendor": "", "version": said, "glsl": ""})


class InProcessExecutor(LocalExecutor):
    """Runs jobs in this very process: nothing is isolated or limited, and debuggers work.

    Args:
        driver: as in `shaderlab.drivers.open_backend`.
        worker: performs the requests; by default one of its own.
    """

    def __init__(self, driver: str | None = None, worker: LabWorker | None = None) -> None:
        self._driver = driver
        self._given = worker

    @cached_property
    def _worker(self) -> LabWorker:
        from .lab_worker import LabWorker

        return self._given or LabWorker()

    def about(self) -> About:
        about = DescribeDriver(self._driver).perform(self._worker)
        return replace(about, versions=package_versions())

    def perform(
        self, requests: Iterable[Any], *, batch: int = 1, key: Key | None = None
    ) -> Generator[ItemResult]:
        """See `LocalExecutor`; in the order of the requests."""
        for number, request in enumerate(requests):
            began = time.monotonic()
            try:
                value = request.perform(self._worker)
            except Exception as error:
                yield ItemResult(number, request, "error", error)
            else:
                yield ItemResult(number, request, "done", value, seconds=time.monotonic() - began)

    def close(self) -> None:
        if "_worker" in self.__dict__:
            self._worker.close()


def error_text(result: ItemResult) -> str:
    """How a request failed; while debugging, with the traceback."""
    if result.status != "error":
        return result.message
    return "\n".join([str(result.value), *getattr(result.value, "__notes__", ())])


def _facts(file: Path, result: ItemResult) -> CaseFacts:
    if result.status == "done":
        found: CaseFacts = result.value
        return found
    error = result.value
    if not isinstance(error, CaseError):
        error = CaseError(f"importing the case file: {error_text(result)}", file=file)
    return CaseFacts(
        file=str(file), id=file.stem.replace("_", "-"), error=error, status=result.status
    )
