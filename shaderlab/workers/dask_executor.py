"""An `Executor` on a running Dask cluster: it sends jobs and receives records and pictures.

A Dask task runs a few jobs. Dask reassigns the tasks of a lost worker, and each record is taken
once, so a scene may run on any worker, and more than once. Where a task has lost several workers,
its jobs are sent once more, each by itself, so that only the one to blame is a crash.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import queue
import uuid
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab.engine.discovery import tree_of
from shaderlab.errors import ShaderlabError
from shaderlab.files import display_path
from shaderlab.model.options import Limits, RunOptions
from shaderlab.model.records import Record

from .dask_bundles import (
    SHIPPED,
    Address,
    Bundle,
    homes,
    identity,
    packed,
    packed_folder,
    shipped_path,
)
from .dask_connection import check_workers, connected, other_version, quiet
from .jobs import About, CaseFacts, Job, failed_record

if TYPE_CHECKING:
    from distributed import Future

PATIENCE_SECONDS = 60.0
TURNS = 16
"""Each of the cluster's threads gets tasks so often, where there are many jobs, lest one waits for
another's last task."""
TOGETHER = 16
"""The most jobs of a task: a task costs the cluster as much as a small case."""
LOOK_SECONDS = 2.0
_RESUME = "finished results are saved: resume with shaderlab run --resume"


class DaskExecutor:
    """Runs jobs on the workers of a Dask scheduler.

    Args:
        address: the scheduler's, such as "tcp://host:8786".
        driver: as in `shaderlab.drivers.open_backend`, on the workers.
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
        self._homes = {what: _shown(folder) for what, folder in homes().items()}
        self._client = connected(address)
        try:
            check_workers(self._client, address)
            from .dask_plugin import DaskPlugin

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
            asked = [
                self._submit("load", *self._remote(some, RunOptions()))
                for some in self._together(jobs)
            ]
            found: list[list[CaseFacts]] = [self._wait_for(future.result) for future in asked]
        facts = {one.file: one for one in itertools.chain(*found)}
        return [facts[str(file)] for file in files]

    def run(self, jobs: Sequence[Job], options: RunOptions) -> Generator[tuple[Job, Record]]:
        """See `Executor`.

        Raises:
            ShaderlabError: the cluster is gone.
        """
        from distributed.scheduler import KilledWorker

        _ = self.about()
        finished: queue.SimpleQueue[object] = queue.SimpleQueue()
        unfinished: dict[object, tuple[Sequence[Job], Future[Any]]] = {}

        def send(some: Sequence[Job]) -> None:
            remote = self._remote(some, options)
            future = self._submit("run", identity(), *remote, retries=1)
            unfinished[future.key] = some, future
            future.add_done_callback(lambda done: finished.put(done.key))

        with self._translating_errors():
            for some in self._together([job for job in jobs if not job.broken]):
                send(some)
            for job in jobs:
                if job.broken:
                    yield job, failed_record(job, job.broken, job.trouble)
            while unfinished:
                key = self._wait_for(lambda seconds: finished.get(timeout=seconds))
                if key not in unfinished:
                    continue  # a task that was run twice is done twice
                some, future = unfinished.pop(key)
                try:
                    result = self._wait_for(future.result)
                except KilledWorker:
                    if len(some) > 1:
                        for job in some:
                            send([job])
                    else:
                        lost = "every Dask worker that ran it was lost"
                        yield some[0], failed_record(some[0], "crash", lost)
                else:
                    yield from self._records(some, options, result)
                finally:
                    future.release()

    def close(self) -> None:
        """See `Executor`. The cluster keeps running."""
        with contextlib.suppress(Exception), quiet():
            # Jobs that still run are abandoned: their processes end with the plugin.
            self._client.unregister_worker_plugin(self._name)
        with contextlib.suppress(Exception), quiet():
            self._client.close()

    def _submit(self, method: str, *arguments: Any, **how: Any) -> Future[Any]:
        """Submit a task that calls a method of a worker's `DaskPlugin`."""
        from .dask_plugin import call

        key = f"{self._name}-{method}-{uuid.uuid4().hex}"
        return self._client.submit(call, self._name, method, *arguments, key=key, **how)

    def _together(self, jobs: Sequence[Job]) -> Iterator[Sequence[Job]]:
        """The jobs by tasks. A task's are of one driver, for which a worker has a process."""
        turns = TURNS * max(sum(self._client.nthreads().values()), 1)
        most = max(1, min(len(jobs) // turns, TOGETHER))
        for _, of_driver in itertools.groupby(jobs, key=lambda job: job.driver):
            rest = list(of_driver)
            while rest:
                some, rest = rest[:most], rest[most:]
                yield some

    def _records(
        self, jobs: Sequence[Job], options: RunOptions, result: Any
    ) -> Iterator[tuple[Job, Record]]:
        """The jobs' records; their files are written here first, so that a record never names a
        file that is not there."""
        from shaderlab.model import store

        if isinstance(result, Mapping):
            raise other_version(self._address, "a worker that came later", result)
        problem = ""
        for folder, files in ((options.folder, result.files), (options.frames, result.frames)):
            if folder is not None:
                problem = problem or write_files(files, folder)
        for number, plain in result.records.items():
            record = store.parse(plain, Record)
            if problem:
                record = replace(record, notices=(*record.notices, problem))
            yield jobs[number], record

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

    def _remote(self, jobs: Sequence[Job], options: RunOptions) -> list[Any]:
        """Jobs as any machine can run them, and after them the bundles they need, on their way."""
        from .dask_plugin import RemoteJobs

        bundles: dict[str, Bundle] = {}
        local_names = dict(self._homes)

        def bundled(bundle: Bundle, folder: Path, name: str) -> Address:
            bundles[bundle.name] = bundle
            local_names[bundle.name] = _shown(folder)
            return Address(bundle.name, name)

        def address(file: str) -> Address:
            shipped = shipped_path(Path(file))
            if shipped is not None:
                return Address(SHIPPED, shipped)
            tree = tree_of(Path(file))
            inside = Path(os.path.abspath(file)).relative_to(tree).as_posix()
            return bundled(self._packed(tree), tree, inside)

        files = {file: address(file) for file in dict.fromkeys(job.file for job in jobs)}
        shaders = tuple(
            (name, bundled(packed({path.name: path.read_bytes()}), path.parent, path.name))
            for name, path in options.shaders.items()
        )
        remote = RemoteJobs(
            options=options, jobs=jobs, files=files, shaders=shaders, local_names=local_names
        )
        return [remote, *map(self._send, bundles.values())]

    def _send(self, bundle: Bundle) -> Any:
        """The bundle as a task, which Dask runs again where the worker that held it is lost."""
        from .dask_plugin import carry

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
