"""Work in a copy of this process: nothing is sent to it, and nothing comes back.

It is for work whose results are files, and only where other threads hold no lock that the work
takes: the copy has none of these threads.
"""

from __future__ import annotations

import gc
import os
import signal
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def in_second_process(
    work: Callable[[], object], after: threading.Thread | None = None
) -> Iterator[None]:
    """Have `work` done in a copy of this process, made `after` a thread's end, while the block
    runs. At the end of the block it is done.

    Where there can be no copy, or it fails for whatever reason, `work` is done here after the
    block, and raises here what it raises. A block that raises ends the copy.
    """
    if after is not None:
        after.join()
    copy = 0
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        copy = _fork()
        if copy == 0:
            _end_with(work, before)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        yield
    except BaseException:
        if copy > 0:
            os.kill(copy, signal.SIGINT)
            os.waitpid(copy, 0)
        raise
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    if copy < 0 or os.waitpid(copy, 0)[1]:
        work()


def _fork() -> int:
    """As `os.fork`; −1 where the system allows no more processes."""
    with warnings.catch_warnings():  # Python warns of a fork beside threads
        warnings.simplefilter("ignore", DeprecationWarning)
        try:
            return os.fork()
        except OSError:
            return -1


def _end_with(work: Callable[[], object], signals: set[int]) -> None:
    """Do the work and end this process; never returns."""
    status = 1
    try:
        signal.pthread_sigmask(signal.SIG_SETMASK, signals)
        gc.freeze()  # looking through what is there would have all of it copied
        work()
        status = 0
    finally:
        os._exit(status)
