"""Standard streams that a full disk or a reader who has gone can't break: a command goes on to its
report and its verdict, and says at its end what was lost."""

from __future__ import annotations

import codecs
import contextlib
import errno
import io
import sys
from typing import Any, TextIO

from shaderlab.cli import FAILED
from shaderlab.files import hold_standard_descriptors

_PLAIN = {"✓": "+", "✗": "x", "–": "-", "→": "->", "…": "...", "·": "-", "×": "x", "≤": "<="}
"""What stands for a character in an encoding without it; "?" for all others."""


def _plainly(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_PLAIN.get(character, "?") for character in lacking), error.end


codecs.register_error("shaderlab.plainly", _plainly)


class _Lasting(io.FileIO):
    """Writes to a descriptor; what can't be written is lost, and `problem` says why."""

    problem: OSError | None = None

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError as error:
            self.problem = error
            return len(data)


def lasting(stream: TextIO) -> TextIO:
    """A text stream to the same descriptor to which writing never fails.

    Characters that its encoding lacks are written in plain ones: a terminal without ✓ gets a "+".
    """
    raw = _Lasting(stream.fileno(), "wb", closefd=False)
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors="shaderlab.plainly",
        line_buffering=getattr(stream, "line_buffering", False),
    )


def problem(stream: TextIO) -> str:
    """Why something written to a `lasting` stream was lost; "" if nothing was, or if its reader
    has gone and so wants no more."""
    stream.flush()
    raw = getattr(getattr(stream, "buffer", None), "raw", None)
    found = raw.problem if isinstance(raw, _Lasting) else None
    return "" if found is None or found.errno == errno.EPIPE else found.strerror or str(found)


def open_streams() -> None:
    """Make this process's standard streams last, and keep their numbers from being given to
    files where they are closed."""
    hold_standard_descriptors()
    for name in ("stdout", "stderr"):
        with contextlib.suppress(AttributeError, OSError):  # none, or none of the system's
            setattr(sys, name, lasting(getattr(sys, name)))


def settled(status: str | int | None) -> str | int | None:
    """The exit status, which is no success where output was lost; says so on standard error."""
    lost = problem(sys.stdout) if sys.stdout is not None else ""
    if not lost:
        return status
    print(f"shaderlab: can't write to standard output: {lost}", file=sys.stderr)
    return status or FAILED
