"""The fork server's side: import what workers need once, then fork a worker for each request."""

from __future__ import annotations

import contextlib
import gc
import importlib
import os
import pickle
import select
import signal
import socket
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import driver_libraries, worker_main

HEADER = 8
"""Bytes that say how long the message after them is."""
CHECK_SECONDS = 5.0
"""The server sees so often that its parent is still there."""
NOT_FORKED = 1
"""The exit status of a worker that there was no room for."""


@dataclass(frozen=True)
class Start:
    """Asks for a worker; the descriptors of its socket, its file of steps and its standard error
    come with the message.

    Attributes:
        number: what the worker is called in later requests.
        folder: its working directory.
        environment: its environment variables, all of them.
        path: where it looks for modules, before the places that every Python looks at.
    """

    number: int
    folder: str
    environment: dict[str, str]
    path: list[str]


@dataclass(frozen=True)
class Kill:
    """Asks to end a worker with all that it has started."""

    number: int


@dataclass(frozen=True)
class Ended:
    """Asks whether a worker has ended: a bool."""

    number: int


@dataclass(frozen=True)
class Reap:
    """Asks for the exit status of a worker that was killed or has ended: a negative signal's number
    where that ended it."""

    number: int


def main() -> None:
    """Serve the socket whose descriptor is the program's argument, as `serve`."""
    serve(socket.socket(fileno=int(sys.argv.pop())))


