"""A fork server: a process without threads or a device that has imported what workers need, and
forks one in a few milliseconds."""

from __future__ import annotations

import atexit
import contextlib
import functools
import itertools
import os
import select
import socket
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, Protocol

from shaderlab.files import memory_file

from .fork_server_main import Ended, Kill, Reap, Start, received, send
from .own_copy import OwnCopy

_PROGRAM = "from shaderlab.workers.fork_server_main import main; main()"
# What Python, the C library and packages read when they start, or that the imports depend on: a
# worker where they differ is another server's.
_AT_START = (
    *("PYTHON", "LD_", "MALLOC_", "GLIBC_", "OPENBLAS_", "OMP_", "MKL_", "NPY_", "PYOPENGL_"),
    *("SHADERLAB_BANDS", "SHADERLAB_GLSLANG"),
)
_PATH = "PYTHONPATH"
END_SECONDS = 5.0


class ServerDiedError(Exception):
    """The server is gone, and with it all of its workers; the message is its last words."""


class Process(Protocol):
    """What a server asks of its process, as of `subprocess.Popen`."""

    @property
    def pid(self) -> int:
        """Its number."""

    def poll(self) -> int | None:
        """Its exit status, or None while it runs."""

    def wait(self) -> int:
        """Its exit status, once it has ended."""

    def kill(self) -> None:
        """End it."""


class ForkServer:
    """A fork server, seen from the process that started it. Any thread may call it.

    Args:
        environment: the environment variables that it starts in.
        work: what it imports, as `shaderlab.workers.worker_main.prepared`; "" for nothing.
        copied: whether it is forked off this process, which has no threads and has imported
            little yet; else it is a Python of its own, which takes longer to start.
        single: whether one worker will do, most likely: a second one then takes longer.

    Raises:
        OSError: it can't be started.
    """

    def __init__(
        self,
        environment: Mapping[str, str],
        work: str,
        *,
        copied: bool = False,
        single: bool = False,
    ) -> None:
        self._lock = threading.Lock()  # a request and its answer are not parted
        self._owner = os.getpid()
        self._numbers = itertools.count()
        self._errors = memory_file()
        self._control, theirs = socket.socketpair()
        with theirs:
            self._process: Process = (
                OwnCopy(environment, theirs, self._errors, close=self._control)
                if copied
                else _started(environment, theirs, self._errors)
            )
        self._send((work, single))

    @property
    def process(self) -> int:
        """Its number."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether it is there to be asked."""
        return self._process.poll() is None

    def start(
        self, folder: Path, environment: Mapping[str, str], path: Sequence[str], files: list[int]
    ) -> int:
        """Have a worker started, without waiting for it; returns the number that it is called.

        Args:
            folder: its working directory.
            environment: its environment variables.
            path: where it looks for modules first.
            files: the descriptors of its socket, its file for steps and its standard error.
        """
        number = next(self._numbers)
        self._send(Start(number, str(folder), dict(environment), list(path)), files)
        return number

    def kill(self, number: int) -> None:
        """End a worker that was not reaped, with all that it has started."""
        self._send(Kill(number))

    def ends(self, number: int, seconds: float) -> bool:
        """Whether a worker ends within so many seconds. Raises ServerDiedError."""
        until = time.monotonic() + seconds
        while not self._ask(Ended(number)):
            if time.monotonic() > until:
                return False
            time.sleep(0.005)
        return True

    def reap(self, number: int) -> int:
        """The exit status of a worker that was killed or has ended, as `subprocess` has it.

        Raises ServerDiedError.
        """
        status: int = self._ask(Reap(number))
        return status

    def close(self) -> None:
        """End it with all its workers, and wait for that: what they took is what this process's
        children took then."""
        if os.getpid() != self._owner:  # a copy of the process that started it
            return
        if next(self._numbers):  # else it has no workers, and is still importing perhaps
            with contextlib.suppress(OSError):
                self._control.shutdown(socket.SHUT_WR)
            select.select([self._control], [], [], END_SECONDS)  # its own is closed as it ends
        self._process.kill()
        self._process.wait()

    def _send(self, message: Any, files: list[int] | None = None) -> None:
        with self._lock, self._whole(), contextlib.suppress(OSError):  # the next question says so
            send(self._control, message, files)

    def _ask(self, question: Any) -> Any:
        try:
            with self._lock, self._whole():
                send(self._control, question)
                return received(self._control)[0]
        except (EOFError, OSError) as error:
            self._process.kill()
            self._process.wait()
            raise ServerDiedError(last_words(self._errors)) from error

    @contextlib.contextmanager
    def _whole(self) -> Iterator[None]:
        """A message that is cut off, as by an interrupt, is the last one."""
        try:
            yield
        except BaseException:
            self._process.kill()
            raise


def _started(environment: Mapping[str, str], control: socket.socket, errors: BinaryIO) -> Process:
    """A Python of its own that runs a server. Raises OSError."""
    import subprocess  # few commands need it

    return subprocess.Popen(
        [sys.executable, "-P", "-c", _PROGRAM, str(control.fileno())],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=errors,
        cwd=os.sep,
        env=dict(environment),
        pass_fds=[control.fileno()],
        process_group=0,
    )


def fork_server(
    environment: Mapping[str, str], work: str, *, copied: bool = False, single: bool = False
) -> ForkServer:
    """The server of this process for workers in this environment, started unless it runs already.

    Modules of others are not imported in it: they may change between two workers. `copied` and
    `single` are as of `ForkServer`.

    Raises:
        OSError: it can't be started.
    """
    if not work.startswith("shaderlab."):
        work = ""
    at_start = {name: text for name, text in environment.items() if name.startswith(_AT_START)}
    del at_start[_PATH]
    key = (os.getpid(), work, tuple(sorted(at_start.items())))
    with _lock():
        servers = _servers()
        found = servers.get(key)
        if found is None or not found.alive:
            servers[key] = found = ForkServer(environment, work, copied=copied, single=single)
            atexit.register(found.close)
    return found


def close_servers() -> None:
    """End all servers of this process; it needs no more workers."""
    with _lock():
        for server in _servers().values():
            server.close()


@functools.cache
def _servers() -> dict[Any, ForkServer]:
    return {}


@functools.cache
def _lock() -> threading.Lock:
    return threading.Lock()


def last_words(errors: BinaryIO) -> str:
    """The last line that a process wrote to its standard error."""
    size = errors.seek(0, os.SEEK_END)
    errors.seek(max(size - 2000, 0))
    lines = errors.read().decode("utf-8", "replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "")
