"""How `shaderlab run` looks in a terminal, and in a file or a CI log."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from shaderlab.cli.rows import STYLES, case_table
from shaderlab.files import display_path
from shaderlab.records import Record, Run
from shaderlab.report.plain_text import MARKS, failed, failure, label, summary
from shaderlab.running.tabulating import Row

HEARTBEAT = 10.0
MOST_ROWS = 40
MOST_MESSAGES = 5
SLOWEST = 5


class Reporter(Protocol):
    """What is told of a run while it goes on."""

    def starts(self, case_id: str, variant: str) -> None:
        """A scene is about to run."""

    def ends(self, record: Record) -> None:
        """A scene has run."""


class Show:
    """Everything `run` prints. With `to_stderr`, standard output stays free for data."""

    def __init__(self, to_stderr: bool = False) -> None:
        self.console = Console(
            file=sys.stderr if to_stderr else sys.stdout, highlight=False, soft_wrap=True
        )

    @contextmanager
    def progress(self, total: int) -> Iterator[Reporter]:
        """A live line on a terminal; elsewhere a plain line for a failure and now and then."""
        if not self.console.is_terminal:
            yield _Plain(self.console, total)
            return
        columns = (
            TextColumn("{task.description}"),
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
        )
        with Progress(*columns, console=self.console, transient=True) as progress:
            yield _Live(progress, total)

    def outcomes(self, run: Run) -> None:
        """A table of all cases, each failure in full, one line that sums up."""
        self.console.print(case_table(run.records))
        for record in run.records:
            if failed(record):
                self.console.print()
                for line in failure(record):
                    style = "red" if line.lstrip().startswith(MARKS["fail"]) else None
                    self.console.print(line, style=style, markup=False)
        self.console.print()
        bad = any(failed(record) for record in run.records)
        self.console.print(
            summary(run.records, run.seconds), style="bold red" if bad else "bold green"
        )
        renderer = run.driver.get("renderer")
        if renderer:
            self.console.print(f"on {renderer}", style="dim", markup=False)

    def sweep(self, rows: Sequence[Row], run: Run) -> None:
        """A sweep's table; of a long one the points that are worst, and how many there are."""
        shown = list(rows)
        if len(rows) > MOST_ROWS:
            worst = sorted(shown, key=lambda row: (row["status"] == "pass", -_width(row)))
            kept = {id(row) for row in worst[:MOST_ROWS]}
            shown = [row for row in rows if id(row) in kept]
        swept = list(rows[0])[: list(rows[0]).index("status")] if rows else []
        table = Table(box=None, pad_edge=False, header_style="dim")
        for name in swept:
            table.add_column(name.replace("[", r"\["), justify="right")
        table.add_column("status")
        for heading in ("half widths", "ulp", "outside", "vacuous", "seconds"):
            table.add_column(heading, justify="right")
        for row in shown:
            style = STYLES.get(str(row["status"]), "red")
            outside = f"{row['outside']} of {row['judged']}"
            table.add_row(
                *(f"{row[name]:.6g}" for name in swept),
                f"[{style}]{row['status']}[/]",
                *("" if row[n] is None else f"{row[n]:.3g}" for n in ("widths", "ulp")),
                outside,
                "" if row["vacuous"] is None else f"{row['vacuous']:.0%}",
                f"{row['seconds']:.3f}",
            )
        self.console.print(table)
        if len(shown) < len(rows):
            self.console.print(f"the {len(shown)} worst of {len(rows)} points", style="dim")
        said = {str(row["message"]) for row in rows if row["message"]}
        for message in sorted(said)[:MOST_MESSAGES]:
            self.console.print(message, markup=False, style="red")
        bad = any(failed(record) for record in run.records)
        words = summary(run.records, run.seconds).partition(": ")[2]
        self.console.print(
            f"\n{len(rows)} points: {words}", style="bold red" if bad else "bold green"
        )
        self.console.print(f"on {run.driver.get('renderer')}", style="dim", markup=False)

    def where(self, page: Path) -> None:
        """Where the report is."""
        self.console.print(f"report: {display_path(page)}", markup=False)

    def disagreements(self, run: Run) -> None:
        """Where drivers disagree: a row for each output that is not the same on all of them."""
        if not run.drivers:
            return
        table = Table(box=None, pad_edge=False, header_style="dim")
        for heading in ("output", "drivers"):
            table.add_column(heading, no_wrap=True)
        for heading in ("pixels that differ", "most ulp"):
            table.add_column(heading, justify="right")
        for found in run.disagreements:
            if found.differing:
                name = f"{label(found.id, found.variant)}: {found.output}".replace("[", r"\[")
                differing = f"{found.differing} of {found.pixels}"
                table.add_row(name, " | ".join(found.drivers), differing, f"{found.ulp:.4g}")
        same = sum(not found.differing for found in run.disagreements)
        self.console.print()
        if table.row_count:
            self.console.print(table)
        self.console.print(f"{same} of {len(run.disagreements)} outputs are the same everywhere")
        for result in run.drivers:
            if result.status not in ("pass", "unsupported"):
                name = label(result.id, result.variant)
                self.console.print(f"{result.status} on {result.driver}: {name}", markup=False)

    def go_on(self, folder: Path) -> None:
        """How to run what an interrupt left out."""
        self.console.print(
            f"go on with: shaderlab run --resume {display_path(folder)}", markup=False
        )

    def profile(self, run: Run) -> None:
        """Where the time of all records went, by phase."""
        spent: dict[str, float] = {}
        for record in run.records:
            for phase, seconds in record.timings.items():
                spent[phase] = spent.get(phase, 0.0) + seconds
        inside = sum(record.seconds for record in run.records)
        spent["other"] = max(inside - sum(spent.values()), 0.0)
        table = Table(box=None, pad_edge=False, header_style="dim")
        for heading in ("phase", "seconds", "share"):
            table.add_column(heading, justify="left" if heading == "phase" else "right")
        table.add_column("")
        for phase, seconds in spent.items():
            share = seconds / inside if inside else 0.0
            table.add_row(phase, f"{seconds:.3f}", f"{share:.0%}", "█" * round(40 * share))
        self.console.print()
        self.console.print(table)
        slowest = sorted(run.records, key=lambda record: -record.seconds)[:SLOWEST]
        for record in slowest:
            line = f"{record.seconds:8.3f} s  {label(record.id, record.variant)}"
            self.console.print(line, markup=False)


def _width(row: Row) -> float:
    widths = row["widths"]
    return math.inf if widths is None else float(widths)


class _Live:
    def __init__(self, progress: Progress, total: int) -> None:
        self._progress = progress
        self._task = progress.add_task("", total=total)

    def starts(self, case_id: str, variant: str) -> None:
        name = label(case_id, variant).replace("[", r"\[")
        self._progress.update(self._task, description=f"{name:<32}")

    def ends(self, record: Record) -> None:
        self._progress.advance(self._task)


class _Plain:
    def __init__(self, console: Console, total: int) -> None:
        self._console = console
        self._total = total
        self._done = 0
        self._next = time.monotonic() + HEARTBEAT

    def starts(self, case_id: str, variant: str) -> None:
        if time.monotonic() >= self._next:
            self._next = time.monotonic() + HEARTBEAT
            self._say(f"{self._done} of {self._total} done; running {label(case_id, variant)}")

    def ends(self, record: Record) -> None:
        self._done += 1
        if failed(record):
            self._say(f"{record.status}: {label(record.id, record.variant)}")

    def _say(self, line: str) -> None:
        self._console.print(line, markup=False)
