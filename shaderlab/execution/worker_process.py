"""One worker process, seen from its parent: started, fed, watched, killed, replaced."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from shaderlab.errors import ShaderlabError
from shaderlab.execution.worker_main import STEP_BYTES
from shaderlab.files import memory_file
from shaderlab.module_path import pythons_first
from shaderlab.options import Limits

START_SECONDS = 120.0
END_SECONDS = 5.0
# glibc gives large arrays back to the system one by one, and pays for each page when it takes
# them again; a worker makes arrays of the same sizes all the time.
_KEEP_MEMORY = dict.fromkeys(("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"), str(1 << 25))
# NumPy's library for matrices starts a thread a core and has them all wait busily; workers share
# the cores already, and multiply matrices of four rows.
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}
_PROGRAM = "from shaderlab.execution.worker_main import main; main()"


def environment() -> dict[str, str]:
    """The environment of a worker: this process's as it is now, with the modules it finds now.

    Python's own come first, and the working folder is none of them unless it is here.
    """
    path = pythons_first(sys.path)
    return {**_KEEP_MEMORY, **_ONE_THREAD, **os.environ, "PYTHONPATH": os.pathsep.join(path)}


@dataclass(eq=False)
class DiedError(Exception):
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
    """A worker that answers batches, as `shaderlab.execution.pool.WorkerPool` says.

    It is started with the first batch, and again with the first one after it died.
    """

    def __init__(
        self, work: str, limits: Limits, folder: Path, environment: Mapping[str, str], warm: str
    ) -> None:
        self._work = work
        self._warm = warm
        self._limits = limits
        self._folder = folder
        self._environment = environment
        self._child: subprocess.Popen[bytes] | None = None
        self._ready = False
        self._fresh = True

    def answers(self, batch: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
        """An answer for each item, in order, each as soon as it is there.

        Raises:
            DiedError: it crashed or took too long over the item after the last one answered.
            ShaderlabError: no worker can be started at all.
        """
        self.start()
        self._send(batch)
        for _ in batch:
            kind, value = self._receive(self._limits.seconds)
            while kind == "limit":
                kind, value = self._receive(value)
            self._fresh = False
            yield kind, value
            if kind == "error":
                return

    def launch(self) -> None:
        """Start the process, if there is none; it gets ready while this one goes on."""
        if self._child is not None:
            return
        self._ready, self._fresh = False, True
        try:
            self._begin()
        except OSError as error:
            raise ShaderlabError(
                f"can't start a worker process: {error.strerror or error}",
                remedy="see what limits this system has: ulimit -a",
            ) from error
        memory = int(self._limits.gigabytes * (1 << 30))
        steps = self._steps.fileno()
        self._send((self._work, self._warm, self._limits.seconds, memory, steps))

    def _begin(self) -> None:
        """Start the process itself. Raises OSError."""
        self._socket, theirs = socket.socketpair()
        self._answers = self._socket.makefile("rb")
        # Both live as long as the child, and need no room on a disk that may be full.
        self._errors = memory_file()
        self._steps = memory_file()
        self._steps.truncate(STEP_BYTES)
        with theirs:
            self._child = subprocess.Popen(
                [sys.executable, "-P", "-c", _PROGRAM, str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._errors,
                cwd=self._folder,
                env=self._environment,
                pass_fds=[theirs.fileno(), self._steps.fileno()],
                process_group=0,
            )

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
        except DiedError as error:
            raise ShaderlabError(
                f"can't start a worker process: {error.message}",
                remedy="see that this Python can import shaderlab: run `shaderlab doctor`",
            ) from error
        self._ready = True

    def kill(self) -> None:
        """End the process, whatever it is doing; any thread may do that."""
        child = self._child
        if child is not None:
            _kill(child)

    def close(self) -> None:
        """End the process, and give everything back; for a time when no thread waits for it."""
        if self._child is not None:
            _kill(self._child)
            self._child.wait()
            for stream in (self._answers, self._socket, self._errors, self._steps):
                stream.close()
            self._child = None

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
        except Exception as error:  # what an exception's own class raises when it is made again
            return "error", TypeError(f"can't be received: {error}")
        return answer

    def _died(self, seconds: float, late: bool = False) -> DiedError:
        assert self._child is not None
        # It is ending, and its exit status says how.
        ended = not late and _ends(self._child, END_SECONDS)
        _kill(self._child)
        code = self._child.wait()
        self._steps.seek(0)
        step = self._steps.read(STEP_BYTES).rstrip(b"\0").decode("utf-8", "ignore")
        said = self._last_words()
        self.close()
        if late or -code == signal.SIGALRM:
            return DiedError("timeout", f"took longer than {seconds:g} s", step, self._fresh)
        how = f"exit status {code}"
        if not ended:
            how = "it closed its connection, but did not end"
        elif code < 0:
            how = f"signal {-code}"
            with contextlib.suppress(ValueError):
                how += f" ({signal.Signals(-code).name})"
        message = f"the process died: {how}" + (f", {said}" if said else "")
        return DiedError("crash", message, step, self._fresh)

    def _last_words(self) -> str:
        """The last line that the process wrote to its standard error."""
        size = self._errors.seek(0, os.SEEK_END)
        self._errors.seek(max(size - 2000, 0))
        lines = self._errors.read().decode("utf-8", "replace").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "")


def _ends(child: subprocess.Popen[bytes], seconds: float) -> bool:
    """Whether the process ends within so many seconds. Its number stays taken until `wait`, so
    that its group can still be ended."""
    until = time.monotonic() + seconds
    while os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
        if time.monotonic() > until:
            return False
        time.sleep(0.005)
    return True


def _kill(child: subprocess.Popen[bytes]) -> None:
    """End the process with all that it has started."""
    if child.returncode is None:  # else the number of its group may be another's
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(child.pid, signal.SIGKILL)
