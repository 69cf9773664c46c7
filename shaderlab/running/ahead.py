"""Records for someone who asks for one after the other, most of them there before that.

A front door whose jobs are not its own to order, such as pytest's plugin, says which jobs are
likely to come next. They are run in one go, as `Team.run` does with a whole run; whoever asks for
another job than was foretold gets it all the same.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable, Generator, Iterable
from typing import TYPE_CHECKING

from shaderlab.running.jobs import Job, Setup

if TYPE_CHECKING:
    from shaderlab.records import Record
    from shaderlab.running.crew import Team

NEAR = 32
"""How far on a job may be for those before it to be run, and their records dropped: a crew has
about as many under way. Beyond, a new start costs less."""


class Ahead:
    """Asks a team for jobs before their records are asked for.

    Args:
        team: who runs them.
        setup: how they are run.
        patient: whether jobs are run no sooner than they are asked for, after all.
    """

    def __init__(self, team: Team, setup: Setup, patient: bool = False) -> None:
        self.team = team
        self._setup = setup
        self._patient = patient
        self._records: Generator[Record] | None = None
        self._coming: deque[Job] = deque()

    def record(self, job: Job, following: Callable[[], Iterable[Job]]) -> Record:
        """The record of a job, run now unless that was done ahead.

        No record is given twice: a job that is asked for again is run again.

        Args:
            job: the job.
            following: gives those that are likely to be asked for after it, in order. It is
                called only if `job` itself was not foretold.

        Raises:
            ShaderlabError: no worker can be started at all.
        """
        if job not in itertools.islice(self._coming, NEAR):
            self._begin([job] if self._patient else [job, *following()])
        assert self._records is not None
        try:
            while True:
                coming, record = self._coming.popleft(), next(self._records)
                if coming == job:
                    return record
        except BaseException:
            self.stop()
            raise

    def stop(self) -> None:
        """Begin no more jobs; what is under way is not waited for."""
        if self._records is not None:
            self._records.close()
        self._records = None
        self._coming.clear()

    def close(self) -> None:
        """End everything, and the team with it."""
        self.stop()
        self.team.close()

    def _begin(self, jobs: list[Job]) -> None:
        self.stop()
        self._coming.extend(jobs)
        self._records = self.team.run(jobs, self._setup, _unheard)


def _unheard(job: Job, record: Record) -> None:
    """Nobody needs to know before the record is asked for."""
