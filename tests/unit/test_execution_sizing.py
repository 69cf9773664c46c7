"""How many workers there are where nobody says: as many as are worth their start, in this process's
share of the machine, and the results in the same order."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.engine import jobs
from shaderlab.engine.jobs import CaseInfo, Job, LoadCase, ProcessExecutor
from shaderlab.model.options import RunOptions
from shaderlab.workers.pool import ItemResult


@pytest.mark.parametrize(
    ("variants", "cores", "workers"),
    [(0, 8, 1), (1, 8, 1), (7, 8, 1), (8, 8, 2), (11, 8, 2), (12, 8, 3), (500, 3, 3), (500, 1, 1),
     (16, 8, 4), (500, 64, 4)],
)  # fmt: skip
def test_a_worker_for_every_few_variants(
    variants: int, cores: int, workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jobs, "count_cores", lambda: cores)
    assert jobs.choose_worker_count(variants) == workers


def test_cores_are_those_that_this_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {3, 5}, raising=False)
    assert jobs.count_cores() == 2
    monkeypatch.delattr(os, "sched_getaffinity")
    assert jobs.count_cores() == 64
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert jobs.count_cores() == 1


class Pool:
    """Notes how many workers it is asked to have, and answers without any."""

    def __init__(self, work: str, *, jobs: int, **_: Any) -> None:
        self.jobs = jobs
        self.items: list[Any] = []
        POOLS.append(self)

    def start(self, item: Any) -> None:
        pass

    def close(self) -> None:
        pass

    def run(self, items: Sequence[Any]) -> Iterator[ItemResult]:
        self.items += items
        for number, item in enumerate(items):
            if isinstance(item, LoadCase):
                facts = CaseInfo(file=str(item.file), id=item.file.stem)
                yield ItemResult(number, item, "done", facts)
            else:
                yield ItemResult(number, item, "error", ValueError("no"))


POOLS: list[Pool] = []


@pytest.fixture
def pools(monkeypatch: pytest.MonkeyPatch) -> list[Pool]:
    monkeypatch.setattr(jobs, "WorkerPool", Pool)
    monkeypatch.setattr(jobs, "count_cores", lambda: 8)
    POOLS.clear()
    return POOLS


@pytest.mark.parametrize(("workers", "at_last"), [(None, 4), (1, 1), (3, 3), (9, 9)])
def test_workers_are_added_when_it_is_known_what_there_is_to_do(
    workers: int | None, at_last: int, pools: list[Pool]
) -> None:
    jobs = [Job(file="a.py", id="a", variant=f"{n}") for n in range(20)]
    broken = [Job(file="b.py", id=f"b{n}", variant="", broken="error") for n in range(20)]
    with contextlib.closing(ProcessExecutor(workers=workers)) as made:
        made.load([Path(f"{n}.py") for n in range(9)])
        found = dict(made.run([*jobs, *broken], RunOptions()))
    assert set(found) == {*jobs, *broken}
    assert all(record.key == job.key for job, record in found.items())
    assert pools[0].jobs == at_last


@pytest.mark.parametrize("command", ["run", "mutate"])
def test_help_says_how_many_there_are(command: str) -> None:
    said = " ".join(CliRunner().invoke(cli, [command, "-h"]).output.split())
    assert f"[default: ({jobs.WORDS}); x>=0]" in said
