"""Workers that crash, hang, fill the memory, raise and print: only the item at fault pays."""

from __future__ import annotations

import contextlib
import errno
import os
import subprocess
import textwrap
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from shaderlab.engine.jobs import LoadCase
from shaderlab.errors import ShaderlabError
from shaderlab.model.options import Limits
from shaderlab.workers import pool as pool_module
from shaderlab.workers.pool import ItemResult, WorkerPool

WORK = """
import ctypes, os, signal, subprocess, sys, time

class Work:
    def __init__(self, channel):
        self.channel = channel
        self.done = []

    def __call__(self, item):
        if item == "crash":
            self.channel.note("about to crash")
            os.kill(os.getpid(), signal.SIGSEGV)
        if item == "exit":
            print("the last words", file=sys.stderr)
            os._exit(3)
        if item == "hang":
            # In C code that lets no other thread run. Whatever the machine, the short limit
            # holds for nothing but the hang.
            self.channel.restart_limit(0.2)
            ctypes.PyDLL(None).sleep(600)
        if item == "stop":
            self.channel.restart_limit(0.2)
            os.kill(os.getpid(), signal.SIGSTOP)
        if item == "longer":
            self.channel.restart_limit(60)
            time.sleep(2.5)
            self.channel.restart_limit()
        if item == "memory":
            bytearray(1 << 40)
        if item == "leave":
            raise SystemExit(3)
        if item == "interrupt":
            raise KeyboardInterrupt
        if item == "children":
            # One that knows nothing of Python, and a copy of this process, which goes on.
            other = subprocess.Popen(["sleep", "600"])
            if os.fork() == 0:
                time.sleep(600)
            return os.getpid(), other.pid
        if item == "copy":
            os.fork()
        if item == "raise":
            raise ValueError("so it is")
        if item == "unsendable":
            return lambda: None
        if item == "print":
            print("this is not an answer")
            os.system("echo nor is this")
        if item == "second":
            # Crashes only in a process that has done something before.
            if self.done:
                os.abort()
        self.done.append(item)
        if isinstance(item, str) and item.startswith("until "):
            while not os.path.exists(item.removeprefix("until ")):
                time.sleep(0.01)
        if isinstance(item, str) and item.startswith("touch "):
            open(item.removeprefix("touch "), "w").close()
        if item == "place":
            return os.getcwd(), os.environ.get("PLACE"), sys.path
        if item == "before":
            return len(self.done) - 1
        return os.getpid() if str(item).endswith("pid") else f"did {item}"
"""
PRELOADING = """
class Preloading(Work):
    @staticmethod
    def preload():
        Preloading.done = True
    def __call__(self, item):
        return Preloading.done

class Broken(Work):
    @staticmethod
    def preload():
        raise OSError("nothing there")
"""
LIMITS = Limits(seconds=600.0, gigabytes=2.0)  # which no busy machine reaches


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "work_to_do.py").write_text(textwrap.dedent(WORK))
    monkeypatch.syspath_prepend(str(tmp_path))
    return "work_to_do:Work"


@pytest.fixture
def pool(work: str) -> Iterator[WorkerPool]:
    with WorkerPool(work, limits=LIMITS) as made:
        yield made


def by_item(results: Iterator[ItemResult]) -> dict[Any, ItemResult]:
    return {result.item: result for result in results}


def statuses(results: Iterator[ItemResult]) -> dict[Any, str]:
    return {result.item: result.status for result in results}


def test_one_process_gives_results_in_order(pool: WorkerPool) -> None:
    results = list(pool.run(range(30)))
    assert [r.number for r in results] == [r.item for r in results] == list(range(30))
    assert [r.value for r in results] == [f"did {i}" for i in range(30)]
    pids = {r.value for r in pool.run(["pid"] * 10)}
    assert len(pids) == 1 and os.getpid() not in pids
    assert list(pool.run([])) == []


