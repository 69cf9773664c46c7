"""The worker's side: receive a batch, answer its items one by one, until nothing more comes."""

from __future__ import annotations

import contextlib
import gc
import importlib
import mmap
import os
import pickle
import resource
import signal
import socket
import sys
from collections.abc import Sequence
from typing import Any

from shaderlab.errors import CaseError

LAB_WORK = "shaderlab.workers.lab_worker:LabWorker"
"""What workers that judge scenes call, as of `shaderlab.workers.pool.WorkerPool`."""
STEP_BYTES = 256
"""The size of the file in which a worker notes its steps."""
_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
# Python's 700 finds a few cycles by looking at all that lives a hundred times.
_OBJECTS_BETWEEN_COLLECTIONS = 20_000
GRACE = 2.0
"""A worker outlives the time limit that its parent watches by this factor, then ends itself."""


class Channel:
    """The worker's way to its parent.

    Args:
        parent: the parent's socket.
        seconds: the time limit of each item.
        steps: the descriptor of the file for steps.
    """

    def __init__(self, parent: socket.socket, seconds: float, steps: int) -> None:
        self._parent = parent
        self._seconds = seconds
        self._process = os.getpid()
        # Mapped into memory: a note costs no system call, and outlives the process.
        self._steps = mmap.mmap(steps, STEP_BYTES)

    def leave(self) -> None:
        """Keep a copy of this process, which the work has forked, from speaking for it."""
        with open(os.devnull, "rb") as nothing:
            os.dup2(nothing.fileno(), self._parent.fileno())
        self._steps = mmap.mmap(-1, STEP_BYTES)
        die_with_parent(self._process)

    def note(self, step: str) -> None:
        """Note what the work is about to do; the parent reads it if this process dies."""
        self._steps[:] = step.encode("utf-8", "replace")[:STEP_BYTES].ljust(STEP_BYTES, b"\0")

    def restart_limit(self, seconds: float | None = None) -> None:
        """Give the current item so many seconds from now on, by default as many as any item."""
        allowed = self._seconds if seconds is None else seconds
        self.send("limit", allowed)
        self.set_alarm(allowed)

    def begin(self) -> None:
        """Note that a new item begins."""
        self.note("")
        self.set_alarm(self._seconds)

    def set_alarm(self, seconds: float) -> None:
        """End this process some time after the limit: its parent may be gone and watch no more.
        The alarm's default action ends it even inside C code."""
        signal.setitimer(signal.ITIMER_REAL, seconds * GRACE)

    def send(self, kind: str, value: Any) -> str:
        """Send an answer, or a message about one; returns its kind, which is "error" if it can't
        be sent."""
        try:
            data = pickle.dumps((kind, value), pickle.HIGHEST_PROTOCOL)
        except MemoryError:
            os.abort()
        except Exception as error:  # pickle raises whatever the object's own code raises
            kind = "error"
            data = pickle.dumps((kind, TypeError(f"can't be sent: {error}")))
        self._parent.sendall(data)
        return kind


def main(socket_number: int, steps: int) -> None:
    """Answer batches from the parent's socket, as pickles, until it is closed.

    Each answer is ("done", result) or ("error", exception); after an error the rest of the batch
    stays unanswered.

    Args:
        socket_number: the socket's descriptor.
        steps: the descriptor of the file for steps.
    """
    parent = socket.socket(fileno=socket_number)
    given = parent.makefile("rb")
    name, seconds, memory = pickle.load(given)
    _limit_memory(memory)
    keep_freed_memory()
    channel = Channel(parent, seconds, steps)
    os.register_at_fork(after_in_child=channel.leave)
    work = prepared(name)
    if isinstance(work, type):
        work = work(channel)
    gc.freeze()
    gc.set_threshold(_OBJECTS_BETWEEN_COLLECTIONS)
    gc.enable()
    channel.send("ready", None)
    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            _answer(work, pickle.load(given), channel)


def prepared(name: str) -> Any:
    """Import the work that is called "module:name", and all that it says it will need; returns the
    work. See `shaderlab.workers.pool.WorkerPool`.
    """
    gc.disable()  # nothing that is imported is garbage, and a tenth of the time goes into looking
    module, _, attribute = name.partition(":")
    work = getattr(importlib.import_module(module), attribute)
    preload = getattr(work, "preload", None)
    if preload is not None:
        preload()
    gc.freeze()
    return work


def _answer(work: Any, batch: Sequence[Any], channel: Channel) -> None:
    results = iter(work(batch))
    for _ in batch:
        channel.begin()
        try:
            result = next(results)
        except MemoryError:
            os.abort()  # what is left of the heap can't be trusted
        except Exception as error:
            if os.environ.get("SHADERLAB_DEBUG"):
                import traceback

                error.add_note("".join(traceback.format_exception(error)))
            channel.send("error", error)
            break
        except BaseException as error:  # of the user's own code: nobody else ends a worker so
            said = f"raised {type(error).__name__}: {error}".rstrip(": ")
            channel.send("error", CaseError(said))
            break
        if channel.send("done", result) == "error":
            break
    channel.set_alarm(0.0)


def die_with_parent(parent: int) -> None:
    """Ask the kernel to end this process with its parent, even in the middle of C code.

    `parent` is the number of the process that has forked this one.
    """
    if not sys.platform.startswith("linux"):
        return  # elsewhere the closed socket or, inside an item, the alarm ends it
    import ctypes

    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:  # it went away in between
        os._exit(1)


def adopt_orphans() -> None:
    """Ask the kernel to give this process what its children's children leave behind, in whatever
    session that is."""
    if sys.platform.startswith("linux"):
        import ctypes

        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def keep_freed_memory() -> None:
    """Have glibc's malloc use again what large arrays have freed, up to 192 MB of it, where it
    would give it back to the system and get the same pages anew: a tenth of a run's time."""
    import ctypes

    trim_threshold, mmap_max = -1, -4
    with contextlib.suppress(OSError, AttributeError, TypeError):
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(trim_threshold, 192 << 20)
        mallopt(mmap_max, 0)


def release_freed_memory() -> None:
    """Give the memory that `keep_freed_memory` holds back to the system."""
    import ctypes

    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def freed_memory() -> int:
    """How many bytes malloc holds that are free to be used again; 0 where it does not say."""
    import ctypes

    class Counts(ctypes.Structure):  # glibc's mallinfo2
        _fields_ = [(f"count_{n}", ctypes.c_size_t) for n in range(10)]

    try:
        ask = ctypes.CDLL(None).mallinfo2
    except (OSError, AttributeError, TypeError):
        return 0
    ask.restype = Counts
    return int(ask().count_8)  # fordblks


def _limit_memory(size: int) -> None:
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if size:
            # A soft limit: what the worker starts may be a browser, which reserves far more.
            hard = resource.getrlimit(resource.RLIMIT_AS)[1]
            resource.setrlimit(resource.RLIMIT_AS, (size, hard))
