"""Records that are made before they are asked for: each goes to its own job, whatever is asked."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from pathlib import Path

import pytest

from shaderlab.engine.jobs import NEAR, CaseInfo, DriverInfo, Job, Prefetcher, make_failed_record
from shaderlab.errors import ShaderlabError
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

JOBS = [Job(file="lamp.py", id="lamp", variant=str(number)) for number in range(100)]


class Executor:
    """Notes what it is asked for, begins a few jobs ahead as workers do, numbers its records."""

    AHEAD = 3

    def __init__(self, backwards: bool = False) -> None:
        self.asked: list[list[str]] = []
        self.begun: list[str] = []
        self.ended = 0
        self.closed = False
        self.refuses = ""
        self.backwards = backwards  # whether jobs that run side by side end in turned order

    def run(self, jobs: Sequence[Job], options: RunOptions) -> Generator[tuple[Job, Record]]:
        names = [job.variant for job in jobs]
        self.asked.append(names)
        done = 0
        order = range(len(jobs))
        if self.backwards:
            order = sorted(order, key=lambda number: (number // self.AHEAD, -number))
        try:
            for place, number in enumerate(order):
                while done < min(place + 1 + self.AHEAD, len(jobs)):
                    self.begun.append(names[done])
                    done += 1
                job = jobs[number]
                if job.variant == self.refuses:
                    raise ShaderlabError("no worker can be started")
                times = self.begun.count(job.variant)
                yield job, make_failed_record(job, "error", f"time {times}")
        finally:
            self.ended += 1

    def about(self) -> DriverInfo:
        raise NotImplementedError

    def load(self, files: Sequence[Path]) -> list[CaseInfo]:
        raise NotImplementedError

    def close(self) -> None:
        self.closed = True


class Front:
    """Asks for jobs by number, and foretells all that follow."""

    def __init__(self, ahead: bool = True, backwards: bool = False) -> None:
        self.executor = Executor(backwards)
        self.prefetcher = Prefetcher(self.executor, RunOptions(), ahead)

    def ask(self, number: int) -> Record:
        record = self.prefetcher.record(JOBS[number], lambda: JOBS[number + 1 :])
        assert record.variant == str(number)
        return record


@pytest.fixture
def front() -> Front:
    return Front()


def test_jobs_in_order_are_one_run_that_goes_ahead(front: Front) -> None:
    front.ask(0)
    assert front.executor.begun == ["0", "1", "2", "3"]
    for number in range(1, 100):
        front.ask(number)
    assert len(front.executor.asked) == 1 and front.executor.begun == [job.variant for job in JOBS]


def test_records_go_to_their_jobs_in_whatever_order_they_come() -> None:
    front = Front(backwards=True)
    for number in range(100):
        assert front.ask(number).message == "time 1"
    assert len(front.executor.asked) == 1


def test_without_ahead_nothing_is_begun_before_its_turn() -> None:
    front = Front(ahead=False)
    for number in range(5):
        front.ask(number)
        assert front.executor.begun == list("01234")[: number + 1]


def test_those_that_were_passed_over_are_dropped(front: Front) -> None:
    front.ask(0)
    front.ask(NEAR)
    assert len(front.executor.asked) == 1
    assert front.ask(5).message == "time 2"  # nothing is kept of what nobody asked for


def test_a_job_far_on_does_not_wait_for_all_before_it(front: Front) -> None:
    front.ask(0)
    front.ask(NEAR + 1)
    assert front.executor.begun[:5] == ["0", "1", "2", "3", str(NEAR + 1)]
    assert front.executor.ended == 1


def test_a_job_that_is_asked_for_again_is_run_again(front: Front) -> None:
    assert front.ask(7).message == "time 1"
    assert front.ask(7).message == "time 2"
    assert front.ask(8).message == "time 2"  # it was under way, and not asked for
    assert front.executor.ended == 1


def test_a_job_that_nobody_foretold_is_run(front: Front) -> None:
    front.ask(0)
    other = Job(file="lamp.py", id="lamp", variant="other")
    assert front.prefetcher.record(other, list).variant == "other"
    front.ask(1)


def test_after_an_error_the_next_job_is_asked_for_anew(front: Front) -> None:
    front.executor.refuses = "2"
    front.ask(0)
    with pytest.raises(ShaderlabError, match="no worker"):
        front.ask(2)
    front.ask(3)
    assert [names[0] for names in front.executor.asked] == ["0", "3"]


def test_stopping_ends_the_run_and_closing_the_team(front: Front) -> None:
    front.prefetcher.stop()
    front.ask(0)
    front.prefetcher.stop()
    assert front.executor.ended == 1 and not front.executor.closed
    front.ask(1)
    front.prefetcher.close()
    assert front.executor.ended == 2 and front.executor.closed
