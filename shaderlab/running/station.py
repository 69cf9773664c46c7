"""The lab on a Dask worker: scenes run in processes of its own, never in the worker itself.

A `Station` is put on every worker for one run. Each of the worker's threads gets a `Crew` of one
process and a folder to draw into; whatever a scene does to its process, the Dask worker lives.
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
from typing import Any, TypeVar

from distributed import Worker, WorkerPlugin, get_worker

from shaderlab.discovery import data_folder
from shaderlab.running.crew import Crew
from shaderlab.running.jobs import About, CaseFacts, Job, Limits, Setup
from shaderlab.running.parcels import SHIPPED, Address, Parcel, homes, identity, renamed

IDLE_SECONDS = 120.0
"""After so long without work the processes end: the cluster may be other people's too."""

Got = TypeVar("Got")


@dataclass(frozen=True, kw_only=True)
class Errand:
    """One thing to be done at a station.

    Attributes:
        setup: as for a run here; its folders are only asked whether they are there.
        job: what is to be run.
        file: the case file.
        shaders: replacements, by shader name.
        known_as: what to call, in all that comes back, the folders "package", "cases" and
            "shaders" of the lab, and each parcel's by its name.
    """

    setup: Setup
    job: Job
    file: Address
    shaders: tuple[tuple[str, Address], ...] = ()
    known_as: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Delivery:
    """What comes back: a record as plain data, and the files that were written for it by their
    paths inside the run's folder, and inside the folder of frames."""

    record: Any
    files: Mapping[str, bytes]
    frames: Mapping[str, bytes]


class _Bench:
    """One process for scenes, started when it is needed, and the folder it draws into."""

    def __init__(self, folder: Path, driver: str | None, limits: Limits) -> None:
        self.folder = folder
        self._driver = driver
        self._limits = limits
        self._crew: Crew | None = None
        for name in ("here", "run", "frames"):
            (folder / name).mkdir(parents=True)

    def crew(self) -> Crew:
        if self._crew is None:
            # An empty working directory, so that no path in a record is shortened by this one.
            self._crew = Crew(self._driver, self._limits, folder=self.folder / "here")
        return self._crew

    def rest(self) -> None:
        if self._crew is not None:
            self._crew.close()
            self._crew = None


