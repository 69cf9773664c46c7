"""What an executor asks of its workers.

A request is any picklable object with `perform(worker)`; other rooms have requests of their own.
This module is imported by the processes that ask, so it imports little.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from shaderlab.execution.jobs import About, CaseFacts, Job
from shaderlab.options import RunOptions

if TYPE_CHECKING:
    from shaderlab.execution.lab_worker import LabWorker
    from shaderlab.records import Record


class Request(Protocol):
    """Something to do in a worker."""

    def perform(self, worker: LabWorker) -> Any:
        """Do it, and return a picklable result."""


@dataclass(frozen=True)
class DescribeDriver:
    """Asks for an `About` with the driver; a process keeps the first driver it is asked for."""

    driver: str | None

    def perform(self, worker: LabWorker) -> About:
        """See `Request`."""
        return About(driver=dict(worker.lab(RunOptions(driver=self.driver)).driver))


@dataclass(frozen=True)
class LoadCase:
    """Asks for a file's `CaseFacts`. Raises CaseError."""

    file: Path

    def perform(self, worker: LabWorker) -> CaseFacts:
        """See `Request`."""
        return worker.facts(self.file)


@dataclass(frozen=True)
class RunJob:
    """Asks for a job's `Record`. Raises CaseError where the case file is wrong."""

    job: Job
    options: RunOptions

    def perform(self, worker: LabWorker) -> Record:
        """See `Request`."""
        return worker.run(self.job, self.options)
