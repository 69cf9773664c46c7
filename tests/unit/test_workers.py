"""Workers that crash, hang, fill the memory, raise and print: only the item at fault pays."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from shaderlab.errors import ShaderlabError
from shaderlab.workers import Limits, Pool
from shaderlab.workers.process import Process

WORK = """
import os, signal, sys, time

def work(items):
    for item in items:
        if item == "crash":
            os.kill(os.getpid(), signal.SIGSEGV)
        if item == "exit":
            print("the last words", file=sys.stderr)
            os._exit(3)
        if item == "hang":
            time.sleep(600)
        if item == "memory":
            bytearray(1 << 40)
        if item == "raise":
            raise ValueError("so it is")
        if item == "unsendable":
            yield lambda: None
        if item == "print":
            print("this is not an answer")
            os.system("echo nor is this")
        if item == "second":
            # Crashes only in a process that has done something before.
            if done:
                os.abort()
        done.append(item)
        if item == "slow":
            time.sleep(0.3)
        if item == "place":
            yield os.getcwd(), os.environ.get("PLACE"), sys.path
        yield os.getpid() if item in ("pid", "slow") else f"did {item}"

done = []
"""
WARM = """
import sys, threading

def begin():
    assert "work_to_do" not in sys.modules
    sys.warmed = []
    thread = threading.Thread(target=sys.warmed.append, args=["meanwhile"])
    def wait():
        assert "work_to_do" in sys.modules
        thread.start()
        thread.join()
    return wait
"""


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "work_to_do.py").write_text(textwrap.dedent(WORK))
    monkeypatch.syspath_prepend(str(tmp_path))
    return "work_to_do:work"


@pytest.fixture
def pool(work: str) -> Iterator[Pool]:
    with Pool(work, limits=Limits(seconds=0.7, memory=2 << 30), batch=4) as made:
        yield made


def test_results_come_in_order_from_one_process(pool: Pool) -> None:
    outcomes = list(pool.each(range(30)))
    assert [o.item for o in outcomes] == list(range(30))
    assert [o.result for o in outcomes] == [f"did {i}" for i in range(30)]
    pids = {o.result for o in pool.each(["pid"] * 10)}
    assert len(pids) == 1 and os.getpid() not in pids
    assert list(pool.each([])) == []


def test_what_goes_wrong_costs_only_its_item(pool: Pool) -> None:
    items = ["a", "crash", "b", "hang", "c", "exit", "memory", "d", "raise", "e", "unsendable", "f"]
    outcomes = list(pool.each(items))
    assert [o.item for o in outcomes] == items
    assert [o.status for o in outcomes] == [
        "done", "crash", "done", "timeout", "done", "crash", "crash", "done", "error", "done",
        "error", "done",
    ]  # fmt: skip
    said = {o.item: o.message for o in outcomes}
    assert "SIGSEGV" in said["crash"]
    assert said["hang"] == "took longer than 0.7 s"
    assert said["exit"] == "the process died: exit status 3, the last words"
    assert "SIGABRT" in said["memory"]
    errors = {o.item: o.result for o in outcomes if o.status == "error"}
    assert str(errors["raise"]) == "so it is"
    assert "can't be sent" in str(errors["unsendable"])


def test_what_the_work_prints_is_not_taken_for_an_answer(pool: Pool) -> None:
    assert [o.result for o in pool.each(["print", "a"])] == ["did print", "did a"]


def test_an_item_that_only_fails_after_others_is_asked_again_alone(pool: Pool) -> None:
    outcomes = list(pool.each(["a", "second", "b"]))
    assert [o.status for o in outcomes] == ["done"] * 3
    assert outcomes[1].result == "did second"


def test_several_workers_share_the_items_and_keep_the_order(work: str) -> None:
    with Pool(work, limits=Limits(seconds=5.0), jobs=2, batch=1) as pool:
        items = ["a", "crash", *map(str, range(20))]
        outcomes = list(pool.each(items))
    assert [o.item for o in outcomes] == items
    assert [o.status for o in outcomes].count("crash") == 1


def test_how_many_are_sent_at_once_can_be_told_for_some_items(
    work: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[int] = []
    before = Process.answers

    def answers(self: Process, batch: Sequence[object]) -> Iterator[tuple[str, object]]:
        sent.append(len(batch))
        return before(self, batch)

    monkeypatch.setattr(Process, "answers", answers)
    with Pool(work, limits=Limits(seconds=0.7), batch=1) as pool:
        assert len(list(pool.each("abc"))) == 3
        assert sent == [1, 1, 1]
        sent.clear()
        items = ["a", "hang", "slow", "slow", "slow", "raise", "b"]
        outcomes = list(pool.each(items, batch=3))
    assert sent == [3, 1, 3, 1]  # what comes after one that is lost is sent again
    assert [o.item for o in outcomes] == items
    expected = ["done", "timeout", "done", "done", "done", "error", "done"]
    assert [o.status for o in outcomes] == expected


def test_items_are_taken_as_they_are_needed(pool: Pool) -> None:
    taken = []

    def items() -> Iterator[int]:
        for number in range(10_000):
            taken.append(number)
            yield number

    outcomes = pool.each(items())
    assert next(outcomes).result == "did 0"
    assert len(taken) <= 64
    outcomes.close()


def test_what_no_worker_has_begun_is_dropped_when_nobody_wants_it(work: str) -> None:
    with Pool(work, limits=Limits(seconds=5.0), jobs=2, batch=1) as pool:
        done: list[str] = []
        outcomes = pool.each(["a", *["slow"] * 20], heard=lambda outcome: done.append(outcome.item))
        next(outcomes)
        outcomes.close()
        (last,) = pool.each(["b"])
        assert last.result == "did b"
    assert done.count("slow") <= 4  # two under way, and two that were begun just before


def test_closing_starts_no_process_for_what_is_left(
    work: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Pool(work, limits=Limits(seconds=60.0), jobs=2, batch=1) as pool:
        outcomes = pool.each(["a", *["hang"] * 20])
        next(outcomes)
        started: list[Process] = []
        monkeypatch.setattr(Process, "launch", lambda process: started.append(process))
    assert started == []


def test_workers_start_in_the_environment_that_the_pool_was_made_in(
    work: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that takes another's place starts in the middle of whatever its parent is doing then."""
    monkeypatch.setenv("PLACE", "before")
    here = os.getcwd()
    with Pool(work, jobs=1, batch=1) as pool:
        (first,) = pool.each(["place"])
        monkeypatch.setenv("PLACE", "after")
        monkeypatch.chdir(tmp_path)
        monkeypatch.syspath_prepend(str(tmp_path / "elsewhere"))
        pool.widen(2)
        outcomes = list(pool.each(["crash", "place", "crash", "place"]))
    assert first.result[:2] == (here, "before")
    assert [o.result for o in outcomes if o.item == "place"] == [first.result] * 2


