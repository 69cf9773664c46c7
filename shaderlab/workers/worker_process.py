"""One worker process, seen from its parent: started, fed, watched, killed, replaced."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import socket
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from shaderlab.engine.module_path import pythons_first
from shaderlab.errors import ShaderlabError
from shaderlab.files import memory_file
from shaderlab.model.options import Limits

from .fork_server import ForkServer, ServerDiedError, fork_server, last_words
from .worker_main import LAB_WORK, STEP_BYTES

START_SECONDS = 120.0
END_SECONDS = 5.0
# glibc gives large arrays back to the system one by one, and pays for each page when it takes
# them again; a worker makes arrays of the same sizes all the time.
_KEEP_MEMORY = dict.fromkeys(("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"), str(1 << 25))
# Libraries for matrices and pictures start a thread a core and have them all wait busily; workers
# share the cores already, and multiply matrices of four rows.
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def environment() -> dict[str, str]:
    """The environment of a worker: this process's as it is now, with the modules it finds now.

    Python's own come first, and the working folder is none of them unless it is here.
    """
    path = pythons_first(sys.path)
    return {**_KEEP_MEMORY, **_ONE_THREAD, **os.environ, "PYTHONPATH": os.pathsep.join(path)}


def begin_server(single: bool) -> None:
    """Start what workers of labs are forked from before anything asks for one: it imports what they
    need while this process, which has imported little and has one thread, does the same. With
    `single` it is told that one worker will do.

    Nothing happens where it can't be started: the first worker says so.
    """
    with contextlib.suppress(OSError):
        fork_server(environment(), LAB_WORK, copied=True, single=single)


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
    """A worker that answers batches, as `shaderlab.workers.pool.WorkerPool` says.

    It is started with the first batch, and again with the first one after it died.
    """

    def __init__(
        self, work: str, limits: Limits, folder: Path, environment: Mapping[str, str]
    ) -> None:
        self._work = work
        self._limits = limits
        self._folder = folder
        self._environment = environment
        self._path = environment.get("PYTHONPATH", "").split(os.pathsep)
        self._server: ForkServer | None = None  # while there is a process
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
        if self._server is not None:
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
        self._send((self._work, self._limits.seconds, memory))

    def _begin(self) -> None:
        """Have the process started. Raises OSError."""
        server = fork_server(self._environment, self._work)
        self._socket, theirs = socket.socketpair()
        self._answers = self._socket.makefile("rb")
        # Both live as long as the process, and need no room on a disk that may be full.
        self._errors = memory_file()
        self._steps = memory_file()
        self._steps.truncate(STEP_BYTES)
        with theirs:
            files = [theirs.fileno(), self._steps.fileno(), self._errors.fileno()]
            self._number = server.start(self._folder, self._environment, self._path, files)
        self._server = server

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
        server = self._server
        if server is not None:
            server.kill(self._number)

    def close(self) -> None:
        """End the process, and give everything back; for a time when no thread waits for it."""
        with contextlib.suppress(ServerDiedError):
            self._end()

    def _end(self) -> int:
        """As `close`; returns its exit status. Raises ServerDiedError when everything is back."""
        if self._server is None:
            return 0
        server, self._server = self._server, None
        server.kill(self._number)
        try:
            return server.reap(self._number)
        finally:
            for stream in (self._answers, self._socket, self._errors, self._steps):
                stream.close()

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
        assert self._server is not None
        try:
            # It is ending, and its exit status says how.
            ended = not late and self._server.ends(self._number, END_SECONDS)
            self._server.kill(self._number)  # before its last words are read
            step, said = self._noted(), last_words(self._errors)
            code = self._end()
        except ServerDiedError as error:
            self.close()
            what = f"the process that starts workers died, {error}".rstrip(", ")
            return DiedError("crash", what, "", self._fresh)
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

    def _noted(self) -> str:
        self._steps.seek(0)
        return self._steps.read(STEP_BYTES).rstrip(b"\0").decode("utf-8", "ignore")
