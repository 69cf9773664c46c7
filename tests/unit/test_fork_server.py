"""Workers are forked from one process, which has neither threads nor a device, and end with it."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from shaderlab.__main__ import _is_of_one_case
from shaderlab.errors import ShaderlabError
from shaderlab.model.options import Limits
from shaderlab.workers import WorkerPool, driver_libraries
from shaderlab.workers.fork_server import fork_server
from shaderlab.workers.pool import ItemResult
from shaderlab.workers.worker_main import LAB_WORK
from shaderlab.workers.worker_process import environment

WORK = """
import os, subprocess, sys, time

def work(items):
    for item in items:
        if item == "die":
            os._exit(3)
        if item == "orphan":
            os.kill(os.getppid(), 9)
        if item in ("sleep", "orphan"):
            time.sleep(600)
        if item == "detach":
            yield subprocess.Popen(["sleep", "600"], start_new_session=True).pid, os.getpid()
            continue
        if item == "burn":
            while time.process_time() < 0.3:
                pass
        yield os.getpid(), os.getppid(), os.environ.get("OMP_PLACES"), "mine" in sys.modules
"""
PARENT = """
import sys
from shaderlab.workers import WorkerPool
from shaderlab.workers.fork_server import fork_server
from shaderlab.workers.worker_process import environment

if sys.argv.pop(1) == "copied":
    fork_server(environment(), "mine:work", copied=True, single=True)
with WorkerPool("mine:work") as pool:
    for result in pool.run(["a", *sys.argv[1:]]):
        print(*result.value, flush=True)
"""


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "mine.py").write_text(WORK)
    monkeypatch.syspath_prepend(str(tmp_path))
    return "mine:work"


def only(results: list[ItemResult]) -> tuple[int, int, str | None, bool]:
    (result,) = results
    found: tuple[int, int, str | None, bool] = result.value
    return found


def test_all_workers_of_all_pools_are_forked_from_one_server(work: str) -> None:
    with WorkerPool(work, batch=1) as pool:
        first, _, second = pool.run(["a", "die", "b"])
    with WorkerPool(work, limits=Limits(seconds=5.0)) as pool:
        third = only(list(pool.run(["c"])))
    servers = {first.value[1], second.value[1], third[1]}
    assert len(servers) == 1 and os.getpid() not in servers
    assert len({first.value[0], second.value[0], third[0]}) == 3


def test_what_python_reads_when_it_starts_takes_a_server_of_its_own(
    work: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with WorkerPool(work) as pool:
        before = only(list(pool.run(["a"])))
    monkeypatch.setenv("OMP_PLACES", "cores")
    with WorkerPool(work) as pool:
        after = only(list(pool.run(["a"])))
    assert after[1] != before[1] and after[2] == "cores"


def test_a_single_worker_is_followed_by_others_where_it_must_be(
    work: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OMP_PLACES", "threads")
    server = fork_server(environment(), work, single=True)
    with WorkerPool(work, batch=1) as pool:
        first, _, second = pool.run(["a", "die", "b"])
    assert first.value[1] == second.value[1] == server.process
    assert first.value[0] != second.value[0]


def test_a_single_worker_imports_by_itself_and_says_what_it_can_not() -> None:
    nothing = "shaderlab.nothing:work"
    server = fork_server(environment(), nothing, single=True)
    with (
        WorkerPool(nothing) as pool,
        pytest.raises(ShaderlabError, match=r"No module named 'shaderlab.nothing'"),
    ):
        list(pool.run(["a"]))
    assert server.alive


def test_a_command_of_one_case_takes_a_single_worker(tmp_path: Path) -> None:
    assert _is_of_one_case(["run", "attenuation[50]", "--size=64"])
    for several in (["--all"], ["mvp", "fog"], [str(tmp_path)]):
        assert not _is_of_one_case(["run", *several])
    assert not _is_of_one_case(["sweep", "mvp"])


def test_modules_of_others_are_not_kept(work: str, tmp_path: Path) -> None:
    with WorkerPool(work) as pool:
        assert len(only(list(pool.run(["a"])))) == 4
    (tmp_path / "mine.py").write_text(
        "def work(items):\n    yield from ('changed' for _ in items)\n"
    )
    with WorkerPool(work) as pool:
        (result,) = pool.run(["a"])
    assert result.value == "changed"


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="threads are looked up in /proc")
def test_the_server_of_labs_has_one_thread_and_no_device() -> None:
    """A thread would not be copied, and what it holds stays held; of a context two would draw. The
    driver's libraries are there, and nothing that opening it maps."""
    made = environment()
    server = fork_server(made, LAB_WORK)
    server.ends(-1, 0.0)  # it answers when it has imported everything
    number = server.process
    assert len(os.listdir(f"/proc/{number}/task")) == 1
    mapped = Path(f"/proc/{number}/maps").read_text()
    assert "mgl" in mapped and "_umath" in mapped
    assert "_dri.so" in mapped or "libgallium" in mapped
    assert "mesa_shader_cache" not in mapped


