"""The worker's side of a pool: receive items and answer them.

Little is imported here: everything that takes time is imported by the work itself.
"""

import contextlib
import ctypes
import gc
import importlib
import mmap
import os
import pickle
import resource
import signal
import socket
import sys
from typing import Any

from shaderlab.errors import CaseError

GRACE = 2.0
"""A worker ends itself once an item has taken this many times the limit that its parent watches."""
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36


class Channel:
    """The worker's connection to its parent; `steps` is the descriptor of the file for steps."""

    def __init__(self, parent: socket.socket, seconds: float, steps: int) -> None:
        self._parent = parent
        self._seconds = seconds
        self._process = os.getpid()
        # Mapped into memory: a note costs no system call, and outlives the process.
        self._steps = mmap.mmap(steps, 0)

    def detach_copy(self) -> None:
        """Keep a forked copy of this process from answering in its place."""
        with open(os.devnull, "rb") as null:
            os.dup2(null.fileno(), self._parent.fileno())
        self._steps = mmap.mmap(-1, len(self._steps))
        die_with_parent(self._process)

    def note(self, step: str) -> None:
        """Note what the work is about to do; the parent reads it if this process dies."""
        size = len(self._steps)
        self._steps[:] = step.encode("utf-8", "replace")[:size].ljust(size, b"\0")

    def restart_limit(self, seconds: float | None = None) -> None:
        """Give the current item this many seconds from now on, by default the limit of any item."""
        allowed = self._seconds if seconds is None else seconds
        self.send("limit", allowed)
        set_alarm(allowed)

    def send(self, kind: str, value: Any) -> None:
        """Send an answer, which is an "error" if the value can't be sent."""
        try:
            data = pickle.dumps((kind, value), pickle.HIGHEST_PROTOCOL)
        except MemoryError:
            os.abort()
        except Exception as error:  # pickle raises whatever the object's own code raises
            data = pickle.dumps(("error", TypeError(f"can't be sent: {error}")))
        self._parent.sendall(data)

    def answer(self, work: Any, item: Any) -> None:
        """Send ("done", result) for an item, or ("error", exception)."""
        self.note("")
        set_alarm(self._seconds)
        try:
            kind, value = "done", work(item)
        except MemoryError:
            os.abort()  # what is left of the heap can't be trusted
        except Exception as error:
            if os.environ.get("SHADERLAB_DEBUG"):
                import traceback

                error.add_note("".join(traceback.format_exception(error)))
            kind, value = "error", error
        except BaseException as error:  # SystemExit or KeyboardInterrupt of the user's own code
            message = f"raised {type(error).__name__}: {error}".rstrip(": ")
            kind, value = "error", CaseError(message)
        self.send(kind, value)
        set_alarm(0.0)


def set_alarm(seconds: float) -> None:
    """End this process some time after the limit, in case its parent no longer watches.

    The default action of the alarm ends the process even inside C code.
    """
    signal.setitimer(signal.ITIMER_REAL, seconds * GRACE)


def main() -> None:
    """Answer items from the parent's socket, as pickles, until the parent closes it.

    `sys.argv` has the descriptors of the socket and of the file for steps, the parent's process id,
    an item's limits in bytes and seconds, and the name of the work.
    """
    socket_number, steps, parent_id, memory = map(int, sys.argv[1:5])
    seconds, name = float(sys.argv[5]), sys.argv[6]
    del sys.argv[1:]
    gc.disable()  # while all is imported, of which nothing is garbage
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what an interrupt means
    die_with_parent(parent_id)
    _limit_memory(memory)
    parent = socket.socket(fileno=socket_number)
    channel = Channel(parent, seconds, steps)
    os.register_at_fork(after_in_child=channel.detach_copy)
    module, _, attribute = name.partition(":")
    work: Any = getattr(importlib.import_module(module), attribute)
    getattr(work, "preload", lambda: None)()  # imports what it will need
    if isinstance(work, type):
        work = work(channel)
    gc.freeze()  # what is imported stays: no later collection has to look at it
    gc.enable()
    channel.send("ready", None)
    requests = parent.makefile("rb")
    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            channel.answer(work, pickle.load(requests))


def die_with_parent(parent: int) -> None:
    """Ask the kernel to end this process with its parent, even in the middle of C code, and to
    make all that items start its descendants for good, so that the pool can end them."""
    prctl = ctypes.CDLL(None).prctl
    prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:  # it ended in between
        os._exit(1)


def _limit_memory(size: int) -> None:
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if size:
            # A soft limit: what the worker starts may be a browser, which reserves far more.
            hard = resource.getrlimit(resource.RLIMIT_AS)[1]
            resource.setrlimit(resource.RLIMIT_AS, (size, hard))
