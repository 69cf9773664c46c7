"""`python -m shaderlab` is `shaderlab`, wherever the environment's scripts may be."""

import os
import sys


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
    from shaderlab.cli import main

    main()
