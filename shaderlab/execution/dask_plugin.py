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
from dataclasses import field, replace
from pathlib import Path
from typing import Any

from distributed import Worker, WorkerPlugin, get_worker

from shaderlab.discovery import data_folder
from shaderlab.execution.dask_bundles import SHIPPED, Address, Bundle, homes, identity, renamed
from shaderlab.execution.executor import ProcessExecutor
from shaderlab.execution.jobs import About, CaseFacts, Job
from shaderlab.lazy_dataclass import dataclass
from shaderlab.options import Limits, RunOptions

IDLE_SECONDS = 120.0
"""The processes end after this time without work, as the cluster may be shared."""


@dataclass(frozen=True, kw_only=True)
class RemoteJob:
    """A job in a form that any machine can run.

    Attributes:
        options: as for a local run; of its folders only whether they are set counts.
        job: what to run.
        file: the case file.
        shaders: replacements, by shader name.
        local_names: this machine's paths of the lab's folders "package", "cases" and "shaders",
            and of each bundle, by name; results are returned with these paths.
    """

    options: RunOptions
    job: Job
    file: Address
    shaders: tuple[tuple[str, Address], ...] = ()
    local_names: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class RemoteResult:
    """A record as plain data, and the files written for it, by their paths inside the run's folder
    and inside the folder of frames."""

    record: Any
    files: Mapping[str, bytes]
    frames: Mapping[str, bytes]


class DaskPlugin(WorkerPlugin):
    """The plug-in that a run installs on each Dask worker.

    Args:
        name: unique to the run.
        driver: as in `shaderlab.backends.open_backend`.
        limits: of each job.
    """

    def __init__(self, name: str, driver: str | None, limits: Limits) -> None:
        self.name = name
        self._driver = driver
        self._limits = limits

    def setup(self, worker: Worker) -> None:
        """Create folders; processes start with the first job."""
        self._folder = Path(os.path.realpath(tempfile.mkdtemp(prefix="shaderlab-")))
        # An empty working directory, so that no path in a record is shortened by this one.
        self._home = self._folder / "home"
        self._home.mkdir()
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

    def about(self) -> About:
        """The driver and the packages of this worker."""
        with self._processes() as executor:
            return executor.about()

    def load(self, remote: RemoteJob, *bundles: Bundle) -> CaseFacts:
        """The facts of a case file, with the paths of the machine that sent it."""
        folders, names = self._unpacked(remote, bundles)
        with self._processes() as executor:
            (found,) = executor.load([_path(remote.file, folders)])
        error = found.error
        if error is not None:
            file = None if error.file is None else renamed(error.file, names)
            error = type(error)(
                renamed(error.message, names), file=file, line=error.line, remedy=error.remedy
            )
        return replace(found, error=error)

    def run(
        self, expected: Mapping[str, str], remote: RemoteJob, *bundles: Bundle
    ) -> RemoteResult | dict[str, str]:
        """Run a job, and leave no files on this machine.

        A worker that joined later, with other versions, returns its own `identity` instead.
        """
        from shaderlab.report import store

        if identity() != expected:
            return identity()
        folders, names = self._unpacked(remote, bundles)
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
                shaders={name: _path(at, folders) for name, at in remote.shaders},
            )
            job = replace(remote.job, file=str(_path(remote.file, folders)))
            ((_, record),) = executor.run([job], options)
            return RemoteResult(
                record=renamed(store.plain(record), names),
                files=_contents(drawn),
                frames=_contents(frames),
            )

    @contextlib.contextmanager
    def _processes(self) -> Iterator[ProcessExecutor]:
        with self._lock:
            self._running += 1
            if self._executor is None:
                self._executor = ProcessExecutor(
                    self._driver, self._limits, self._threads, self._home, early=False
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

    def _unpacked(
        self, remote: RemoteJob, bundles: Sequence[Bundle]
    ) -> tuple[dict[str, Path], list[tuple[str, str]]]:
        """The folders of bundles and of the lab, and pairs of a path here and the sender's path."""
        with self._unpacking:
            folders = {bundle.name: bundle.unpack(self._folder) for bundle in bundles}
        names = []
        for what, folder in {**folders, **homes()}.items():
            local = remote.local_names.get(what)
            if local is not None:
                names.append((f"{folder}{os.sep}", local))
                names.append((str(folder), local.rstrip("/") or "."))
        # The longer first: shaders may lie inside the package.
        names.sort(key=lambda pair: -len(pair[0]))
        return {**folders, SHIPPED: data_folder("cases")}, names


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
            from shaderlab.execution.dask_bundles import identity
        except ImportError as error:
            return {"error": str(error)}
        return identity()

    return identify


def _path(address: Address, folders: Mapping[str, Path]) -> Path:
    return folders[address.bundle] / address.path


def _contents(folder: Path) -> dict[str, bytes]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}
