"""The lab on a Dask worker: jobs run in processes of its own, never in the worker itself.

A `DaskPlugin` is installed on every worker for one run. Each of the worker's threads gets a
`ProcessExecutor` of one process and a folder to draw into; whatever a scene does to its process,
the Dask worker lives.
"""

from __future__ import annotations

import contextlib
import os
import queue
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from distributed import Worker, WorkerPlugin, get_worker

from shaderlab.discovery import data_folder
from shaderlab.execution.dask_bundles import SHIPPED, Address, Bundle, homes, identity, renamed
from shaderlab.execution.executor import ProcessExecutor
from shaderlab.execution.jobs import About, CaseFacts, Job
from shaderlab.options import Limits, RunOptions

IDLE_SECONDS = 120.0
"""After so long without work the processes end: the cluster may be shared with others."""


@dataclass(frozen=True, kw_only=True)
class RemoteJob:
    """A job as any machine can run it.

    Attributes:
        options: as for a run here; of its folders only their presence counts.
        job: what to run.
        file: the case file.
        shaders: replacements, by shader name.
        local_names: how this machine names the folders "package", "cases" and "shaders" of the
            lab, and each bundle's by the bundle's name, in everything that comes back.
    """

    options: RunOptions
    job: Job
    file: Address
    shaders: tuple[tuple[str, Address], ...] = ()
    local_names: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class RemoteResult:
    """What comes back: a record as plain data, and the files that were written for it by their
    paths inside the run's folder, and inside the folder of frames."""

    record: Any
    files: Mapping[str, bytes]
    frames: Mapping[str, bytes]


class _Slot:
    """The executor and the folder of one thread of the Dask worker."""

    def __init__(self, folder: Path, driver: str | None, limits: Limits) -> None:
        self.run_folder, self.frames = folder / "run", folder / "frames"
        # An empty working directory, so that no path in a record is shortened by this one.
        self._home = folder / "home"
        self._driver = driver
        self._limits = limits
        self._executor: ProcessExecutor | None = None
        for made in (self._home, self.run_folder, self.frames):
            made.mkdir(parents=True)

    def executor(self) -> ProcessExecutor:
        if self._executor is None:
            self._executor = ProcessExecutor(self._driver, self._limits, folder=self._home)
        return self._executor

    def close(self) -> None:
        if self._executor is not None:
            self._executor.close()
            self._executor = None


class DaskPlugin(WorkerPlugin):
    """What a run installs on each Dask worker.

    Args:
        name: the run's own name for it.
        driver: as in `shaderlab.backends.open_backend`.
        limits: of each job.
    """

    def __init__(self, name: str, driver: str | None, limits: Limits) -> None:
        self.name = name
        self._driver = driver
        self._limits = limits

    def setup(self, worker: Worker) -> None:
        """Make folders; processes start with the first job."""
        self._folder = Path(os.path.realpath(tempfile.mkdtemp(prefix="shaderlab-")))
        self._unpacking = threading.Lock()
        self._free: queue.SimpleQueue[_Slot] = queue.SimpleQueue()
        self._slots = [
            _Slot(self._folder / f"slot{n}", self._driver, self._limits)
            for n in range(worker.state.nthreads)
        ]
        for slot in self._slots:
            self._free.put(slot)
        self._idle: threading.Timer | None = None

    def teardown(self, worker: Worker) -> None:
        """End all processes, whatever they are doing."""
        if self._idle is not None:
            self._idle.cancel()
        for slot in self._slots:
            slot.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def about(self) -> About:
        """The driver and the packages of this worker."""
        with self._slot() as slot:
            return slot.executor().about()

    def load(self, remote: RemoteJob, bundles: Sequence[Bundle]) -> CaseFacts:
        """What is in a case file; its paths are those of the asking machine."""
        folders, names = self._unpacked(remote, bundles)
        with self._slot() as slot:
            (found,) = slot.executor().load([_path(remote.file, folders)])
        error = found.error
        if error is not None:
            file = None if error.file is None else renamed(error.file, names)
            error = type(error)(
                renamed(error.message, names), file=file, line=error.line, remedy=error.remedy
            )
        return replace(found, error=error)

    def run(self, remote: RemoteJob, bundles: Sequence[Bundle]) -> RemoteResult:
        """Run a job; nothing of it stays here."""
        from shaderlab.report import store

        folders, names = self._unpacked(remote, bundles)
        with self._slot() as slot:
            options = replace(
                remote.options,
                folder=slot.run_folder,
                frames=None if remote.options.frames is None else slot.frames,
                shaders={name: _path(at, folders) for name, at in remote.shaders},
            )
            job = replace(remote.job, file=str(_path(remote.file, folders)))
            try:
                ((_, record),) = slot.executor().run([job], options)
                return RemoteResult(
                    record=renamed(store.plain(record), names),
                    files=_contents(slot.run_folder),
                    frames=_contents(slot.frames),
                )
            finally:
                for folder in (slot.run_folder, slot.frames):
                    shutil.rmtree(folder, ignore_errors=True)
                    folder.mkdir(exist_ok=True)

    @contextlib.contextmanager
    def _slot(self) -> Iterator[_Slot]:
        slot = self._free.get()
        try:
            yield slot
        finally:
            self._free.put(slot)
            if self._idle is not None:
                self._idle.cancel()
            self._idle = threading.Timer(IDLE_SECONDS, self._close_idle)
            self._idle.daemon = True
            self._idle.start()

    def _close_idle(self) -> None:
        for _ in self._slots:
            with contextlib.suppress(queue.Empty):
                slot = self._free.get_nowait()
                slot.close()
                self._free.put(slot)

    def _unpacked(
        self, remote: RemoteJob, bundles: Sequence[Bundle]
    ) -> tuple[dict[str, Path], list[tuple[str, str]]]:
        """The folders of bundles and of the lab itself, and what to call their paths."""
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


def describe(plugin: str) -> About:
    """On a Dask worker: see `DaskPlugin.about`."""
    return _plugin(plugin).about()


def load(plugin: str, remote: RemoteJob, *bundles: Bundle) -> CaseFacts:
    """On a Dask worker: see `DaskPlugin.load`."""
    return _plugin(plugin).load(remote, bundles)


def run(plugin: str, expected: Mapping[str, str], remote: RemoteJob, *bundles: Bundle) -> Any:
    """On a Dask worker: see `DaskPlugin.run`. A worker that joined later and is not the same as
    the others gives its identity instead."""
    own = identity()
    return own if own != expected else _plugin(plugin).run(remote, bundles)


def carry(bundle: Bundle) -> Bundle:
    """On a Dask worker: hold a bundle for the tasks that need it."""
    return bundle


def identify_worker() -> Callable[[], dict[str, str]]:
    """A function that returns a Dask worker's `identity`, and an "error" where there is no lab.

    It is defined inside this one because such functions travel as code and not as a name that
    the worker would have to import."""

    def identify() -> dict[str, str]:
        try:
            from shaderlab.execution.dask_bundles import identity
        except ImportError as error:
            return {"error": str(error)}
        return identity()

    return identify


def _plugin(name: str) -> DaskPlugin:
    plugin = get_worker().plugins[name]
    assert isinstance(plugin, DaskPlugin)
    return plugin


def _path(address: Address, folders: Mapping[str, Path]) -> Path:
    return folders[address.bundle] / address.path


def _contents(folder: Path) -> dict[str, bytes]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}
