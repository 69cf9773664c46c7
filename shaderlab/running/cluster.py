"""A `Team` on a Dask cluster that is there already: jobs go out, records and pictures come back.

Each job is a task of its own. Dask gives the tasks of a worker that is lost to others, and each
record is taken once, so it does not matter where or how often its scene was run.
"""

from __future__ import annotations

import contextlib
import os
import queue
import uuid
from collections.abc import Generator, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab.discovery import tree_of
from shaderlab.errors import ShaderlabError
from shaderlab.files import display_path
from shaderlab.records import Record
from shaderlab.running.jobs import About, CaseFacts, Job, Limits, Setup
from shaderlab.running.joining import check_workers, connected, other_version, quiet
from shaderlab.running.lost import lost
from shaderlab.running.parcels import (
    SHIPPED,
    Address,
    Parcel,
    homes,
    identity,
    packed,
    packed_folder,
    shipped_path,
)

if TYPE_CHECKING:
    from distributed import Future

    from shaderlab.running.crew import Heard
    from shaderlab.running.station import Errand

PATIENCE_SECONDS = 60.0
_LOOK_SECONDS = 2.0
_GO_ON = "what was finished is kept: go on with shaderlab run --resume"


class Cluster:
    """Runs jobs on the workers of a Dask scheduler.

    Args:
        address: the scheduler's, such as "tcp://host:8786".
        driver: as in `shaderlab.backends.open_backend`, on the workers.
        limits: what one scene may take.
        patience: seconds that a cluster may be without any worker in the middle of a run.

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
        self._parcels: dict[str, Any] = {}  # what has been sent, by the parcel's name
        self._folders: dict[Path, Parcel] = {}
        self._client = connected(address)
        try:
            check_workers(self._client, address)
            from shaderlab.running.station import Station

            self._client.register_plugin(Station(self._name, driver, limits or Limits()))
        except BaseException:
            self._client.close()
            raise

    def about(self) -> About:
        """See `Team`: one of the workers, whichever answers."""
        return self._about

    @cached_property
    def _about(self) -> About:
        from shaderlab.running import station

        with self._watched():
            future = self._client.submit(station.describe, self._name, key=f"{self._name}-about")
            about: About = self._wait(future)
            return about

    def load(self, files: Sequence[Path]) -> list[CaseFacts]:
        """See `Team`. Files are imported by workers, never here."""
        from shaderlab.running import station

        with self._watched():
            asked = []
            for number, file in enumerate(files):
                job = Job(file=str(file), id=file.stem, variant="")
                errand, sent = self._errand(job, Setup())
                key = f"{self._name}-load-{number}-{uuid.uuid4().hex[:8]}"
                asked.append(self._client.submit(station.load, self._name, errand, *sent, key=key))
            found: list[CaseFacts] = [self._wait(future) for future in asked]
        return [replace(facts, file=str(f)) for f, facts in zip(files, found, strict=True)]

    def run(self, jobs: Sequence[Job], setup: Setup, heard: Heard) -> Generator[Record]:
        """See `Team`.

        Raises:
            ShaderlabError: the cluster is gone.
        """
        from shaderlab.running import station

        _ = self.about()
        finished: queue.SimpleQueue[int] = queue.SimpleQueue()
        futures: dict[int, Future[Any]] = {}
        done: dict[int, Record] = {}
        with self._watched():
            for number, job in enumerate(jobs):
                if job.broken:
                    done[number] = lost(job, job.broken, job.trouble)
                    heard(job, done[number])
                    continue
                errand, sent = self._errand(job, setup)
                key = f"{self._name}-{uuid.uuid4().hex[:8]}-{number}"
                futures[number] = self._client.submit(
                    station.perform, self._name, identity(), errand, *sent, key=key, retries=1
                )
                futures[number].add_done_callback(lambda _, n=number: finished.put(n))
            for number in range(len(jobs)):
                while number not in done:
                    ready = self._next(finished)
                    if ready in futures:  # a task that was run twice says twice that it is done
                        record = self._record(jobs[ready], setup, futures.pop(ready))
                        done[ready] = record
                        heard(jobs[ready], record)
                yield done.pop(number)

    def close(self) -> None:
        """See `Team`. The cluster itself goes on."""
        with contextlib.suppress(Exception), quiet():
            # What still runs is given up: its processes end with the station.
            self._client.unregister_worker_plugin(self._name)
        with contextlib.suppress(Exception), quiet():
            self._client.close()

    def _record(self, job: Job, setup: Setup, future: Future[Any]) -> Record:
        """A job's record; its files are written here first, so that a record never names a file
        that is not there."""
        from distributed.scheduler import KilledWorker

        from shaderlab.report import store

        try:
            delivery = self._wait(future)
        except KilledWorker:
            return lost(job, "crash", "every Dask worker that ran it was lost")
        finally:
            future.release()
        if isinstance(delivery, Mapping):
            raise other_version(self._address, "a worker that came later", delivery)
        record = store.parse(delivery.record, Record)
        problem = ""
        for folder, files in ((setup.folder, delivery.files), (setup.frames, delivery.frames)):
            if folder is not None:
                problem = problem or _keep(files, folder)
        if problem:
            record = replace(record, notices=(*record.notices, problem))
        return record

    def _next(self, finished: queue.SimpleQueue[int]) -> int:
        """The number of a task that has come to its end."""
        without = 0.0
        while True:
            try:
                return finished.get(timeout=_LOOK_SECONDS)
            except queue.Empty:
                if self._client.status not in ("running", "connecting"):
                    raise self._gone("the scheduler is gone") from None
                without = 0.0 if self._client.nthreads() else without + _LOOK_SECONDS
                if without >= self._patience:
                    raise self._gone("there are no workers left") from None

    def _wait(self, future: Future[Any]) -> Any:
        """A task's result, as long as there is anybody to give it."""
        without = 0.0
        while True:
            try:
                return future.result(timeout=_LOOK_SECONDS)
            except TimeoutError:
                without = 0.0 if self._client.nthreads() else without + _LOOK_SECONDS
                if without >= self._patience:
                    raise self._gone("there are no workers left") from None
            except CancelledError:
                raise self._gone("the scheduler is gone") from None

    @contextlib.contextmanager
    def _watched(self) -> Iterator[None]:
        """Errors of the connection as the lab's own."""
        from distributed.comm.core import CommClosedError

        try:
            with quiet():
                yield
        except (CommClosedError, OSError, CancelledError) as error:
            if isinstance(error, OSError) and not isinstance(error, CommClosedError | TimeoutError):
                raise
            raise self._gone("the scheduler is gone") from error

    def _gone(self, how: str) -> ShaderlabError:
        return ShaderlabError(f"Dask cluster {self._address}: {how}", remedy=_GO_ON)

    def _errand(self, job: Job, setup: Setup) -> tuple[Errand, list[Any]]:
        """A job as any worker can do it, and the parcels it needs, which are on their way."""
        from shaderlab.running.station import Errand

        parcels: list[Parcel] = []
        known_as = {what: _shown(folder) for what, folder in homes().items()}
        file = Path(job.file)
        shipped = shipped_path(file)
        if shipped is not None:
            address = Address(SHIPPED, shipped)
        else:
            tree = tree_of(file)
            parcel = self._folder(tree)
            parcels.append(parcel)
            known_as[parcel.name] = _shown(tree)
            inside = Path(os.path.abspath(file)).relative_to(tree)
            address = Address(parcel.name, inside.as_posix())
        shaders = []
        for name, path in setup.shaders:
            parcel = packed({path.name: path.read_bytes()})
            parcels.append(parcel)
            known_as[parcel.name] = _shown(path.parent)
            shaders.append((name, Address(parcel.name, path.name)))
        errand = Errand(
            setup=setup, job=job, file=address, shaders=tuple(shaders), known_as=known_as
        )
        return errand, [self._sent(parcel) for parcel in parcels]

    def _folder(self, folder: Path) -> Parcel:
        if folder not in self._folders:
            self._folders[folder] = packed_folder(folder)
        return self._folders[folder]

    def _sent(self, parcel: Parcel) -> Any:
        """The parcel as a task: one that Dask can make again where the worker that held it is
        lost."""
        from shaderlab.running import station

        if parcel.name not in self._parcels:
            key = f"{self._name}-{parcel.name}"
            self._parcels[parcel.name] = self._client.submit(station.carry, parcel, key=key)
        return self._parcels[parcel.name]


def _shown(folder: Path) -> str:
    """A folder as it begins the paths of files in it, as records name them."""
    return display_path(folder / "x")[:-1]


def _keep(files: Mapping[str, bytes], folder: Path) -> str:
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
