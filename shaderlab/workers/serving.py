"""The worker's side: receive a batch, answer its items one by one, until nothing more comes."""

from __future__ import annotations

import contextlib
import gc
import importlib
import os
import pickle
import signal
import sys
from collections.abc import Sequence
from typing import Any, BinaryIO

_PR_SET_PDEATHSIG = 1
GRACE = 2.0
"""A worker outlives the time limit that its parent watches by this factor, then ends itself."""


def serve() -> None:
    """Answer batches from standard input on standard output, as pickles.

    Each answer is ("done", result) or ("error", exception); after an error the rest of the batch
    stays unanswered. The pipes are moved away first, so that whatever the work prints is lost
    instead of being read as an answer.
    """
    given = os.fdopen(os.dup(0), "rb")
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what an interrupt means
    _die_with_parent()
    name, warm, seconds, memory = pickle.load(given)
    _limit_memory(memory)
    warmed = _named(warm)() if warm else None
    gc.disable()  # nothing that is imported is garbage, and a tenth of the time goes into looking
    work = _named(name)
    gc.freeze()
    gc.enable()
    if warmed is not None:
        warmed()
    _send(answers, ("ready", None))
    with contextlib.suppress(EOFError, BrokenPipeError):
        while True:
            _answer(work, pickle.load(given), answers, seconds)


def _named(name: str) -> Any:
    """What "module:function" stands for."""
    module, _, function = name.partition(":")
    return getattr(importlib.import_module(module), function)


def _answer(work: Any, batch: Sequence[Any], answers: BinaryIO, seconds: float) -> None:
    # The alarm's default action ends the process even inside C code. It is for a parent that was
    # killed and can no longer watch.
    alarm = getattr(signal, "setitimer", None)
    results = iter(work(batch))
    for _ in batch:
        if alarm is not None:
            alarm(signal.ITIMER_REAL, seconds * GRACE)
        try:
            answer = ("done", next(results))
        except MemoryError:
            os.abort()  # what is left of the heap can't be trusted
        except Exception as error:
            _send(answers, ("error", error))
            break
        _send(answers, answer)
    if alarm is not None:
        alarm(signal.ITIMER_REAL, 0)


def _send(answers: BinaryIO, answer: tuple[str, Any]) -> None:
    try:
        data = memoryview(pickle.dumps(answer, pickle.HIGHEST_PROTOCOL))
    except MemoryError:
        os.abort()
    except Exception as error:  # pickle raises whatever the object's own code raises
        data = memoryview(pickle.dumps(("error", TypeError(f"can't be sent: {error}"))))
    while data:
        data = data[answers.write(data) :]


def _die_with_parent() -> None:
    """Ask the kernel to end this process with its parent, even in the middle of C code."""
    if not sys.platform.startswith("linux"):
        return  # elsewhere the closed pipe or, inside an item, the alarm ends it
    import ctypes

    parent = os.getppid()
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:  # it went away in between
        os._exit(1)


def _limit_memory(size: int) -> None:
    try:
        import resource
    except ImportError:
        return  # Windows has no such limit
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if size:
            resource.setrlimit(resource.RLIMIT_AS, (size, size))
