"""One worker process, seen from its parent: started, fed, watched, killed, replaced."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Literal

from shaderlab.errors import ShaderlabError
from shaderlab.files import open_memory_file, sort_search_path
from shaderlab.model.options import Limits

from .worker import STEP_BYTES

START_SECONDS = 120.0
END_SECONDS = 5.0
GROWTH = 256 << 20
"""A worker that holds this many bytes more than after its first batch is replaced by a fresh one
before its next batch: drivers keep a little of every scene."""
# Libraries for matrices and pictures start a thread per core and let all of them wait busily;
# workers share the cores already, and multiply matrices of four rows.
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
_PROGRAM = "from shaderlab.workers.worker import main; main()"


def worker_environment() -> dict[str, str]:
    """Return the environment of a worker: this process's as it is now, with its module path."""
    path = os.pathsep.join(sort_search_path(sys.path))
    return {**_ONE_THREAD, **os.environ, "PYTHONPATH": path}


@dataclass(eq=False)
class WorkerDiedError(Exception):
    """A worker is gone.

    Attributes:
        status: "crash" or "timeout".
        message: how it ended.
        step: the last step that it noted, "" if there was none.
        fresh: whether it had answered nothing yet.
    """

    status: Literal["crash", "timeout"]
    message: str
    step: str
    fresh: bool


