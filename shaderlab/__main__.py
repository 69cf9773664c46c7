"""The command line, as `shaderlab` and as `python -m shaderlab`, wherever the environment's scripts
may be."""

from __future__ import annotations

import os
import sys


def main() -> None:
    """Run the command line on `sys.argv`; never returns. An interrupt ends it with a word, also
    while modules are imported."""
    import signal

    sys.unraisablehook = _interrupt_again
    try:
        from shaderlab.cli import main as command_line

        command_line()
    except KeyboardInterrupt:
        print("\nshaderlab: interrupted", file=sys.stderr)
        sys.exit(130)
    finally:
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing is left that it could cut short


def _interrupt_again(dropped: sys.UnraisableHookArgs) -> None:
    """Send an interrupt again that came in a callback, such as that of an import's lock: Python
    drops what is raised there."""
    if dropped.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(dropped)
        return
    import signal
    from threading import Timer

    again = Timer(0.005, os.kill, (os.getpid(), signal.SIGINT))
    again.daemon = True
    again.start()


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