def serve(control: socket.socket) -> None:
    """Serve a socket until its other end is closed.

    The first message says what to import (see `worker_main.prepared`), and whether one worker will
    do; `Start`, `Kill`, `Ended` and `Reap` follow. In a worker this function goes on as its own.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what an interrupt means
    worker_main.adopt_orphans()
    (work, single), _ = received(control)
    as_worker = _Server(control, work).run(single)
    if as_worker is None:
        os._exit(0)  # what was imported is not worth taking down
    as_worker()


class _Server:
    """The workers that were forked, by number; one that could not be is an exit status."""

    def __init__(self, control: socket.socket, work: str) -> None:
        self._control = control
        self._work = work  # what is still to be imported
        self._early: tuple[int, socket.socket] | None = None
        own = os.environ.get("PYTHONPATH", "").split(os.pathsep)
        self._everywhere = [folder for folder in sys.path if folder not in own]
        self._process, self._parent = os.getpid(), os.getppid()
        self._workers: dict[int, int] = {}
        self._lost: dict[int, int] = {}

    def run(self, single: bool) -> Callable[[], None] | None:
        """Answer requests. Returns, in a worker, what it has to do; None when all is over.

        Where a `single` worker will do, it is forked before anything is imported: what it imports
        is its own then, and it copies no page of it. Others are forked when all is imported.
        """
        if single:
            child = self._fork_early()
            if child is not None:
                return child
        else:
            self._prepare()
        while True:
            try:
                self._wait()
                request, descriptors = received(self._control)
            except (EOFError, OSError):
                for number in list(self._workers):
                    self._kill(number)
                    self._reap(number)
                _end_children()
                return None
            if isinstance(request, Start):
                child = self._fork(request, descriptors)
                if child is not None:
                    return child
            elif isinstance(request, Kill):
                self._kill(request.number)
            elif isinstance(request, Ended):
                send(self._control, self._ended(request.number))
            elif isinstance(request, Reap):
                send(self._control, self._reap(request.number))

    def _wait(self) -> None:
        """Wait for a request. Raises EOFError where the parent is gone, though a copy of it may
        hold the other end."""
        while not select.select([self._control], [], [], CHECK_SECONDS)[0]:
            if os.getppid() != self._parent:
                raise EOFError

    def _prepare(self) -> None:
        """Import the work, unless that is done."""
        work, self._work = self._work, ""
        loading = None
        if work == worker_main.LAB_WORK:
            gc.disable()  # as `prepared` does
            import numpy  # noqa: F401 - one library is loaded at a time: NumPy's would wait

            loading = driver_libraries.load()
        if work:
            worker_main.prepared(work)
        if loading is not None:
            loading.join()  # a copy of this process has no other thread, and its locks for good

    def _fork_early(self) -> Callable[[], None] | None:
        """Fork the first worker; as `run`."""
        ours, theirs = socket.socketpair()
        process = os.fork()
        if process:
            theirs.close()
            self._early = process, ours
            return None

        def work() -> None:
            worker_main.die_with_parent(self._process)
            ours.close()
            self._control.close()
            trouble = ""
            try:
                self._prepare()
            except Exception:
                trouble = traceback.format_exc()
            try:
                request, descriptors = received(theirs)
            except (EOFError, OSError):  # none is wanted
                os._exit(0)
            if trouble:
                os.write(descriptors[-1], trouble.encode())
                os._exit(1)
            self._become(request, *descriptors)

        return work

    def _taken_early(self, request: Start, descriptors: list[int]) -> int:
        """The process that was forked early, if it is there and has no work yet, or 0."""
        if self._early is not None:
            (process, channel), self._early = self._early, None
            with channel, contextlib.suppress(OSError):
                send(channel, request, descriptors)
                return process
        return 0

    def _fork(self, request: Start, descriptors: list[int]) -> Callable[[], None] | None:
        parent, steps, errors = descriptors
        try:
            process = self._taken_early(request, descriptors)
            if not process:
                self._prepare()
                process = os.fork()
        except OSError:
            os.write(errors, traceback.format_exc().encode())
            self._lost[request.number] = NOT_FORKED
        else:
            if process == 0:
                return lambda: self._become(request, parent, steps, errors)
            self._workers[request.number] = process
            with contextlib.suppress(OSError):  # the worker has done so itself by now
                os.setpgid(process, process)
        for descriptor in descriptors:
            os.close(descriptor)
        return None

    def _become(self, request: Start, parent: int, steps: int, errors: int) -> None:
        """Turn a fresh copy of this process into a worker, and do its work."""
        os.setpgid(0, 0)
        self._control.close()
        os.dup2(errors, 2)
        os.close(errors)
        worker_main.die_with_parent(self._process)
        os.chdir(request.folder)
        os.environ.clear()
        os.environ.update(request.environment)
        sys.path[:] = dict.fromkeys([*request.path, *self._everywhere])
        importlib.invalidate_caches()
        worker_main.main(parent, steps)

    def _kill(self, number: int) -> None:
        if number in self._workers:  # not reaped: the number of its group is not another's
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._workers[number], signal.SIGKILL)

    def _ended(self, number: int) -> bool:
        """Its number stays taken until it is reaped, so that its group can still be ended."""
        if number not in self._workers:
            return True
        wanted = os.WEXITED | os.WNOWAIT | os.WNOHANG
        return os.waitid(os.P_PID, self._workers[number], wanted) is not None

    def _reap(self, number: int) -> int:
        if number not in self._workers:
            return self._lost.pop(number)
        _, status = os.waitpid(self._workers.pop(number), 0)
        return os.waitstatus_to_exitcode(status)


def _end_children() -> None:
    """End what cases have started in sessions of their own: it was left to this process."""
    while _has_children() and (children := _children()):
        for child in children:
            with contextlib.suppress(ProcessLookupError, ChildProcessError):
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)


def _has_children() -> bool:
    """Whether this process has any; to find them, all processes have to be looked at."""
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOWAIT | os.WNOHANG)
    except ChildProcessError:
        return False
    return True


def _children() -> list[int]:
    """This process's children, by what Linux says of all processes."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            _, _, rest = stat.read_text(errors="replace").rpartition(") ")  # names may have both
            if int(rest.split()[1]) == os.getpid():
                found.append(int(stat.parent.name))
    return found


def send(control: socket.socket, message: Any, descriptors: list[int] | None = None) -> None:
    """Send a message, with descriptors of files. Raises OSError."""
    data = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
    header = len(data).to_bytes(HEADER, "little")
    socket.send_fds(control, [header], descriptors or [])
    control.sendall(data)


def received(control: socket.socket) -> tuple[Any, list[int]]:
    """The next message, and the descriptors that came with it.

    Raises:
        EOFError: the other end is closed.
        OSError: it was, in the middle of a message.
    """
    header, descriptors, _, _ = socket.recv_fds(control, HEADER, 3)
    if not header:
        raise EOFError
    size = int.from_bytes(header, "little")
    data = control.recv(size, socket.MSG_WAITALL)
    return pickle.loads(data), descriptors
