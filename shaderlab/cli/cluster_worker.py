"""The lab on a Dask worker: jobs run in separate processes, never in the worker itself.

A `DaskPlugin` is installed on every worker for one run. Its `ProcessExecutor` has a process for
each of the worker's threads, so a scene that crashes its process leaves the Dask worker running.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from distributed import Worker, WorkerPlugin, get_worker

from shaderlab.cli.cluster import SHIPPED, Address, Bundle, identity, lab_folders, rename_paths
from shaderlab.engine.catalogue import data_folder
from shaderlab.engine.jobs import CaseInfo, DriverInfo, Job, ProcessExecutor
from shaderlab.errors import CaseError
from shaderlab.model.options import Limits, RunOptions

IDLE_SECONDS = 120.0
"""The processes end after this time without work, as the cluster may be shared."""


@dataclass(frozen=True, kw_only=True)
class RemoteJobs:
    """Jobs in a form that any machine can run.

    Attributes:
        options: as for a local run; of its folders only whether they are set counts.
        jobs: what to run.
        files: the case files, by the jobs' names of them.
        shaders: replacements, by shader name.
        local_names: this machine's paths of the lab's folders "package", "cases" and "shaders",
            and of each bundle, by name; results are returned with these paths.
    """

    options: RunOptions
    jobs: Sequence[Job]
    files: Mapping[str, Address]
    shaders: tuple[tuple[str, Address], ...] = ()
    local_names: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class RemoteResult:
    """Records as plain data by the job's number, and the files written for them, by their paths
    inside the run's folder and inside the folder of frames."""

    records: Mapping[int, Any]
    files: Mapping[str, bytes]
    frames: Mapping[str, bytes]


class DaskPlugin(WorkerPlugin):
    """The plug-in that a run installs on each Dask worker.

    Args:
        name: unique to the run.
        driver: as in `shaderlab.drivers.open_backend`.
        limits: of each job.
    """

    def __init__(self, name: str, driver: str | None, limits: Limits) -> None:
        self.name = name
        self._driver = driver
        self._limits = limits

    def setup(self, worker: Worker) -> None:
        """Create folders; processes start with the first job."""
        self._folder = Path(os.path.realpath(tempfile.mkdtemp(prefix="shaderlab-")))
        self._threads = worker.state.nthreads
        self._unpacking = threading.Lock()
        self._lock = threading.Lock()  # for all below
        self._executor: ProcessExecutor | None = None
        self._running = 0
        self._idle = threading.Timer(IDLE_SECONDS, self._close_idle)

    def teardown(self, worker: Worker) -> None:
        """End all processes, whatever they are doing."""
        self._idle.cancel()
        if self._executor is not None:
            self._executor.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def about(self) -> DriverInfo:
        """The driver and the packages of this worker."""
        with self._processes() as executor:
            return executor.about()

    def load(self, remote: RemoteJobs, *bundles: Bundle) -> list[CaseInfo]:
        """The facts of the case files, with the paths of the machine that sent them."""
        names = self._unpack(remote, bundles)
        with self._processes() as executor:
            found = executor.load([_resolve(address) for address in remote.files.values()])
        return [
            replace(facts, file=file, error=_rename_error(facts.error, names))
            for file, facts in zip(remote.files, found, strict=True)
        ]

    def run(
        self, expected: Mapping[str, str], remote: RemoteJobs, *bundles: Bundle
    ) -> RemoteResult | dict[str, str]:
        """Run jobs, and leave no files on this machine.

        A worker that joined later, with other versions, returns its own `identity` instead.
        """
        from shaderlab.model import store

        if identity() != expected:
            return identity()
        names = self._unpack(remote, bundles)
        with (
            self._processes() as executor,
            tempfile.TemporaryDirectory(dir=self._folder) as folder,
        ):
            drawn, frames = Path(folder, "run"), Path(folder, "frames")
            drawn.mkdir()
            options = replace(
                remote.options,
                folder=drawn,
                frames=None if remote.options.frames is None else frames,
                shaders={name: _resolve(at) for name, at in remote.shaders},
            )
            files = {name: str(_resolve(address)) for name, address in remote.files.items()}
            jobs = [replace(job, file=files[job.file]) for job in remote.jobs]
            numbers = {id(job): number for number, job in enumerate(jobs)}
            return RemoteResult(
                records={
                    numbers[id(job)]: rename_paths(store.to_plain(record), names)
                    for job, record in executor.run(jobs, options)
                },
                files=_read_files(drawn),
                frames=_read_files(frames),
            )

    @contextlib.contextmanager
    def _processes(self) -> Iterator[ProcessExecutor]:
        with self._lock:
            self._running += 1
            if self._executor is None:
                self._executor = ProcessExecutor(
                    self._driver, self._limits, self._threads, self._folder, early=False
                )
            executor = self._executor
        try:
            yield executor
        finally:
            with self._lock:
                self._running -= 1
                self._idle.cancel()
                self._idle = threading.Timer(IDLE_SECONDS, self._close_idle)
                self._idle.daemon = True
                self._idle.start()

    def _close_idle(self) -> None:
        with self._lock:
            if self._executor is not None and not self._running:
                self._executor.close()
                self._executor = None

    def _unpack(self, remote: RemoteJobs, bundles: Sequence[Bundle]) -> list[tuple[str, str]]:
        """Unpack bundles; returns pairs of a path here and the sender's path.

        Processes work where bundles are, so that their messages name a bundle's files the same way
        in every run, and the compile cache knows them again.
        """
        with self._unpacking:
            folders = {bundle.name: bundle.unpack(self._folder) for bundle in bundles}
        names = []
        for what, folder in {**folders, **lab_folders()}.items():
            local = remote.local_names.get(what)
            if local is not None:
                names.append((f"{folder}{os.sep}", local))
                names.append((str(folder), local.rstrip("/") or "."))
        names += [(f"{bundle.name}{os.sep}", remote.local_names[bundle.name]) for bundle in bundles]
        # The longer first: shaders may lie inside the package.
        names.sort(key=lambda pair: -len(pair[0]))
        return names


def call(plugin: str, method: str, *arguments: Any) -> Any:
    """On a Dask worker: call a method of the `DaskPlugin` of this name."""
    return getattr(get_worker().plugins[plugin], method)(*arguments)


def carry(bundle: Bundle) -> Bundle:
    """On a Dask worker: hold a bundle for the tasks that need it."""
    return bundle


def identify_worker() -> Callable[[], dict[str, str]]:
    """A function that returns a Dask worker's `identity`, or an "error" if it has no shaderlab.

    It is a nested function because those are pickled as code, not as a name that the worker would
    have to import."""

    def identify() -> dict[str, str]:
        try:
            from shaderlab.cli.cluster import identity
        except ImportError as error:
            return {"error": str(error)}
        return identity()

    return identify


def _rename_error(error: CaseError | None, names: Sequence[tuple[str, str]]) -> CaseError | None:
    if error is None:
        return None
    file = None if error.file is None else rename_paths(error.file, names)
    message = rename_paths(error.message, names)
    return type(error)(message, file=file, line=error.line, remedy=error.remedy)


def _resolve(address: Address) -> Path:
    """The file as processes name it, which work in the folder where bundles are."""
    return Path(data_folder("cases") if address.bundle == SHIPPED else address.bundle, address.path)


def _read_files(folder: Path) -> dict[str, bytes]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}
