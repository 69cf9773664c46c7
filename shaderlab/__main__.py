"""The command line, as `shaderlab` and as `python -m shaderlab`."""

from __future__ import annotations

import _imp
import _thread
import gc
import os
import signal
import sys
import time

REPEAT_SECONDS = 1.0
"""Interrupts within so many seconds, as of a key that is held down, count as one."""
_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_raised = -REPEAT_SECONDS  # when an interrupt was raised
_number = 0  # the signal that did


def main() -> None:
    """Run the command line on `sys.argv`; never returns.

    Ctrl-C, SIGTERM and SIGHUP end it with one line, also while modules are imported.
    """
    global _raised, _number
    _raised, _number = -REPEAT_SECONDS, 0
    sys.unraisablehook = _resend_dropped_interrupt
    try:
        for number in _ENDING:
            if signal.getsignal(number) in (signal.default_int_handler, signal.SIG_DFL):
                signal.signal(number, _interrupt)
        from shaderlab.cli import main as command_line

        command_line()
    except (KeyboardInterrupt, SystemExit, RuntimeError) as ended:
        # Python 3.11 wraps what is raised while a class gets its attributes.
        interrupted = KeyboardInterrupt in (type(ended), type(ended.__cause__))
        if not interrupted and isinstance(ended, RuntimeError):
            raise
        # The command has said so itself where it does not end as if all were well.
        known = _number in (0, signal.SIGINT)
        if interrupted or not (known or getattr(ended, "code", False)):
            print("\nshaderlab: interrupted", file=sys.stderr)
        elif known:  # then the command knows its status
            raise
        sys.exit(128 + (_number or signal.SIGINT))
    finally:
        # An interrupt that ended what was executed from a string, as dataclasses are made, would
        # end this process by a signal, whoever caught it; executing another one takes that back.
        exec("")
        gc.disable()
        gc.freeze()  # nothing is collected as Python ends, which takes 40 ms
        for number in _ENDING:
            if signal.getsignal(number) is _interrupt:
                signal.signal(number, signal.SIG_IGN)  # nothing is left that it could cut short


def _interrupt(number: int, frame: object) -> None:
    """Raise KeyboardInterrupt, but a little later while the lock of imports is held: it would
    never be released, and other threads wait for it forever."""
    global _raised, _number
    if time.monotonic() - _raised < REPEAT_SECONDS:
        return
    _number = number
    if _imp.lock_held():
        _interrupt_later()
        return
    if number == signal.SIGHUP:
        _leave_terminal()
    _raised = time.monotonic()
    raise KeyboardInterrupt


def _resend_dropped_interrupt(dropped: sys.UnraisableHookArgs) -> None:
    """Send an interrupt again that was raised in a callback, such as a weak reference's: Python
    drops what is raised there."""
    global _raised
    if dropped.exc_type is KeyboardInterrupt:
        _raised = -REPEAT_SECONDS
        _interrupt_later()
    else:
        sys.__unraisablehook__(dropped)


def _interrupt_later() -> None:
    """Send an interrupt in 5 ms, without importing anything."""

    def send() -> None:
        time.sleep(0.005)
        os.kill(os.getpid(), _number or signal.SIGINT)

    _thread.start_new_thread(send, ())


def _leave_terminal() -> None:
    """Have output go nowhere where the terminal is gone, so that a report is written still."""
    for stream in (1, 2):
        try:
            os.write(stream, b"")
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)


def _remove_working_folder_from_path() -> None:
    """Remove the folder that `python -m` puts before Python's own modules, where a random.py would
    be taken for one of them.

    What is imported before this can't be helped; the `shaderlab` script has no such folder.
    """
    package = os.path.dirname(os.path.abspath(__file__))
    if not sys.flags.safe_path and sys.path[0] != os.path.dirname(package):
        del sys.path[0]


if __name__ == "__main__":
    _remove_working_folder_from_path()
    main()
