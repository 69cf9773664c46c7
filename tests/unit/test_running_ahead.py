"""Records that are made before they are asked for: each goes to its own job, whatever is asked."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from pathlib import Path

import pytest

from shaderlab.errors import ShaderlabError
from shaderlab.records import Record
from shaderlab.running import Ahead, Job, Setup
from shaderlab.running.ahead import NEAR
from shaderlab.running.jobs import About, CaseFacts
from shaderlab.running.lost import lost

JOBS = [Job(file="lamp.py", id="lamp", variant=str(number)) for number in range(100)]


class Team:
    """Notes what it is asked for, begins a few jobs ahead as workers do, numbers its records."""

    AHEAD = 3

    def __init__(self) -> None:
        self.asked: list[list[str]] = []
        self.begun: list[str] = []
        self.ended = 0
        self.closed = False
        self.refuses = ""

    def run(self, jobs: Sequence[Job], setup: Setup, heard: object) -> Generator[Record]:
        names = [job.variant for job in jobs]
        self.asked.append(names)
        done = 0
        try:
            for number, job in enumerate(jobs):
                while done < min(number + 1 + self.AHEAD, len(jobs)):
                    self.begun.append(names[done])
                    done += 1
                if job.variant == self.refuses:
                    raise ShaderlabError("no worker can be started")
                yield lost(job, "error", f"time {self.begun.count(job.variant)}")
        finally:
            self.ended += 1

    def about(self) -> About:
        raise NotImplementedError

    def load(self, files: Sequence[Path]) -> list[CaseFacts]:
        raise NotImplementedError

    def close(self) -> None:
        self.closed = True


class Front:
    """Asks for jobs by number, and foretells all that follow."""

    def __init__(self, patient: bool = False) -> None:
        self.team = Team()
        self.ahead = Ahead(self.team, Setup(), patient)

    def ask(self, number: int) -> Record:
        record = self.ahead.record(JOBS[number], lambda: JOBS[number + 1 :])
        assert record.variant == str(number)
        return record


@pytest.fixture
def front() -> Front:
    return Front()


def test_jobs_in_order_are_one_run_that_goes_ahead(front: Front) -> None:
    front.ask(0)
    assert front.team.begun == ["0", "1", "2", "3"]
    for number in range(1, 100):
        front.ask(number)
    assert len(front.team.asked) == 1 and front.team.begun == [job.variant for job in JOBS]


def test_the_patient_begin_nothing_ahead() -> None:
    front = Front(patient=True)
    for number in range(5):
        front.ask(number)
        assert front.team.begun == list("01234")[: number + 1]


def test_those_that_were_passed_over_are_dropped(front: Front) -> None:
    front.ask(0)
    front.ask(NEAR)
    assert len(front.team.asked) == 1
    assert front.ask(5).message == "time 2"  # nothing is kept of what nobody asked for


def test_a_job_far_on_does_not_wait_for_all_before_it(front: Front) -> None:
    front.ask(0)
    front.ask(NEAR + 1)
    assert front.team.begun[:5] == ["0", "1", "2", "3", str(NEAR + 1)]
    assert front.team.ended == 1


def test_a_job_that_is_asked_for_again_is_run_again(front: Front) -> None:
    assert front.ask(7).message == "time 1"
    assert front.ask(7).message == "time 2"
    assert front.ask(8).message == "time 2"  # it was under way, and not asked for
    assert front.team.ended == 1


def test_a_job_that_nobody_foretold_is_run(front: Front) -> None:
    front.ask(0)
    other = Job(file="lamp.py", id="lamp", variant="other")
    assert front.ahead.record(other, list).variant == "other"
    front.ask(1)


def test_after_an_error_the_next_job_is_asked_for_anew(front: Front) -> None:
    front.team.refuses = "2"
    front.ask(0)
    with pytest.raises(ShaderlabError, match="no worker"):
        front.ask(2)
    front.ask(3)
    assert [names[0] for names in front.team.asked] == ["0", "3"]


def test_stopping_ends_the_run_and_closing_the_team(front: Front) -> None:
    front.ahead.stop()
    front.ask(0)
    front.ahead.stop()
    assert front.team.ended == 1 and not front.team.closed
    front.ask(1)
    front.ahead.close()
    assert front.team.ended == 2 and front.team.closed
