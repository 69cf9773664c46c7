"""A worker that has grown gives memory back or ends before its next scene; the process that asks
does not."""

from __future__ import annotations

import os
from types import SimpleNamespace
from typing import Any, NoReturn

import pytest

from shaderlab.errors import CaseError
from shaderlab.execution import lab_worker
from shaderlab.execution.jobs import Job
from shaderlab.options import RunOptions

JOB = Job(file="nowhere.py", id="nowhere", variant="default")


class EndedError(Exception):
    """Stands for the end of the process."""


@pytest.fixture(autouse=True)
def ends(monkeypatch: pytest.MonkeyPatch) -> None:
    def end(status: int) -> NoReturn:
        raise EndedError(status)

    monkeypatch.setattr(os, "_exit", end)
    monkeypatch.setattr(lab_worker, "prepare_process", lambda driver: None)


def worker(channel: Any) -> lab_worker.LabWorker:
    made = lab_worker.LabWorker(channel)
    made.lab(RunOptions())
    return made


@pytest.mark.parametrize(("large", "error"), [(0, EndedError), (1 << 50, CaseError)])
def test_a_large_worker_ends(
    monkeypatch: pytest.MonkeyPatch, large: int, error: type[Exception]
) -> None:
    monkeypatch.setattr(lab_worker, "LARGE", large)
    with pytest.raises(error):
        worker(SimpleNamespace(note=lambda step: None)).run(JOB, RunOptions())


@pytest.mark.parametrize(("after", "error"), [(0.7, CaseError), (0.8, EndedError)])
def test_a_large_worker_that_can_spare_a_quarter_goes_on(
    monkeypatch: pytest.MonkeyPatch, after: float, error: type[Exception]
) -> None:
    sizes = iter([lab_worker.LARGE + 1, int(after * lab_worker.LARGE)])
    monkeypatch.setattr(lab_worker, "_own_memory", lambda: next(sizes))
    with pytest.raises(error):
        worker(SimpleNamespace(note=lambda step: None)).run(JOB, RunOptions())


def test_the_first_scene_is_run_however_large_the_process_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(lab_worker, "LARGE", 0)
    with pytest.raises(CaseError):
        lab_worker.LabWorker(SimpleNamespace(note=lambda step: None)).run(JOB, RunOptions())


def test_a_process_that_asks_itself_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lab_worker, "LARGE", 0)
    with pytest.raises(CaseError):
        worker(None).run(JOB, RunOptions())


def test_memory_is_that_of_this_process() -> None:
    before = lab_worker._own_memory()
    held = bytearray(64 << 20)
    held[::4096] = b"x" * len(held[::4096])
    assert lab_worker._own_memory() - before > 48 << 20
