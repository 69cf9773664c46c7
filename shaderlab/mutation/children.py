"""Processes that judge mutants: started when needed, killed when they take too long."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

from shaderlab.mutation.worker import Answer, Opening, Question

_CODE = "from shaderlab.mutation.worker import main; main()"


class Gone(Exception):
    """A child ended without an answer; says how."""


class Child:
    """One process; it has one case open, and at most one question to answer."""

    def __init__(self) -> None:
        self.opened: Opening | None = None
        self.deadline = 0.0
        self.asked = 0.0
        package = str(Path(__file__).parents[2])
        paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
        self._process = subprocess.Popen(
            # -P: the current folder is no place to import from.
            [sys.executable, "-P", "-c", _CODE],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=None if os.environ.get("SHADERLAB_DEBUG") else subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            start_new_session=True,
        )

    def fileno(self) -> int:
        """What becomes readable when there is an answer, or none any more."""
        assert self._process.stdout is not None
        return self._process.stdout.fileno()

    def ask(self, question: Question, limit: float) -> None:
        """Put a question that has to be answered within `limit` seconds.

        Raises:
            Gone: the process has ended.
        """
        assert self._process.stdin is not None
        self.asked = time.monotonic()
        self.deadline = self.asked + limit
        try:
            pickle.dump(question, self._process.stdin)
            self._process.stdin.flush()
        except OSError as error:
            raise Gone(self._end()) from error

    def answer(self) -> Answer:
        """The answer; waits for it.

        Raises:
            Gone: the process has ended.
        """
        assert self._process.stdout is not None
        try:
            answer: Answer = pickle.load(self._process.stdout)
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            raise Gone(self._end()) from error
        return answer

    def close(self) -> None:
        """End the process at once, and whatever hangs in it."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                # The other end may be gone with an unread question.
                with contextlib.suppress(OSError):
                    pipe.close()

    def _end(self) -> str:
        code = self._process.wait()
        if code >= 0:
            return f"exit code {code}"
        try:
            return signal.Signals(-code).name
        except ValueError:
            return f"signal {-code}"
