"""The command line, as `shaderlab` and as `python -m shaderlab`, wherever the environment's scripts
may be."""

from __future__ import annotations

import _imp
import _thread
import atexit
import gc
import itertools
import os
import sys
import time
from collections.abc import Sequence

_RUNNING = ("run", "sweep", "mutate")
"""Commands that take workers."""
_WITHOUT_WORKERS = ("-j0", "--jobs=0", "-h", "--help")
_OBJECTS_PER_LOOK = 50_000
_SWITCH_SECONDS = 0.0002


def main() -> None:
    """Run the command line on `sys.argv`; never returns. An interrupt ends it with a word, also
    while modules are imported.

    What workers are forked from gets ready beside it from the beginning: later there are threads
    and open files, which no copy of a process should have.
    """
    import signal

    ending = _Ending()
    sys.unraisablehook = _interrupt_again
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    try:
        if _will_run(sys.argv[1:]):
            from shaderlab.files import hold_standard_descriptors
            from shaderlab.workers.worker_process import begin_server

            hold_standard_descriptors()
            begin_server(_is_of_one_case(sys.argv[1:]))
        # A command makes few cycles, and each look for some goes over all that was imported.
        gc.set_threshold(_OBJECTS_PER_LOOK)
        # Threads that wait for workers wait for Python's lock as well, which a thread that imports
        # or writes a page would keep for 5 ms each time.
        sys.setswitchinterval(_SWITCH_SECONDS)
        from shaderlab.cli import main as command_line

        try:
            command_line()
        except SystemExit as ended:
            ending.status = 0 if ended.code is None else ended.code
            raise
    except KeyboardInterrupt:
        print("\nshaderlab: interrupted", file=sys.stderr)
        sys.exit(130)
    finally:
        if signal.getsignal(signal.SIGINT) in (_interrupt, signal.default_int_handler):
            signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing is left that it could cut short


class _Ending:
    """Has Python end without taking down all that was imported, which takes as long as half of the
    imports: when threads and whatever else waits for the end are done, nothing is left to do.

    Attributes:
        status: the exit status, once the command says so.
    """

    status: object = None

    def __init__(self) -> None:
        # What was registered before this, by coverage say, runs after it.
        self._last = getattr(atexit, "_ncallbacks", lambda: 1)() == 0
        atexit.register(self._end)

    def _end(self) -> None:
        if self._last and isinstance(self.status, int):
            for stream in (sys.stdout, sys.stderr):
                if stream is not None:
                    stream.flush()
            os._exit(self.status & 0xFF)
        if "OpenImageIO" not in sys.modules:  # it reports what it finds at the end as leaked
            gc.freeze()


def _will_run(words: Sequence[str]) -> bool:
    """Whether a command takes workers, by its words alone: a wrong guess costs a process that is
    ended at once, or one that starts a little later."""
    in_this_process = "0" in (
        os.environ.get("SHADERLAB_JOBS", ""),
        *(after for word, after in itertools.pairwise(words) if word in ("-j", "--jobs")),
    )
    return (
        bool(words)
        and words[0] in _RUNNING
        and not in_this_process
        and not any(word.startswith("--scheduler") or word in _WITHOUT_WORKERS for word in words)
        and sys.platform.startswith("linux")
    )


def _is_of_one_case(words: Sequence[str]) -> bool:
    """Whether a command runs one case, which takes one worker, by its words alone: a wrong guess
    costs what a worker imports."""
    named = [word for word in words[1:] if not word.startswith("-")]
    return words[0] == "run" and len(named) == 1 and not os.path.isdir(named[0])


def _interrupt(number: int, frame: object) -> None:
    """Raise KeyboardInterrupt, but while Python's lock of imports is held a little later: it would
    never be released, and other threads wait for it forever."""
    if _imp.lock_held():
        _send_again()
    else:
        raise KeyboardInterrupt


def _interrupt_again(dropped: sys.UnraisableHookArgs) -> None:
    """Send an interrupt again that came in a callback, such as that of an import's lock: Python
    drops what is raised there."""
    if dropped.exc_type is KeyboardInterrupt:
        _send_again()
    else:
        sys.__unraisablehook__(dropped)


def _send_again() -> None:
    """Send an interrupt in 5 ms. By what needs no import, which may be what was interrupted."""
    import signal

    def send() -> None:
        time.sleep(0.005)
        os.kill(os.getpid(), signal.SIGINT)

    _thread.start_new_thread(send, ())


def _leave_out_the_working_folder() -> None:
    """Python has put it before its own modules, where a random.py would be taken for one of them.

    What is imported before this can't be helped; the `shaderlab` script has no such folder.
    """
    package = os.path.dirname(os.path.abspath(__file__))
    try:
        here = os.getcwd()
    except OSError:  # it has been removed
        here = ""
    if not sys.flags.safe_path and sys.path[0] == here != os.path.dirname(package):
        del sys.path[0]


if __name__ == "__main__":
    _leave_out_the_working_folder()
    main()
