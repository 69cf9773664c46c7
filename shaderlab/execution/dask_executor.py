"""An `Executor` on a running Dask cluster: it sends jobs and receives records and pictures.

Each job is one Dask task. Dask reassigns the tasks of a lost worker, and each record is taken once,
so a scene may run on any worker, and more than once.
"""

from __future__ import annotations

import contextlib
import os
import queue
import uuid
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab.discovery import tree_of
from shaderlab.errors import ShaderlabError
from shaderlab.execution.dask_bundles import (
    SHIPPED,
    Address,
    Bundle,
    homes,
    identity,
    packed,
    packed_folder,
    shipped_path,
)
from shaderlab.execution.dask_connection import check_workers, connected, other_version, quiet
from shaderlab.execution.jobs import About, CaseFacts, Job, failed_record
from shaderlab.files import display_path
from shaderlab.options import Limits, RunOptions
from shaderlab.records import Record

if TYPE_CHECKING:
    from distributed import Future

PATIENCE_SECONDS = 60.0
LOOK_SECONDS = 2.0
_RESUME = "finished results are saved: resume with shaderlab run --resume"


class DaskExecutor:
    """Runs jobs on the workers of a Dask scheduler.

    Args:
        address: the scheduler's, such as "tcp://host:8786".
        driver: as in `shaderlab.backends.open_backend`, on the workers.
        limits: of each job.
        patience: seconds to wait during a run while the cluster has no workers.

    Raises:
        UsageError: Dask is not installed here, no scheduler answers, it has no workers, or they
            have other versions than this machine.
    """

    def __init__(
        self,
        address: str,
        driver: str | None = None,
        limits: Limits | None = None,
        patience: float = PATIENCE_SECONDS,
    ) -> None:
        self._address = address
        self._patience = patience
        self._name = f"shaderlab-{uuid.uuid4().hex[:12]}"
        self._sent: dict[str, Any] = {}  # bundles as Dask's tasks, by the bundle's name
        self._packed = cache(packed_folder)
        self._client = connected(address)
        try:
            check_workers(self._client, address)
            from shaderlab.execution.dask_plugin import DaskPlugin

            self._client.register_plugin(DaskPlugin(self._name, driver, limits or Limits()))
        except BaseException:
            self._client.close()
            raise

    def about(self) -> About:
        """See `Executor`: those of the first worker that answers."""
        return self._about

    @cached_property
    def _about(self) -> About:
        with self._translating_errors():
            about: About = self._wait_for(self._submit("about").result)
            return about

    def load(self, files: Sequence[Path]) -> list[CaseFacts]:
        """See `Executor`. Files are imported by workers, never here."""
        jobs = [Job(file=str(file), id=file.stem, variant="") for file in files]
        with self._translating_errors():
            asked = [self._submit("load", *self._remote(job, RunOptions())) for job in jobs]
            found: list[CaseFacts] = [self._wait_for(future.result) for future in asked]
        return [replace(facts, file=str(f)) for f, facts in zip(files, found, strict=True)]

    def run(self, jobs: Sequence[Job], options: RunOptions) -> Generator[tuple[Job, Record]]:
        """See `Executor`.

        Raises:
            ShaderlabError: the cluster is gone.
        """
        _ = self.about()
        finished: queue.SimpleQueue[int] = queue.SimpleQueue()
        futures: dict[int, Future[Any]] = {}
        with self._translating_errors():
            for number, job in enumerate(jobs):
                if not job.broken:
                    remote = self._remote(job, options)
                    futures[number] = self._submit("run", identity(), *remote, retries=1)
                    futures[number].add_done_callback(lambda _, n=number: finished.put(n))
            for job in jobs:
                if job.broken:
                    yield job, failed_record(job, job.broken, job.trouble)
            while futures:
                number = self._wait_for(lambda seconds: finished.get(timeout=seconds))
                if number in futures:  # a task that was run twice is done twice
                    record = self._record(jobs[number], options, futures.pop(number))
                    yield jobs[number], record

    def close(self) -> None:
        """See `Executor`. The cluster keeps running."""
        with contextlib.suppress(Exception), quiet():
            # Jobs that still run are abandoned: their processes end with the plugin.
            self._client.unregister_worker_plugin(self._name)
        with contextlib.suppress(Exception), quiet():
            self._client.close()

    def _submit(self, method: str, *arguments: Any, **how: Any) -> Future[Any]:
        """Submit a task that calls a method of a worker's `DaskPlugin`."""
        from shaderlab.execution.dask_plugin import call

        key = f"{self._name}-{method}-{uuid.uuid4().hex}"
        return self._client.submit(call, self._name, method, *arguments, key=key, **how)

    def _record(self, job: Job, options: RunOptions, future: Future[Any]) -> Record:
        """A job's record; its files are written here first, so that a record never names a file
        that is not there."""
        from distributed.scheduler import KilledWorker

        from shaderlab.report import store

        try:
            result = self._wait_for(future.result)
        except KilledWorker:
            return failed_record(job, "crash", "every Dask worker that ran it was lost")
        finally:
            future.release()
        if isinstance(result, Mapping):
            raise other_version(self._address, "a worker that came later", result)
        record = store.parse(result.record, Record)
        problem = ""
        for folder, files in ((options.folder, result.files), (options.frames, result.frames)):
            if folder is not None:
                problem = problem or write_files(files, folder)
        if problem:
            record = replace(record, notices=(*record.notices, problem))
        return record

    def _wait_for(self, get: Callable[[float], Any]) -> Any:
        """The result of `get`, retried when it times out, while the cluster has workers."""
        without = 0.0
        while True:
            try:
                return get(LOOK_SECONDS)
            except (TimeoutError, queue.Empty):
                if self._client.status not in ("running", "connecting"):
                    raise self._gone("the scheduler is gone") from None
                without = 0.0 if self._client.nthreads() else without + LOOK_SECONDS
                if without >= self._patience:
                    raise self._gone("there are no workers left") from None

    @contextlib.contextmanager
    def _translating_errors(self) -> Iterator[None]:
        """Raise errors of the connection as errors of the lab."""
        from distributed.comm.core import CommClosedError

        try:
            with quiet():
                yield
        except (CommClosedError, OSError, CancelledError) as error:
            if isinstance(error, OSError) and not isinstance(error, CommClosedError | TimeoutError):
                raise
            raise self._gone("the scheduler is gone") from error

    def _gone(self, how: str) -> ShaderlabError:
        return ShaderlabError(f"Dask cluster {self._address}: {how}", remedy=_RESUME)

    def _remote(self, job: Job, options: RunOptions) -> list[Any]:
        """A job as any machine can run it, and after it the bundles it needs, on their way."""
        from shaderlab.execution.dask_plugin import RemoteJob

        bundles: list[Bundle] = []
        local_names = {what: _shown(folder) for what, folder in homes().items()}

        def bundled(bundle: Bundle, folder: Path, name: str) -> Address:
            bundles.append(bundle)
            local_names[bundle.name] = _shown(folder)
            return Address(bundle.name, name)

        file = Path(job.file)
        shipped = shipped_path(file)
        if shipped is not None:
            address = Address(SHIPPED, shipped)
        else:
            tree = tree_of(file)
            inside = Path(os.path.abspath(file)).relative_to(tree).as_posix()
            address = bundled(self._packed(tree), tree, inside)
        shaders = tuple(
            (name, bundled(packed({path.name: path.read_bytes()}), path.parent, path.name))
            for name, path in options.shaders.items()
        )
        remote = RemoteJob(
            options=options, job=job, file=address, shaders=shaders, local_names=local_names
        )
        return [remote, *map(self._send, bundles)]

    def _send(self, bundle: Bundle) -> Any:
        """The bundle as a task, which Dask runs again where the worker that held it is lost."""
        from shaderlab.execution.dask_plugin import carry

        if bundle.name not in self._sent:
            key = f"{self._name}-{bundle.name}"
            self._sent[bundle.name] = self._client.submit(carry, bundle, key=key)
        return self._sent[bundle.name]


def _shown(folder: Path) -> str:
    """A folder as it begins the paths of files in it, as records name them."""
    return display_path(folder / "x")[:-1]


def write_files(files: Mapping[str, bytes], folder: Path) -> str:
    """Write what was sent into the run's folder; returns what went wrong, or ""."""
    root = folder.resolve()
    try:
        for relative, data in files.items():
            path = (root / relative).resolve()
            if not path.is_relative_to(root):
                return f"a worker sent a file from outside its folder: {relative}"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
    except OSError as error:
        return f"can't write a picture ({error.strerror or error})"
    return ""
