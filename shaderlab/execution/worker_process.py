"""One worker process, seen from its parent: started, fed, watched, killed, replaced."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from shaderlab.errors import ShaderlabError
from shaderlab.execution.worker_main import STEP_BYTES
from shaderlab.options import Limits

START_SECONDS = 120.0
_TICK = 0.05
# glibc gives large arrays back to the system one by one, and pays for each page when it takes
# them again; a worker makes arrays of the same sizes all the time.
_KEEP_MEMORY = dict.fromkeys(("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"), str(1 << 25))
# NumPy's library for matrices starts a thread a core and has them all wait busily; workers share
# the cores already, and multiply matrices of four rows.
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}
_PROGRAM = "from shaderlab.execution.worker_main import main; main()"


def environment() -> dict[str, str]:
    """The environment of a worker: this process's as it is now, with the modules it finds now."""
    path = [os.path.abspath(entry) if entry else os.getcwd() for entry in sys.path]
    return {**_KEEP_MEMORY, **_ONE_THREAD, **os.environ, "PYTHONPATH": os.pathsep.join(path)}


class DiedError(Exception):
    """A worker is gone.

    Attributes:
        status: "crash" or "timeout".
        message: how it ended.
        step: the last step that it noted, "" if there was none.
        fresh: whether it had answered nothing yet.
    """

    def __init__(
        self, status: Literal["crash", "timeout"], message: str, step: str, fresh: bool
    ) -> None:
        self.status = status
        self.message = message
        self.step = step
        self.fresh = fresh
        super().__init__(message)


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
        self._errors: Any = None
        self._steps: Any = None
        self._deadline = _Deadline()
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
        if self._child is None:
            self._launch()

    def start(self) -> None:
        """Start the process, if there is none, and wait until it is ready.

        Raises:
            ShaderlabError: none can be started.
        """
        self.launch()
        if not self._ready:
            self._wait_until_ready()

    def kill(self) -> None:
        """End the process, whatever it is doing; any thread may do that."""
        child = self._child
        if child is not None:
            child.kill()

    def close(self) -> None:
        """End the process, and give everything back; for a time when no thread waits for it."""
        self._deadline.close()
        self._end()

    def _launch(self) -> None:
        # Both live as long as the child.
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        self._steps = tempfile.TemporaryFile()  # noqa: SIM115
        self._steps.truncate(STEP_BYTES)
        steps = self._steps.fileno() if os.name == "posix" else -1
        self._child = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            cwd=self._folder,
            env=self._environment,
            pass_fds=[steps] if steps >= 0 else [],
        )
        self._ready = False
        self._fresh = True
        memory = int(self._limits.gigabytes * (1 << 30))
        self._send((self._work, self._warm, self._limits.seconds, memory, steps))

    def _wait_until_ready(self) -> None:
        try:
            self._receive(START_SECONDS)
        except DiedError as error:
            raise ShaderlabError(
                f"can't start a worker process: {error.message}",
                remedy="see that this Python can import shaderlab: run `shaderlab doctor`",
            ) from error
        self._ready = True

    def _send(self, value: Any) -> None:
        assert self._child is not None and self._child.stdin is not None
        with contextlib.suppress(OSError):  # it is gone then; reading its answer says how
            pickle.dump(value, self._child.stdin, pickle.HIGHEST_PROTOCOL)
            self._child.stdin.flush()

    def _receive(self, seconds: float) -> tuple[Any, Any]:
        assert self._child is not None and self._child.stdout is not None
        self._deadline.set(self._child, seconds)
        try:
            answer: tuple[Any, Any] = pickle.load(self._child.stdout)
        except (EOFError, OSError, pickle.UnpicklingError):
            raise self._died(seconds) from None
        except Exception as error:  # what an exception's own class raises when it is made again
            answer = ("error", TypeError(f"can't be received: {error}"))
        finally:
            self._deadline.clear()
        return answer

    def _died(self, seconds: float) -> DiedError:
        assert self._child is not None
        late = self._deadline.passed
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._child.wait(0.0 if late else 5.0)  # it is ending, and its exit status says how
        self._child.kill()
        code = self._child.wait()
        said, step = self._last_words(), self._last_step()
        self._end()
        if late or -code == getattr(signal, "SIGALRM", None):
            return DiedError("timeout", f"took longer than {seconds:g} s", step, self._fresh)
        if code < 0:
            try:
                how = f"signal {-code} ({signal.Signals(-code).name})"
            except ValueError:
                how = f"signal {-code}"
        else:
            how = f"exit status {code}"
        message = f"the process died: {how}" + (f", {said}" if said else "")
        return DiedError("crash", message, step, self._fresh)

    def _last_step(self) -> str:
        self._steps.seek(0)
        raw: bytes = self._steps.read(STEP_BYTES)
        return raw.rstrip(b"\0").decode("utf-8", "ignore")

    def _last_words(self) -> str:
        """The last line that the process wrote to its standard error."""
        size = self._errors.seek(0, os.SEEK_END)
        self._errors.seek(max(size - 2000, 0))
        lines = self._errors.read().decode("utf-8", "replace").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "")

    def _end(self) -> None:
        if self._child is None:
            return
        self._child.kill()
        self._child.wait()
        streams: tuple[Any, ...] = (
            self._child.stdin,
            self._child.stdout,
            self._errors,
            self._steps,
        )
        for stream in streams:
            with contextlib.suppress(OSError):
                stream.close()
        self._child = None


class _Deadline:
    """Kills a process that does not answer in time. One thread looks at the clock now and then,
    which costs less than a timer for each item."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._watched: tuple[subprocess.Popen[bytes], float] | None = None
        self._closed = threading.Event()
        self._thread: threading.Thread | None = None
        self.passed = False

    def set(self, child: subprocess.Popen[bytes], seconds: float) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._watch, daemon=True)
            self._thread.start()
        with self._lock:
            self.passed = False
            self._watched = (child, time.monotonic() + seconds)

    def clear(self) -> None:
        with self._lock:
            self._watched = None

    def close(self) -> None:
        self._closed.set()

    def _watch(self) -> None:
        while not self._closed.wait(_TICK):
            with self._lock:
                if self._watched is not None and time.monotonic() > self._watched[1]:
                    self.passed = True
                    self._watched[0].kill()
                    self._watched = None
