"""Workers end with the process that started them; what they took counts as its children's."""

from __future__ import annotations

import contextlib
import fcntl
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from shaderlab.errors import ShaderlabError
from shaderlab.model.options import Limits
from shaderlab.workers import pool as pool_module
from shaderlab.workers.pool import WorkerPool, _descendants

WORK = """
import os, subprocess, sys, time

def work(item):
    if item == "sleep":
        time.sleep(600)
    if item in ("child", "detached"):
        detached = item == "detached"
        child = subprocess.Popen(["sleep", "600"], start_new_session=detached)
        return os.getpid(), child.pid
    if item == "orphan":
        child = subprocess.Popen(["sleep", "600"], start_new_session=True)
        sys.stderr.write(str(child.pid))
        sys.stderr.flush()
        os._exit(0)
    if item == "burn":
        while time.process_time() < 0.3:
            pass
    return os.getpid(), os.getppid(), "mine" in sys.modules
"""
PARENT = """
import sys
from shaderlab.model.options import Limits
from shaderlab.workers.pool import WorkerPool, _descendants

with WorkerPool("mine:work", limits=Limits(seconds=600.0)) as pool:
    for result in pool.run(sys.argv[1:]):
        print(*result.value, flush=True)
"""


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "mine.py").write_text(WORK)
    monkeypatch.syspath_prepend(str(tmp_path))
    return "mine:work"


def test_modules_of_others_are_not_kept(work: str, tmp_path: Path) -> None:
    with WorkerPool(work) as pool:
        (result,) = pool.run(["a"])
    assert result.value[1:] == (os.getpid(), True)
    (tmp_path / "mine.py").write_text("def work(item):\n    return 'changed'\n")
    with WorkerPool(work) as pool:
        (result,) = pool.run(["a"])
    assert result.value == "changed"


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere workers end when they answer")
def test_workers_end_with_the_process_that_started_them(work: str) -> None:
    command = [sys.executable, "-c", PARENT, "a", "sleep"]
    path = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=path) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline().split()[0])
        assert is_running(worker)
        parent.kill()
    wait_for_end(worker)


@pytest.mark.skipif(sys.platform != "linux", reason="others have no leases of files")
def test_a_worker_that_never_gets_to_its_program_keeps_nobody_waiting(tmp_path: Path) -> None:
    program = tmp_path / "python"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    with program.open("a") as file:  # who runs it waits until this lease is given back
        fcntl.fcntl(file, fcntl.F_SETSIG, signal.SIGURG)
        fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_WRLCK)
        start = (
            "import signal, sys\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
            f"sys.executable = {str(program)!r}\n"
        )
        path = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        command = [sys.executable, "-c", start + PARENT, "a"]
        with subprocess.Popen(command, stderr=subprocess.DEVNULL, env=path) as parent:
            while not (children := list(_descendants(parent.pid))):
                time.sleep(0.01)
            parent.send_signal(signal.SIGINT)
            assert parent.wait(30.0) == -signal.SIGINT  # after 45 s the system ends the lease
        wait_for_end(*children)


@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")
@pytest.mark.parametrize("how", ["child", "detached"])
def test_what_an_item_has_started_ends_with_its_pool(work: str, how: str) -> None:
    with WorkerPool(work) as pool:
        (result,) = pool.run([how])
        assert all(map(is_running, result.value))
    wait_for_end(*result.value)


def test_what_a_worker_that_died_has_left_ends_with_it(work: str) -> None:
    """Its parent by then is the machine's first process, where nobody would look for it."""
    with WorkerPool(work) as pool:
        (result,) = pool.run(["orphan"])
        assert result.status == "crash"
        wait_for_end(int(result.message.rpartition(" ")[2]))


def test_what_workers_take_counts_as_their_parents(work: str) -> None:
    before = children_seconds()
    path = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    subprocess.run([sys.executable, "-c", PARENT, "burn"], check=True, env=path)
    assert children_seconds() - before > 0.3


def children_seconds() -> float:
    """Return what this process's children have taken of the processors, once waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def wait_for_end(*processes: int) -> None:
    """Wait until none of the processes is there."""
    until = time.monotonic() + 600.0
    while any(map(is_running, processes)) and time.monotonic() < until:
        time.sleep(0.01)
    assert not any(map(is_running, processes))


def is_running(process: int) -> bool:
    """Return whether a process is there and no zombie."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def test_a_process_that_is_stopped_while_it_starts_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = "import os, signal\nos.kill(os.getpid(), signal.SIGSTOP)\n"
    (tmp_path / "stops.py").write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(pool_module, "START_SECONDS", 2.0)
    with (
        WorkerPool("stops:work", limits=Limits(seconds=2.0)) as pool,
        pytest.raises(ShaderlabError) as caught,
    ):
        list(pool.run(["a"]))
    assert "the process was stopped (SIGSTOP)" in caught.value.message


def test_a_stopped_process_is_sent_no_more_than_the_limit_allows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also an item that is larger than what the system keeps for it."""
    text = (
        "import os, signal, threading\n"
        "def work(item):\n"
        "    threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGSTOP)).start()\n"
        "    return os.getpid()\n"
    )
    (tmp_path / "stops.py").write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    with WorkerPool("stops:work", limits=Limits(seconds=1.0)) as pool:
        (first,) = pool.run([b""])
        os.waitid(os.P_PID, first.value, os.WSTOPPED | os.WNOWAIT)
        (result,) = pool.run([bytes(1 << 24)])
    assert result.status == "timeout" and "stopped" in result.message
