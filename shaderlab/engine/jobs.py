"""Jobs and requests as plain data that crosses processes, and what comes back.

A request is a picklable object with `perform(worker)`; features define requests of their own. The
commands import this module before the first worker is ready, so it imports little.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from shaderlab.errors import CaseError, UsageError, suggest
from shaderlab.model.options import RunOptions

if TYPE_CHECKING:
    from shaderlab.engine.worker import Worker
    from shaderlab.model.records import Record, Status


@dataclass(frozen=True, kw_only=True)
class CaseInfo:
    """What a case file holds, as far as choosing among its variants needs it.

    Attributes:
        formulas: for each variant, how many formulas its outputs are held against.
        parameters: how many components each uniform and ramp has, by name.
        sized: whether a pass has the size of the frame that is judged.
        error: why the file could not be loaded; then `variants` is empty.
        status: "error" if the file is wrong, "crash" or "timeout" if it took its process with it.
    """

    file: str
    id: str
    title: str = ""
    section: str = ""
    variants: tuple[str, ...] = ()
    formulas: tuple[int, ...] = ()
    parameters: Mapping[str, int] = field(default_factory=dict)
    sized: bool = True
    error: CaseError | None = None
    status: str = "pass"


@dataclass(frozen=True, kw_only=True)
class Point:
    """One point of a sweep: the variant it starts from, the parameters' values, and the side of
    the frame that is judged (0: the run's)."""

    variant: str
    changes: Mapping[str, float]
    size: int = 0


@dataclass(frozen=True, kw_only=True)
class Job:
    """One variant to run.

    Attributes:
        broken: for a case file that could not be loaded, how that ended: "error", "crash" or
            "timeout".
        trouble: why it could not be loaded.
        point: runs the variant with other inputs, judged by its formulas alone; `variant` is then
            the point's own name.
        driver: where it is run, if the run has several drivers; "" for the run's own.
    """

    file: str
    id: str
    variant: str
    title: str = ""
    section: str = ""
    broken: str = ""
    trouble: str = ""
    point: Point | None = None
    driver: str = ""

    @property
    def key(self) -> tuple[str, str, str]:
        """What tells it from the others of a run, as of its record."""
        return self.id, self.variant, self.driver


@dataclass(frozen=True, kw_only=True)
class DriverInfo:
    """The driver that an executor's jobs run on, and the versions of the packages in use."""

    driver: Mapping[str, str] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)


class Request(Protocol):
    """Something to do in a worker."""

    def perform(self, worker: Worker) -> Any:
        """Do it, and return a picklable result."""


@dataclass(frozen=True)
class DescribeDriver:
    """Asks for a `DriverInfo` with the driver; a process keeps the first driver it is asked for."""

    driver: str | None

    def perform(self, worker: Worker) -> DriverInfo:
        return DriverInfo(driver=dict(worker.lab(RunOptions(driver=self.driver)).driver))


@dataclass(frozen=True)
class LoadCase:
    """Asks for a file's `CaseInfo`. Raises CaseError."""

    file: Path

    def perform(self, worker: Worker) -> CaseInfo:
        return worker.facts(self.file)


@dataclass(frozen=True)
class RunJob:
    """Asks for a job's `Record`. Raises CaseError where the case file is wrong."""

    job: Job
    options: RunOptions

    def perform(self, worker: Worker) -> Record:
        return worker.run(self.job, self.options)


def make_jobs(facts: CaseInfo) -> list[Job]:
    """A job for each variant of a case."""
    return [
        Job(file=facts.file, id=facts.id, variant=name, title=facts.title, section=facts.section)
        for name in facts.variants
    ]


def bare_record(job: Job, status: str) -> Record:
    """A record that says of a job what it was, and nothing else."""
    return make_failed_record(job, status, "")


def make_failed_record(
    job: Job, status: str, message: str, *, step: str = "", driver: str = "", seconds: float = 0.0
) -> Record:
    """The record of a job whose process did not live to write one.

    Args:
        job: what was to be run.
        status: "timeout", "crash" or "error".
        message: how it ended.
        step: the last thing it was about to do, in words.
        driver: the renderer it ran on.
        seconds: how long it took until then.
    """
    from shaderlab.engine.discovery import chapter_title
    from shaderlab.model.records import Record  # not before the first worker is started

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
        lesson="",
        formula="",
        file=job.file,
        status=cast("Status", status),
        message="\n".join(lines),
        seconds=seconds,
        driver_name=job.driver,
    )


def check_driver(name: str) -> str:
    """`name`, if it is a driver's. Raises UsageError."""
    from shaderlab.drivers import DRIVERS

    if name not in DRIVERS:
        raise UsageError(f"there is no driver {name!r}", remedy=suggest(name, DRIVERS))
    return name
