"""Half of a report's pages written by a copy of the process: nothing is lost, errors arrive."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path

import pytest

from shaderlab.errors import ShaderlabError
from shaderlab.report import html, second_process
from shaderlab.report.second_process import in_second_process
from tests.unit.test_report_samples import record, run


def test_work_is_done_by_another_process_while_the_block_runs(tmp_path: Path) -> None:
    def work() -> None:
        (tmp_path / "begun").write_text(str(os.getpid()))
        while not (tmp_path / "block").exists():
            time.sleep(0.001)
        (tmp_path / "done").touch()

    with in_second_process(work):
        while not (tmp_path / "begun").exists():
            time.sleep(0.001)
        (tmp_path / "block").touch()
    assert (tmp_path / "done").exists()
    assert int((tmp_path / "begun").read_text()) != os.getpid()


def test_it_waits_for_the_thread_that_holds_what_the_work_needs() -> None:
    lock = threading.Lock()
    held = threading.Event()

    def hold() -> None:
        with lock:
            held.set()
            time.sleep(0.05)

    thread = threading.Thread(target=hold)
    thread.start()
    held.wait()
    with in_second_process(lambda: lock.acquire(timeout=5) or os.abort(), after=thread):
        assert not thread.is_alive()


def test_what_a_copy_leaves_is_done_here(tmp_path: Path) -> None:
    parent = os.getpid()

    def work() -> None:
        if os.getpid() != parent:
            os.kill(os.getpid(), 9)
        (tmp_path / "done").touch()

    with in_second_process(work):
        pass
    assert (tmp_path / "done").exists()


def test_without_a_second_process_all_is_done_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(second_process.os, "fork", lambda: (_ for _ in ()).throw(OSError("no")))
    with in_second_process((tmp_path / "done").touch):
        assert not (tmp_path / "done").exists()
    assert (tmp_path / "done").exists()


def test_an_interrupt_ends_the_copy(tmp_path: Path) -> None:
    def work() -> None:
        (tmp_path / "copy").write_text(str(os.getpid()))
        time.sleep(60)

    with pytest.raises(KeyboardInterrupt), in_second_process(work):
        while not (tmp_path / "copy").exists() or not (tmp_path / "copy").read_text():
            time.sleep(0.001)
        raise KeyboardInterrupt
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "copy").read_text()), 0)


def test_two_processes_write_the_pages_that_one_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    many = run(*(record(f"case {n}", formula="") for n in range(html._MANY)))
    copies = []
    monkeypatch.setattr(second_process, "_fork", lambda: copies.append(os.fork()) or copies[-1])
    html.write(many, tmp_path / "a/one")
    assert not copies
    html.write(many, tmp_path / "b/two", by_two=True)
    assert len(copies) == 1
    one, two = (
        {path.name: path.read_bytes() for path in (tmp_path / name).rglob("*.*")}
        for name in ("a/one", "b/two")
    )
    assert len(one) > html._MANY
    assert one == two


@pytest.mark.parametrize("number", [0, 1])
def test_a_page_that_cant_be_written_is_told_whoever_writes_it(tmp_path: Path, number: int) -> None:
    many = run(*(record(f"case {n}", formula="") for n in range(html._MANY)))
    (tmp_path / "cases" / f"case-{number}.html").mkdir(parents=True)
    with pytest.raises(ShaderlabError, match=f"case-{number}.html"):
        html.write(many, tmp_path, by_two=True)
    assert not (tmp_path / "index.html").exists()