def test_what_goes_wrong_costs_only_its_item(pool: WorkerPool) -> None:
    items = ["a", "crash", "b", "hang", "c", "exit", "memory", "d", "raise", "e", "unsendable", "f"]
    items += ["leave", "g", "interrupt", "copy", "stop"]
    results = by_item(pool.run(items))
    assert {item: result.status for item, result in results.items()} == {
        **dict.fromkeys([*"abcdefg", "copy"], "done"),
        **dict.fromkeys(["crash", "exit", "memory"], "crash"),
        **dict.fromkeys(["raise", "unsendable", "leave", "interrupt"], "error"),
        **dict.fromkeys(["hang", "stop"], "timeout"),
    }
    assert "stopped (SIGSTOP)" in results["stop"].message
    assert "SIGSEGV" in results["crash"].message and results["crash"].step == "about to crash"
    assert results["hang"].message == "took longer than 0.2 s" and results["hang"].step == ""
    assert results["exit"].message == "the process died: exit status 3, the last words"
    assert "SIGABRT" in results["memory"].message
    assert str(results["raise"].value) == "so it is"
    assert str(results["leave"].value) == "raised SystemExit: 3"
    assert str(results["interrupt"].value) == "raised KeyboardInterrupt"
    assert "can't be sent" in str(results["unsendable"].value)


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="processes are looked up in /proc")
@pytest.mark.parametrize("ends", ["the run", "crash"])
def test_what_an_item_has_started_ends_with_its_worker(work: str, ends: str) -> None:
    with WorkerPool(work, limits=LIMITS) as pool:
        first, *_ = pool.run(["children", ends])
        assert ends == "crash" or len(group(first.value[0])) >= 3
    deadline = time.monotonic() + 30.0  # a process that was killed takes a moment to end
    while (left := group(first.value[0])) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert left == []


def group(leader: int) -> list[int]:
    """The processes of a group that still run."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, number, *_ = stat.read_text().rpartition(")")[2].split()
            found += [int(stat.parent.name)] if int(number) == leader and state != "Z" else []
    return found


def test_an_item_may_ask_for_more_time(work: str) -> None:
    with WorkerPool(work, limits=Limits(seconds=2.0)) as pool:
        (result,) = pool.run(["longer"])
    assert result.status == "done" and result.seconds >= 2.5


def test_what_the_work_prints_is_not_taken_for_an_answer(pool: WorkerPool) -> None:
    assert [r.value for r in pool.run(["print", "a"])] == ["did print", "did a"]


def test_an_item_that_only_fails_after_others_is_asked_again_alone(pool: WorkerPool) -> None:
    results = list(pool.run(["a", "second", "b"]))
    assert [r.status for r in results] == ["done"] * 3
    assert results[1].value == "did second"


def test_workers_share_the_items_and_results_come_as_they_complete(
    work: str, tmp_path: Path
) -> None:
    """The first item waits for the last one."""
    done = tmp_path / "done"
    items = [f"until {done}", "a", "crash", *map(str, range(20)), f"touch {done}"]
    with WorkerPool(work, limits=LIMITS, jobs=2) as pool:
        results = list(pool.run(items))
    assert sorted(r.number for r in results) == list(range(len(items)))
    assert results[0].item != items[0] and results[-1].number in (0, len(items) - 1)
    assert [r.item for r in results if r.status != "done"] == ["crash"]


def test_items_are_taken_as_they_are_needed(pool: WorkerPool) -> None:
    taken = []

    def items() -> Iterator[int]:
        for number in range(10_000):
            taken.append(number)
            yield number

    results = pool.run(items())
    assert next(results).value == "did 0"
    assert len(taken) <= 64
    results.close()


def test_closing_the_results_drops_what_no_worker_has_begun(work: str, tmp_path: Path) -> None:
    go = tmp_path / "go"
    with WorkerPool(work, limits=LIMITS, jobs=1) as pool:
        results = pool.run(["a", *[f"until {go}"] * 20])
        next(results)
        results.close()
        go.touch()
        (last,) = pool.run(["before"])
    assert last.value <= 2  # "a", and the one that was under way


def test_closing_the_pool_ends_what_is_under_way_and_starts_nothing(work: str) -> None:
    pool = WorkerPool(work, limits=LIMITS, jobs=2)
    results = pool.run(["pid", *["until never"] * 20])
    first = next(results)
    pool.close()
    assert {result.status for result in results} <= {"crash"}
    with pytest.raises(ProcessLookupError):
        os.kill(first.value, 0)


def test_workers_start_in_the_environment_that_the_pool_was_made_in(
    work: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A replacement starts in the middle of whatever its parent is doing then."""
    monkeypatch.setenv("PLACE", "before")
    here = os.getcwd()
    with WorkerPool(work, limits=LIMITS, jobs=1) as pool:
        (first,) = pool.run(["place"])
        monkeypatch.setenv("PLACE", "after")
        monkeypatch.chdir(tmp_path)
        monkeypatch.syspath_prepend(str(tmp_path / "elsewhere"))
        pool.jobs = 2
        results = list(pool.run(["crash", "place", "crash", "place"]))
    assert first.value[:2] == (here, "before")
    assert [r.value for r in results if r.item == "place"] == [first.value] * 2


