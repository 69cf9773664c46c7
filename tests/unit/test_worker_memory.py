"""A worker that has grown gives memory back or ends before its next scene; the process that asks
does not."""

from __future__ import annotations

import os
from types import SimpleNamespace
from typing import Any, NoReturn

import pytest

from shaderlab.errors import CaseError
from shaderlab.model.options import RunOptions
from shaderlab.workers import lab_worker
from shaderlab.workers.jobs import Job
from shaderlab.workers.worker_main import freed_memory

JOB = Job(file="nowhere.py", id="nowhere", variant="default")


class EndedError(Exception):
    """Stands for the end of the process."""


@pytest.fixture(autouse=True)
def ends(monkeypatch: pytest.MonkeyPatch) -> None:
    def end(status: int) -> NoReturn:
        raise EndedError(status)

    monkeypatch.setattr(os, "_exit", end)
    monkeypatch.setattr(lab_worker, "prepare_process", lambda driver: None)


START = 80 << 20


def worker(channel: Any, start: int = START) -> lab_worker.LabWorker:
    made = lab_worker.LabWorker(channel)
    made.lab(RunOptions())
    made._start = start  # as before its first scene
    return made


@pytest.mark.parametrize(
    ("more", "free", "after", "error"),
    [
        (0.99, 0.0, None, CaseError),
        (1.01, 0.0, 0.74, CaseError),
        (1.01, 0.0, 0.76, EndedError),
        (2.49, 1.5, None, CaseError),  # what is free will be used again
        (2.49, 1.48, 0.76, EndedError),
        (2.51, 2.0, 0.74, CaseError),
        (2.51, 2.0, 0.76, EndedError),
    ],
)
def test_a_worker_that_has_grown_and_can_spare_little_ends(
    monkeypatch: pytest.MonkeyPatch,
    more: float,
    free: float,
    after: float | None,
    error: type[Exception],
) -> None:
    """By how much more than before its first scene it holds, as a multiple of GROWTH."""
    grown = [more] if after is None else [more, after]
    sizes = iter([START + round(part * lab_worker.GROWTH) for part in grown])
    monkeypatch.setattr(lab_worker, "_own_memory", lambda: next(sizes))
    monkeypatch.setattr(lab_worker, "freed_memory", lambda: round(free * lab_worker.GROWTH))
    with pytest.raises(error):
        worker(SimpleNamespace(note=lambda step: None)).run(JOB, RunOptions())


@pytest.mark.parametrize(("channel", "start"), [(SimpleNamespace(note=print), 0), (None, START)])
def test_a_first_scene_is_run_and_a_process_that_asks_itself_goes_on(
    monkeypatch: pytest.MonkeyPatch, channel: Any, start: int
) -> None:
    monkeypatch.setattr(lab_worker, "_own_memory", lambda: 1 << 40)
    with pytest.raises(CaseError):
        worker(channel, start).run(JOB, RunOptions())


def test_freed_memory_is_counted() -> None:
    held = [bytes(1000) for _ in range(20_000)]
    before = freed_memory()
    keep = held[-1]
    del held
    assert keep and freed_memory() - before > 10 << 20


def test_memory_is_that_of_this_process() -> None:
    before = lab_worker._own_memory()
    held = bytearray(64 << 20)
    held[::4096] = b"x" * len(held[::4096])
    assert lab_worker._own_memory() - before > 48 << 20
