"""A fork server made of this very process: what both import is there, and Python need not start.

Only where the process has a single thread and nothing open yet: `shaderlab.__main__` does it before
anything else.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
import traceback
from collections.abc import Mapping
from types import ModuleType
from typing import BinaryIO

from . import fork_server_main

_PATH = "PYTHONPATH"


class OwnCopy:
    """A copy of this process that serves a socket, seen from this process, as `subprocess.Popen`
    would show it.

    Args:
        environment: the environment variables that it has.
        control: what it serves.
        errors: its standard error.
        close: a socket that it must not keep.

    Raises:
        OSError: it can't be forked.
    """

    def __init__(
        self,
        environment: Mapping[str, str],
        control: socket.socket,
        errors: BinaryIO,
        close: socket.socket,
    ) -> None:
        self._status: int | None = None
        self._lock = threading.Lock()
        # An interrupt before the copy has a group of its own would reach it as well.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        try:
            self.pid = os.fork()
            if self.pid == 0:
                close.close()
                _serve(environment, control, errors, before)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def poll(self) -> int | None:
        """Its exit status, or None while it runs."""
        return self._waited(os.WNOHANG)

    def wait(self) -> int:
        """Its exit status, once it has ended."""
        status = self._waited(0)
        assert status is not None
        return status

    def kill(self) -> None:
        """End it."""
        if self.poll() is None:
            os.kill(self.pid, signal.SIGKILL)

    def _waited(self, options: int) -> int | None:
        with self._lock:
            if self._status is None:
                process, status = os.waitpid(self.pid, options)
                self._status = os.waitstatus_to_exitcode(status) if process else None
            return self._status


def _serve(
    environment: Mapping[str, str],
    control: socket.socket,
    errors: BinaryIO,
    signals: set[int],
) -> None:
    """Turn this copy into a server as a fresh Python would be one; never returns."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_SETMASK, signals)
        os.setpgid(0, 0)
        with open(os.devnull, "r+b", buffering=0) as nothing:
            for standard in (0, 1):
                os.dup2(nothing.fileno(), standard)
        os.dup2(errors.fileno(), 2)
        os.chdir(os.sep)
        os.environ.clear()
        os.environ.update(environment)
        sys.path[:] = environment[_PATH].split(os.pathsep)
        sys.unraisablehook = sys.__unraisablehook__
        sys.modules["__main__"] = ModuleType("__main__")
        del sys.argv[1:]
        fork_server_main.serve(control)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(1)