def test_workers_take_no_file_of_a_user_for_a_module_of_pythons(
    work: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    for name in ("here/numpy", "copy", "random", "tempfile"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('the wrong module')\n")
    monkeypatch.chdir(tmp_path / "here")
    with WorkerPool("shaderlab.engine.worker:Worker", limits=LIMITS) as pool:
        (result,) = pool.run([LoadCase(Path("nowhere.py"))])
    assert "there is no such case file" in str(result.value)


def test_a_worker_that_cannot_start_is_an_error_and_not_a_crash_of_each_item() -> None:
    with (
        WorkerPool("no_such_module:work") as pool,
        pytest.raises(ShaderlabError, match="can't start a worker process") as raised,
    ):
        list(pool.run(["a"]))
    assert "no_such_module" in raised.value.message


def test_a_worker_that_starts_too_slowly_is_an_error_that_says_so(
    work: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pool_module, "START_SECONDS", 0.01)
    with (
        WorkerPool(work, limits=Limits(seconds=0.01)) as pool,
        pytest.raises(ShaderlabError, match=r"took longer than 0.01 s.*\n.*busy.*--timeout"),
    ):
        list(pool.run(["a"]))


NO_PROCESS = pool_module._Process, "start", BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
NO_THREAD = threading.Thread, "start", RuntimeError("can't start new thread")


@pytest.mark.parametrize(("owner", "name", "error"), [NO_PROCESS, NO_THREAD])
def test_a_limit_that_keeps_workers_from_starting_is_named(
    work: str, monkeypatch: pytest.MonkeyPatch, owner: Any, name: str, error: Exception
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(owner, name, refuse)
    with (
        WorkerPool(work, limits=LIMITS) as pool,
        pytest.raises(ShaderlabError, match="allow more processes than `ulimit -u` says"),
    ):
        list(pool.run(["a"]))


def test_what_a_work_preloads_is_there_when_it_is_ready(work: str, tmp_path: Path) -> None:
    with open(tmp_path / "work_to_do.py", "a") as file:
        file.write(PRELOADING)
    with WorkerPool("work_to_do:Preloading") as pool:
        (result,) = pool.run(["a"])
    assert result.value is True
    with (
        WorkerPool("work_to_do:Broken") as pool,
        pytest.raises(ShaderlabError, match=r"can't start a worker process.*nothing there"),
    ):
        list(pool.run(["a"]))


def test_more_workers_may_be_allowed_than_there_will_ever_be(work: str) -> None:
    with WorkerPool(work, limits=LIMITS, jobs=10**20) as pool:
        assert list(pool.run([])) == []


def test_workers_that_are_not_needed_are_not_started(work: str, tmp_path: Path) -> None:
    with WorkerPool(work, limits=LIMITS, jobs=3) as pool:
        pool.start("pid")
        pids = {result.value for _ in range(4) for result in pool.run(["pid"])}
        assert len(pids) == 1
        done = tmp_path / "done"
        results = pool.run(["pid", "pid", f"until {done}", f"touch {done}"])
        assert len(list(results)) == 4


def test_a_process_that_ends_while_its_children_are_listed_has_none() -> None:
    for _ in range(100):
        process = subprocess.Popen(["true"])
        waiting = threading.Thread(target=process.wait)
        waiting.start()
        while waiting.is_alive():
            assert not list(pool_module._descendants(process.pid))
        waiting.join()
