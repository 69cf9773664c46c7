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
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from shaderlab.errors import ShaderlabError

START_SECONDS = 120.0
_TICK = 0.05
# glibc gives large arrays back to the system one by one, and pays for each page when it takes
# them again; a worker makes arrays of the same sizes all the time.
_KEEP_MEMORY = dict.fromkeys(("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"), str(1 << 25))
# NumPy's library for matrices starts a thread a core and has them all wait busily; workers share
# the cores already, and multiply matrices of four rows.
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}
_PROGRAM = "from shaderlab.workers.serving import serve; serve()"


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What one item may take: seconds of time, bytes of address space (0 for any amount).

    The memory limit holds where the system has one for processes (Linux, not Windows).
    """

    seconds: float = 10.0
    memory: int = 4 << 30


def environment() -> dict[str, str]:
    """The environment of a worker: this process's as it is now, with the modules it finds now."""
    path = [os.path.abspath(entry) if entry else os.getcwd() for entry in sys.path]
    return {**_KEEP_MEMORY, **_ONE_THREAD, **os.environ, "PYTHONPATH": os.pathsep.join(path)}


class DiedError(Exception):
    """A worker is gone; `status` is "crash" or "timeout", the message says how."""

    def __init__(self, status: Literal["crash", "timeout"], message: str) -> None:
        self.status: Literal["crash", "timeout"] = status
        self.message = message
        super().__init__(message)


class Process:
    """A worker that answers batches by calling `work`, a function named "module:function".

    It is started with the first batch, and again with the first one after it died. `folder` is its
    working directory, `environment` what `environment` gives. `warm` is a function that it calls
    before it imports `work`; what that gives back is called when `work` is there.
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
        self._deadline = _Deadline()
        self._ready = False
        self.fresh = True  # whether it has answered nothing yet

    def answers(self, batch: Sequence[Any]) -> Iterator[tuple[str, Any]]:
        """An answer for each item, in order, each as soon as it is there.

        Raises:
            DiedError: it crashed or took too long over the item after the last one answered.
            ShaderlabError: no worker can be started at all.
        """
        self.start()
        self._send(batch)
        for _ in batch:
            kind, value = self._receive(self._limits.seconds)
            self.fresh = False
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

    def close(self) -> None:
        """End the process, whatever it is doing."""
        self._deadline.close()
        self._end()

    def _launch(self) -> None:
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 — lives as long as the child
        self._child = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            cwd=self._folder,
            env=self._environment,
        )
        self._ready = False
        self.fresh = True
        self._send((self._work, self._warm, self._limits.seconds, self._limits.memory))

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

    def _receive(self, seconds: float) -> tuple[str, Any]:
        assert self._child is not None and self._child.stdout is not None
        self._deadline.set(self._child, seconds)
        try:
            answer: tuple[str, Any] = pickle.load(self._child.stdout)
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
        self._child.kill()
        code = self._child.wait()
        said = self._said()
        self._end()
        if late or -code == getattr(signal, "SIGALRM", None):
            return DiedError("timeout", f"took longer than {seconds:g} s")
        if code < 0:
            try:
                how = f"signal {-code} ({signal.Signals(-code).name})"
            except ValueError:
                how = f"signal {-code}"
        else:
            how = f"exit status {code}"
        return DiedError("crash", f"the process died: {how}" + (f", {said}" if said else ""))

    def _said(self) -> str:
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
        streams: tuple[Any, ...] = (self._child.stdin, self._child.stdout, self._errors)
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
