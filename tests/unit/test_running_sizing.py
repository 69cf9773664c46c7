"""How many workers there are where nobody says: as many as are worth their start, in this process's
share of the machine, and the results in the same order."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.cli.requesting import Request
from shaderlab.running import Crew, Job, Setup, crew, sizing
from shaderlab.running.jobs import CaseFacts, Describe, Load
from shaderlab.workers import Outcome


@pytest.mark.parametrize(
    ("variants", "cores", "workers"),
    [(0, 8, 1), (1, 8, 1), (7, 8, 1), (8, 8, 2), (11, 8, 2), (12, 8, 3), (500, 3, 3), (500, 1, 1),
     (16, 8, 4), (500, 64, 4)],
)  # fmt: skip
def test_a_worker_for_every_few_variants(
    variants: int, cores: int, workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sizing, "cores", lambda: cores)
    assert sizing.suitable(variants) == workers


def test_cores_are_those_that_this_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {3, 5}, raising=False)
    assert sizing.cores() == 2
    monkeypatch.delattr(os, "sched_getaffinity")
    assert sizing.cores() == 64
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert sizing.cores() == 1


class Pool:
    """Notes how many workers it is asked to have, and answers without any."""

    def __init__(self, work: str, *, jobs: int, **_: Any) -> None:
        self.asked = [jobs]
        self.batches: list[int | None] = []

    def start(self) -> None:
        pass

    def close(self) -> None:
        pass

    def widen(self, jobs: int) -> None:
        self.asked.append(jobs)

    def each(
        self,
        items: Sequence[Any],
        heard: Callable[[Outcome], None] | None = None,
        batch: int | None = None,
    ) -> Iterator[Outcome]:
        self.batches.append(batch)
        for item in items:
            if isinstance(item, Load):
                result = CaseFacts(file=str(item.file), id=item.file.stem)
                yield Outcome(item, "done", result)
            else:
                yield Outcome(item, "error", ValueError("no" if isinstance(item, Describe) else ""))


@pytest.mark.parametrize(("workers", "asked"), [(None, [1, 2, 4]), (1, [1]), (3, [3]), (9, [9])])
def test_workers_are_added_when_it_is_known_what_there_is_to_do(
    workers: int | None, asked: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crew, "Pool", Pool)
    monkeypatch.setattr(sizing, "cores", lambda: 8)
    team = Crew(workers=workers)
    try:
        team.load([Path(f"{n}.py") for n in range(9)])
        jobs = [Job(file="a.py", id="a", variant=f"{n}") for n in range(20)]
        broken = [Job(file="b.py", id=f"b{n}", variant="", broken="error") for n in range(20)]
        records = list(team.run([*jobs, *broken], Setup(), lambda job, record: None))
    finally:
        team.close()
    assert [(r.id, r.variant) for r in records] == [job.key for job in (*jobs, *broken)]
    pool = team._pool
    assert isinstance(pool, Pool) and pool.asked == asked


def test_many_case_files_are_sent_together_and_jobs_one_by_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(crew, "Pool", Pool)
    team = Crew(workers=2, early=False)
    try:
        for count in (1, 31, 32, 100, 1000):
            team.load([Path(f"{n}.py") for n in range(count)])
        list(team.run([Job(file="a.py", id="a", variant="v")], Setup(), lambda job, record: None))
    finally:
        team.close()
    pool = team._pool
    assert isinstance(pool, Pool) and pool.batches == [1, 1, 2, 6, 8, None, None]


def test_without_j_the_number_is_left_to_the_crew(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[int | None] = []
    monkeypatch.setattr(
        "shaderlab.cli.requesting.Crew", lambda driver, limits, workers: made.append(workers)
    )
    for workers in (None, 2):
        Request(seconds=1.0, gigabytes=1.0, workers=workers).team()
    assert made == [None, 2]


@pytest.mark.parametrize("command", ["run", "sweep"])
def test_help_says_how_many_there_are(command: str) -> None:
    said = " ".join(CliRunner().invoke(cli, [command, "-h"]).output.split())
    assert f"[default: ({sizing.WORDS}); x>=0]" in said