class WorkerProcess:
    """A worker that answers batches, as `shaderlab.workers.pool.WorkerPool` says.

    It is started with the first batch, and again with the first one after it died. One thread uses
    it; any thread may call `close`.
    """

    def __init__(
        self, work: str, limits: Limits, folder: Path, environment: Mapping[str, str]
    ) -> None:
        self._work = work
        self._limits = limits
        self._folder = folder
        self._environment = environment
        self._lock = threading.Lock()  # for the three below
        self._closed = False
        self._process: subprocess.Popen[bytes] | None = None
        self._streams: Sequence[Any] = ()
        self._ready = False
        self._fresh = True
        self._memory = 0  # after the first batch

    def answers(self, batch: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
        """Yield an answer for each item, in order, each as soon as it is there.

        Raises:
            WorkerDiedError: it crashed or took too long over the item after the last one answered.
            ShaderlabError: no worker can be started at all.
        """
        if self._has_grown():
            self._end()
        self.start()
        self._send(batch)
        for _ in batch:
            kind, value = self._receive(self._limits.seconds)
            while kind == "limit":
                kind, value = self._receive(value)
            self._fresh = False
            yield kind, value
            if kind == "error":
                break
        if self._process is not None and not self._memory:
            self._memory = _own_memory(self._process.pid)

    def _has_grown(self) -> bool:
        if self._process is None or not self._memory:
            return False
        return _own_memory(self._process.pid) - self._memory > GROWTH

    def launch(self) -> None:
        """Start the process, if there is none, without waiting until it is ready."""
        with self._lock:
            if self._process is not None:
                return
            if self._closed:
                raise ShaderlabError("the pool of workers is closed")
            self._ready, self._fresh, self._memory = False, True, 0
            try:
                self._start_process()
            except OSError as error:
                raise ShaderlabError(
                    f"can't start a worker process: {error.strerror or error}",
                    remedy="see what limits this system has: ulimit -a",
                ) from error
        memory = int(self._limits.gigabytes * (1 << 30))
        self._send((self._work, self._limits.seconds, memory))

    def start(self) -> None:
        """Start the process, if there is none, and wait until it is ready.

        Raises:
            ShaderlabError: none can be started.
        """
        self.launch()
        if self._ready:
            return
        try:
            self._receive(START_SECONDS)
        except WorkerDiedError as error:
            raise ShaderlabError(
                f"can't start a worker process: {error.message}",
                remedy="see that this Python can import shaderlab: run `shaderlab doctor`",
            ) from error
        self._ready = True

    def close(self) -> None:
        """End the process, whatever it is doing, and start no other one."""
        with self._lock:
            self._closed = True
            if self._process is not None:
                _kill_group(self._process)

    def release(self) -> None:
        """Give everything back, once no thread waits for the process."""
        self._end()

    def _start_process(self) -> None:
        self._socket, theirs = socket.socketpair()
        self._answers = self._socket.makefile("rb")
        # Both live as long as the process, and take no space on a disk that may be full.
        self._errors, self._steps = open_memory_file(), open_memory_file()
        self._steps.truncate(STEP_BYTES)
        self._streams = (self._answers, self._socket, self._errors, self._steps)
        inherited = [theirs.fileno(), self._steps.fileno()]
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", _PROGRAM, *map(str, [*inherited, os.getpid()])],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._errors,
                cwd=self._folder,
                env=dict(self._environment),
                pass_fds=inherited,
                process_group=0,  # so that what it starts can be ended with it
            )

    def _end(self) -> int:
        """End the process and close its streams; return its exit status."""
        with self._lock:
            process, self._process = self._process, None
            streams, self._streams = self._streams, ()
            if process is not None:
                _kill_group(process)
                process.wait()
        for stream in streams:
            stream.close()
        return 0 if process is None else process.returncode

    def _send(self, value: Any) -> None:
        self._socket.settimeout(None)
        with contextlib.suppress(OSError):  # it is gone then; reading its answer says how
            self._socket.sendall(pickle.dumps(value, pickle.HIGHEST_PROTOCOL))

    def _receive(self, seconds: float) -> tuple[Any, Any]:
        self._socket.settimeout(seconds)
        try:
            answer: tuple[Any, Any] = pickle.load(self._answers)
        except TimeoutError:
            raise self._died(seconds, late=True) from None
        except (EOFError, OSError, pickle.UnpicklingError):
            raise self._died(seconds) from None
        except Exception as error:  # an exception's own class may raise when it is unpickled
            return "error", TypeError(f"can't be received: {error}")
        return answer

    def _died(self, seconds: float, late: bool = False) -> WorkerDiedError:
        """Return how the process ended, once it is gone with everything that it started."""
        assert self._process is not None
        ended = not late and _wait_for_end(self._process.pid)
        _kill_group(self._process)  # before its last line is read
        step, last_line = self._noted_step(), last_stderr_line(self._errors)
        code = self._end()
        if late or -code == signal.SIGALRM:
            return WorkerDiedError("timeout", f"took longer than {seconds:g} s", step, self._fresh)
        how = f"exit status {code}"
        if not ended:
            how = "it closed its connection, but did not end"
        elif code < 0:
            how = f"signal {-code}"
            with contextlib.suppress(ValueError):
                how += f" ({signal.Signals(-code).name})"
        message = f"the process died: {how}" + (f", {last_line}" if last_line else "")
        return WorkerDiedError("crash", message, step, self._fresh)

    def _noted_step(self) -> str:
        self._steps.seek(0)
        return self._steps.read(STEP_BYTES).rstrip(b"\0").decode("utf-8", "ignore")


def last_stderr_line(errors: BinaryIO) -> str:
    """Return the last line that a process wrote to its standard error."""
    size = errors.seek(0, os.SEEK_END)
    errors.seek(max(size - 2000, 0))
    lines = errors.read().decode("utf-8", "replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    """Kill a process that was not waited for, with everything in its group."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)


def _wait_for_end(process: int) -> bool:
    """Wait a little until a process has ended; return whether it has.

    Its id stays taken, so that its group can still be killed.
    """
    until = time.monotonic() + END_SECONDS
    while os.waitid(os.P_PID, process, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
        if time.monotonic() > until:
            return False
        time.sleep(0.005)
    return True


def _own_memory(process: int) -> int:
    """Return the bytes of memory that a process shares with no file; 0 where the system has no
    /proc."""
    try:
        with open(f"/proc/{process}/statm", "rb", buffering=0) as file:
            _, resident, shared, *_ = map(int, file.read().split())
    except (OSError, ValueError):
        return 0
    return (resident - shared) * os.sysconf("SC_PAGE_SIZE")
