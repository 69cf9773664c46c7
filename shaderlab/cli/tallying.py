"""What `shaderlab compile` shows: messages, a progress bar, a table, and JSON."""

from __future__ import annotations

import dataclasses
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ..compiler.harness import FileResult
from ..report.plain_text import diagnostic_line

_WIDTH = 30
_FEW = 50


class Tally:
    """How many files each target accepted and refused, and on how many it gave no answer."""

    def __init__(self) -> None:
        self._counts: dict[str, Counter[str]] = {}
        self.files = 0
        self.refused = 0

    @property
    def targets(self) -> tuple[str, ...]:
        """All that gave verdicts."""
        return tuple(self._counts)

    def add(self, result: FileResult) -> None:
        self.files += 1
        self.refused += not result.ok
        for verdict in result.verdicts:
            counts = self._counts.setdefault(verdict.target, Counter())
            kind = verdict.status if verdict.status in ("crash", "timeout") else ""
            counts[kind or ("accepted" if verdict.ok else "refused")] += 1
            counts["disagrees"] += verdict.status == "disagrees"

    def lines(self) -> Iterator[str]:
        """A table by target; without columns for crashes, timeouts and such if there were none."""
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
    """Each message once, with its targets unless all of them have it."""
    targets_of: dict[str, list[str]] = {}
    for verdict in result.verdicts:
        for diagnostic in dict.fromkeys(verdict.diagnostics):
            targets_of.setdefault(diagnostic_line(diagnostic), []).append(verdict.target)
    for line, targets in targets_of.items():
        few = len(targets) < len(result.verdicts)
        yield f"{line} [{', '.join(targets)}]" if few else line


def as_data(result: FileResult) -> Iterator[dict[str, Any]]:
    """An entry of the JSON for each target's verdict on the file."""
    for verdict in result.verdicts:
        said = dataclasses.asdict(verdict)
        del said["assembly"]
        yield {"path": result.path, "stage": result.stage, **said}


@contextmanager
def progress_bar(total: int, *, quiet: bool) -> Iterator[Callable[[], None]]:
    """A progress bar on standard error; the function that it gives moves it on by one file.

    There is none if that is no terminal, or for few files: importing Rich takes as long as
    compiling fifty.
    """
    if quiet or total < _FEW or not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress

    with Progress(
        BarColumn(_WIDTH),
        MofNCompleteColumn(),
        console=Console(stderr=True),
        transient=True,
        redirect_stdout=sys.stdout.isatty(),  # a pipe must get its messages
    ) as progress:
        task = progress.add_task("", total=total)
        yield lambda: progress.advance(task)