@pytest.mark.parametrize(("driver", "loads"), [("llvmpipe", True), ("lavapipe", False)])
def test_only_the_driver_that_is_meant_is_loaded(
    driver: str, loads: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    tasks: list[object] = []
    monkeypatch.setattr(driver_libraries, "_load", lambda: tasks.append(1))
    monkeypatch.setenv("SHADERLAB_DRIVER", driver)
    thread = driver_libraries.load()
    if thread is not None:
        thread.join()
    assert bool(tasks) == loads


def test_a_server_that_died_is_said_and_started_anew(work: str) -> None:
    with WorkerPool(work, batch=1) as pool:
        lost, after = pool.run(["orphan", "b"])
        assert lost.status == "crash" and "starts workers died" in lost.message
        os.kill(after.value[1], signal.SIGKILL)
        gone(after.value[0])
        assert only(list(pool.run(["c"])))[1] != after.value[1]


@pytest.mark.parametrize("how", ["started", "copied"])
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere workers end when they answer")
def test_workers_and_what_they_started_end_with_the_process_that_asked_for_them(
    work: str, how: str
) -> None:
    command = [sys.executable, "-c", PARENT, how, "detach", "sleep"]
    path = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=path) as parent:
        assert parent.stdout is not None
        worker, server = map(int, parent.stdout.readline().split()[:2])
        detached, _ = map(int, parent.stdout.readline().split())
        assert running(detached)
        parent.kill()
    gone(worker, server, detached)


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="descriptors are looked up in /proc")
def test_a_copy_is_asked_for_once_and_has_nothing_of_the_process_it_was_made_of(
    work: str, tmp_path: Path
) -> None:
    (tmp_path / "mine.py").write_text(
        "import __main__, os, signal, sys\n"
        "def work(items):\n"
        "    here = os.getppid(), os.readlink('/proc/self/fd/0'), os.readlink('/proc/self/fd/1')\n"
        "    secret = vars(__main__).get('secret')\n"
        "    yield *here, sys.argv[1:], secret, signal.getsignal(2) == signal.SIG_IGN\n"
    )
    program = "secret = 1\n" + PARENT + "    print(pool._workers[0].process._server.process)\n"
    command = [sys.executable, "-c", program, "copied"]
    path = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(command, check=True, env=path, capture_output=True, text=True)
    first, server = done.stdout.splitlines()
    null = os.devnull
    assert first == f"{server} {null} {null} [] None True" and not done.stderr


@pytest.mark.parametrize("how", ["started", "copied"])
def test_what_workers_take_counts_as_their_parents(work: str, how: str) -> None:
    before = childrens_seconds()
    path = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    subprocess.run([sys.executable, "-c", PARENT, how, "burn"], check=True, env=path)
    assert childrens_seconds() - before > 0.3


def childrens_seconds() -> float:
    """What this process's children have taken of the processors, once they were waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def gone(*processes: int) -> None:
    """Wait until none of the processes is there."""
    until = time.monotonic() + 10.0
    while any(map(running, processes)) and time.monotonic() < until:
        time.sleep(0.01)
    assert not any(map(running, processes))


def running(process: int) -> bool:
    """Whether a process is there and no zombie."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False
