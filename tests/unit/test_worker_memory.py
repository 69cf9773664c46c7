"""A worker that has grown is replaced before its next item, and no item is lost."""

from __future__ import annotations

import mmap
import os
from pathlib import Path

import pytest

from shaderlab.workers import pool
from shaderlab.workers.pool import WorkerPool

WORK = """
import os

held = []

def work(item):
    held.append(b"x" * (item << 20))
    return os.getpid()
"""

pytestmark = pytest.mark.skipif(
    not os.path.isdir("/proc/self"), reason="memory is looked up in /proc"
)


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "hungry.py").write_text(WORK)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(pool, "GROWTH", 64 << 20)
    return "hungry:work"


def test_a_worker_that_has_grown_is_replaced_before_its_next_item(work: str) -> None:
    with WorkerPool(work) as pool:
        workers = [result.value for result in pool.run([1, 1, 80, 1, 1])]
    first, second, third, fourth, fifth = workers
    assert first == second == third
    assert fourth == fifth != first


def test_what_the_first_item_needs_is_no_growth(work: str) -> None:
    with WorkerPool(work) as pool:
        assert len({result.value for result in pool.run([200, 1, 30, 1])}) == 1


def test_memory_is_that_of_the_process() -> None:
    before = pool.measure_memory(os.getpid())
    with mmap.mmap(-1, 64 << 20, mmap.MAP_PRIVATE) as held:  # the heap may have as much left over
        for page in range(0, len(held), mmap.PAGESIZE):
            held[page] = 1
        assert pool.measure_memory(os.getpid()) - before > 48 << 20
