"""What `shaderlab compile` shows: messages, a progress line, a table, and JSON."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

from ..glsl.driver_verdict import DRIVER
from ..glsl.jobs import FileResult
from ..terminal import diagnostic_line

_WIDTH = 30
_SECONDS_BETWEEN = 0.1


class Tally:
    """How many files each target accepted and refused, and on how many it gave no answer."""

    def __init__(self) -> None:
        self._counts: dict[str, Counter[str]] = {}
        self.files = 0
        self.refused = 0

    @property
    def asked_driver(self) -> bool:
        """Whether a driver said anything."""
        return DRIVER in self._counts

    def add(self, result: FileResult) -> None:
        self.files += 1
        self.refused += not result.ok
        for verdict in result.verdicts:
            counts = self._counts.setdefault(verdict.target, Counter())
            kind = verdict.status if verdict.status in ("crash", "timeout") else ""
            counts[kind or ("accepted" if verdict.ok else "refused")] += 1
            counts["disagrees"] += verdict.status == "disagrees"

    def lines(self) -> Iterator[str]:
        """A table; columns that only misfortune fills are left out where they are empty."""
        rare = [
            kind
            for kind in ("crash", "timeout", "disagrees")
            if any(counts[kind] for counts in self._counts.values())
        ]
        columns = ["accepted", "refused", *rare]
        yield f"{'target':<14}" + "".join(f"{column:>10}" for column in columns)
        for target, counts in self._counts.items():
            yield f"{target:<14}" + "".join(f"{counts[column]:>10}" for column in columns)


def messages(result: FileResult) -> Iterator[str]:
    """Each message once, with the targets that say it where not all do."""
    said: dict[str, list[str]] = {}
    for verdict in result.verdicts:
        for diagnostic in dict.fromkeys(verdict.diagnostics):
            said.setdefault(diagnostic_line(diagnostic), []).append(verdict.target)
    for line, targets in said.items():
        few = len(targets) < len(result.verdicts)
        yield f"{line} [{', '.join(targets)}]" if few else line


def as_data(result: FileResult) -> Iterator[dict[str, Any]]:
    """An entry of the JSON for each target's verdict on the file."""
    for verdict in result.verdicts:
        yield {
            "path": result.path,
            "stage": result.stage,
            "target": verdict.target,
            "ok": verdict.ok,
            "diagnostics": [
                {
                    "file": d.file,
                    "line": d.line,
                    "severity": d.severity,
                    "token": d.token,
                    "message": d.message,
                }
                for d in verdict.diagnostics
            ],
            "spirv_bytes": verdict.spirv_bytes,
            "instructions": verdict.instructions,
            "valid": verdict.valid,
            "status": verdict.status,
        }


@contextmanager
def watched(total: int, *, quiet: bool) -> Iterator[Progress]:
    """A progress bar on standard error, where that is a terminal."""
    stream = sys.stderr
    progress = Progress(stream if stream.isatty() and not quiet else None, total)
    try:
        yield progress
    finally:
        progress.clear()


class Progress:
    """One line that is drawn over itself; importing a library for it would take longer than
    compiling a hundred files."""

    def __init__(self, stream: TextIO | None, total: int) -> None:
        self._stream = stream
        self._total = max(total, 1)
        self._done = 0
        self._drawn = 0.0

    def advance(self) -> None:
        """One more file is done."""
        self._done += 1
        now = time.monotonic()
        if self._stream is not None and now - self._drawn >= _SECONDS_BETWEEN:
            self._drawn = now
            full = _WIDTH * self._done // self._total
            bar = "━" * full + " " * (_WIDTH - full)
            self._stream.write(f"\r{bar} {self._done}/{self._total}")
            self._stream.flush()

    def clear(self) -> None:
        """Take the bar away, so that a message can be written in its place."""
        if self._stream is not None and self._drawn:
            self._drawn = 0.0
            self._stream.write("\r\x1b[2K")
            self._stream.flush()
