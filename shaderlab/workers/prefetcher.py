"""Prefetches records for a sequential caller.

A front door whose jobs are not its own to order, such as pytest's plugin, says which jobs are
likely to come next. They are run in one go; any other job is run when it is asked for.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Generator, Iterable
from typing import TYPE_CHECKING

from shaderlab.model.options import RunOptions

from .jobs import Job

if TYPE_CHECKING:
    from shaderlab.model.records import Record

    from .executor import Executor

NEAR = 32
"""How far ahead a job may be for those before it to be run, and their records dropped: an executor
has about as many under way. Beyond, a new start costs less."""


class Prefetcher:
    """Gives an executor jobs before their records are asked for.

    Args:
        executor: what runs the jobs.
        options: how they are run.
        ahead: whether any job is run before it is asked for.
    """

    def __init__(self, executor: Executor, options: RunOptions, ahead: bool = True) -> None:
        self.executor = executor
        self._options = options
        self._ahead = ahead
        self._results: Generator[tuple[Job, Record]] | None = None
        self._expected: dict[Job, None] = {}  # an ordered set
        self._records: dict[Job, Record] = {}

    def record(self, job: Job, following: Callable[[], Iterable[Job]]) -> Record:
        """The record of a job, run now unless it was prefetched.

        No record is given twice: a job that is asked for again is run again.

        Args:
            job: the job.
            following: gives those that are likely to be asked for after it, in order. It is
                called only if `job` itself was not expected.

        Raises:
            ShaderlabError: no worker can be started at all.
        """
        if job not in itertools.islice(self._expected, NEAR):
            self._begin([job, *following()] if self._ahead else [job])
        while next(iter(self._expected)) != job:  # these were passed over
            passed = next(iter(self._expected))
            del self._expected[passed]
            self._records.pop(passed, None)
        assert self._results is not None
        try:
            while job not in self._records:
                other, record = next(self._results)
                if other in self._expected:
                    self._records[other] = record
        except BaseException:
            self.stop()
            raise
        del self._expected[job]
        return self._records.pop(job)

    def stop(self) -> None:
        """Begin no more jobs; what is under way is not waited for."""
        if self._results is not None:
            self._results.close()
        self._results = None
        self._expected.clear()
        self._records.clear()

    def close(self) -> None:
        """End everything, and the executor with it."""
        self.stop()
        self.executor.close()

    def _begin(self, jobs: list[Job]) -> None:
        self.stop()
        self._expected = dict.fromkeys(jobs)
        self._results = self.executor.run(jobs, self._options)