def test_a_worker_that_cannot_start_is_an_error_and_not_a_crash_of_each_item() -> None:
    with (
        Pool("no_such_module:work") as pool,
        pytest.raises(ShaderlabError, match="can't start a worker process") as raised,
    ):
        list(pool.each(["a"]))
    assert "no_such_module" in raised.value.message


def test_closing_ends_the_process(work: str) -> None:
    with Pool(work) as pool:
        (outcome,) = pool.each(["pid"])
    with pytest.raises(ProcessLookupError):
        os.kill(outcome.result, 0)


def test_a_worker_warms_up_before_it_imports_and_is_ready_when_that_is_done(
    work: str, tmp_path: Path
) -> None:
    (tmp_path / "warm_up.py").write_text(WARM)
    with open(tmp_path / "work_to_do.py", "a") as file:
        file.write("\ndef warmed(items):\n    yield from (sys.warmed for _ in items)\n")
    with Pool("work_to_do:warmed", warm="warm_up:begin") as pool:
        (outcome,) = pool.each(["a"])
    assert outcome.result == ["meanwhile"]
    with (
        Pool(work, warm="warm_up:missing") as pool,
        pytest.raises(ShaderlabError, match=r"can't start a worker process.*missing"),
    ):
        list(pool.each(["a"]))


def test_a_worker_that_was_started_early_is_the_one_that_works(work: str) -> None:
    with Pool(work) as pool:
        pool.start()
        child = pool._processes[0]._child
        assert child is not None
        assert [outcome.result for outcome in pool.each(["pid"])] == [child.pid]


def test_workers_that_are_not_needed_are_not_started(work: str) -> None:
    with Pool(work, jobs=1, batch=1) as pool:
        assert len({outcome.result for outcome in pool.each(["slow"] * 3)}) == 1
        pool.widen(2)
        assert len({outcome.result for outcome in pool.each(["slow"] * 6)}) == 2
        pool.widen(1)
        assert len(pool._processes) == 2
    with Pool(work, jobs=3, batch=1) as pool:
        for _ in range(4):
            (_,) = pool.each(["pid"])
        assert [process._child is None for process in pool._processes] == [False, True, True]


def test_no_item_overtakes_another_on_its_way_to_a_worker(work: str) -> None:
    """One that waits for a worker has a thread; were there more threads than workers, whoever has
    just given its worker back would take it again, for a later item."""
    with Pool(work, jobs=1, batch=1) as pool:
        for _ in range(3):
            done: list[int] = []
            list(pool.each(range(60), lambda outcome, done=done: done.append(outcome.item)))
            assert done == list(range(60))