class Station(WorkerPlugin):
    """What a run puts on each Dask worker.

    Args:
        name: the run's own name for it.
        driver: as in `shaderlab.backends.open_backend`.
        limits: what one scene may take.
    """

    def __init__(self, name: str, driver: str | None, limits: Limits) -> None:
        self.name = name
        self._driver = driver
        self._limits = limits

    def setup(self, worker: Worker) -> None:
        """Make room on the worker; processes start with the first errand."""
        self._folder = Path(os.path.realpath(tempfile.mkdtemp(prefix="shaderlab-")))
        self._unpacking = threading.Lock()
        self._benches: queue.SimpleQueue[_Bench] = queue.SimpleQueue()
        self._all = [
            _Bench(self._folder / f"bench{n}", self._driver, self._limits)
            for n in range(worker.state.nthreads)
        ]
        for bench in self._all:
            self._benches.put(bench)
        self._idle: threading.Timer | None = None

    def teardown(self, worker: Worker) -> None:
        """End all processes, whatever they are doing."""
        if self._idle is not None:
            self._idle.cancel()
        for bench in self._all:
            bench.rest()
        shutil.rmtree(self._folder, ignore_errors=True)

    def about(self) -> About:
        """What the driver on this worker is."""
        with self._bench() as bench:
            return bench.crew().about()

    def load(self, errand: Errand, parcels: Sequence[Parcel]) -> CaseFacts:
        """What is in a case file; its paths are those of the asking machine."""
        places, names = self._places(errand, parcels)
        with self._bench() as bench:
            (found,) = bench.crew().load([_path(errand.file, places)])
        error = found.error
        if error is not None:
            file = None if error.file is None else renamed(error.file, names)
            error = type(error)(
                renamed(error.message, names), file=file, line=error.line, remedy=error.remedy
            )
        return replace(found, error=error)

    def perform(self, errand: Errand, parcels: Sequence[Parcel]) -> Delivery:
        """Run a job; nothing of it stays here."""
        from shaderlab.report import store

        places, names = self._places(errand, parcels)
        with self._bench() as bench:
            run, frames = bench.folder / "run", bench.folder / "frames"
            setup = replace(
                errand.setup,
                folder=run,
                frames=None if errand.setup.frames is None else frames,
                shaders=tuple((name, _path(at, places)) for name, at in errand.shaders),
            )
            job = replace(errand.job, file=str(_path(errand.file, places)))
            try:
                (record,) = bench.crew().run([job], setup, lambda job, record: None)
                return Delivery(
                    record=renamed(store.plain(record), names),
                    files=_contents(run),
                    frames=_contents(frames),
                )
            finally:
                for folder in (run, frames):
                    shutil.rmtree(folder, ignore_errors=True)
                    folder.mkdir(exist_ok=True)

    @contextlib.contextmanager
    def _bench(self) -> Iterator[_Bench]:
        bench = self._benches.get()
        try:
            yield bench
        finally:
            self._benches.put(bench)
            self._rest_later()

    def _rest_later(self) -> None:
        if self._idle is not None:
            self._idle.cancel()
        self._idle = threading.Timer(IDLE_SECONDS, self._rest)
        self._idle.daemon = True
        self._idle.start()

    def _rest(self) -> None:
        for _ in self._all:
            with contextlib.suppress(queue.Empty):
                bench = self._benches.get_nowait()
                bench.rest()
                self._benches.put(bench)

    def _places(
        self, errand: Errand, parcels: Sequence[Parcel]
    ) -> tuple[dict[str, Path], list[tuple[str, str]]]:
        """Where parcels and the lab's own folders are, and what their paths are to be called."""
        with self._unpacking:
            places = {parcel.name: parcel.unpack(self._folder) for parcel in parcels}
        names = []
        for what, folder in {**places, **homes()}.items():
            known = errand.known_as.get(what)
            if known is not None:
                names.append((f"{folder}{os.sep}", known))
                names.append((str(folder), known.rstrip("/") or "."))
        # The longer first: shaders may lie inside the package.
        names.sort(key=lambda pair: -len(pair[0]))
        return {**places, SHIPPED: data_folder("cases")}, names


def describe(station: str) -> About:
    """On a Dask worker: see `Station.about`."""
    return _station(station).about()


def load(station: str, errand: Errand, *parcels: Parcel) -> CaseFacts:
    """On a Dask worker: see `Station.load`."""
    return _station(station).load(errand, parcels)


def perform(station: str, expected: Mapping[str, str], errand: Errand, *parcels: Parcel) -> Any:
    """On a Dask worker: see `Station.perform`. A worker that came later and is not the same as
    the others gives its identity instead."""
    own = identity()
    return own if own != expected else _station(station).perform(errand, parcels)


def carry(parcel: Parcel) -> Parcel:
    """On a Dask worker: hold a parcel for the tasks that need it."""
    return parcel


def introduction() -> Callable[[], dict[str, str]]:
    """A function that tells a Dask worker's `identity`, and an "error" where there is no lab.

    It is defined inside this one because such functions travel as code and not as a name that
    the worker would have to import."""

    def identify() -> dict[str, str]:
        try:
            from shaderlab.running.parcels import identity
        except ImportError as error:
            return {"error": str(error)}
        return identity()

    return identify


def _station(name: str) -> Station:
    station = get_worker().plugins[name]
    assert isinstance(station, Station)
    return station


def _path(address: Address, places: Mapping[str, Path]) -> Path:
    return places[address.parcel] / address.path


def _contents(folder: Path) -> dict[str, bytes]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}
