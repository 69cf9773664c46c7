"""How `shaderlab run` looks in a terminal, and in a file or a CI log."""

from __future__ import annotations

import math
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from shaderlab.cli.rows import STYLES, case_table, plain_table
from shaderlab.files import display_path
from shaderlab.model.records import Record, Run
from shaderlab.report.plain_text import (
    MARKS,
    conditions,
    counted,
    coverage_lines,
    failed,
    failure,
    gl_call_lines,
    label,
    summary,
    tally,
    unread,
)
from shaderlab.report.text import duration

if TYPE_CHECKING:
    from shaderlab.workers.sweep_table import SweepTable

HEARTBEAT = 10.0
MOST_ROWS = 40
MOST_CASES = 200
"""More than the catalogue has, and more than people read."""
MOST_MESSAGES = 5
SLOWEST = 5


class Show:
    """Everything `run` prints. With `to_stderr`, standard output stays free for data."""

    def __init__(self, to_stderr: bool = False) -> None:
        self.console = Console(
            file=sys.stderr if to_stderr else sys.stdout,
            highlight=False,
            markup=False,
            emoji=False,
            soft_wrap=True,
        )

    @contextmanager
    def progress(self, total: int, most_said: float = math.inf) -> Iterator[Reporter]:
        """A bar on a terminal; elsewhere a line for each failure, at most so many of them, and one
        now and then."""
        with self.bar() as bar:
            yield Reporter(self.console, bar, total, most_said)

    def bar(self) -> Progress:
        """A progress bar, drawn on a terminal only."""
        return Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("left", style="dim"),
            TimeRemainingColumn(),
            console=self.console,
            transient=True,
            disable=not self.console.is_terminal,
        )

    def outcomes(self, run: Run) -> None:
        """A table of all cases, each failure in full, and a line that sums up. Of more than
        `MOST_CASES` the table has what did not pass."""
        listed = run.records
        if len({(record.id, record.file) for record in listed}) > MOST_CASES:
            listed = tuple(record for record in listed if record.status != "pass")
        if listed:
            self.console.print(case_table(listed, self.console.width))
        if passed := len(run.records) - len(listed):
            words = f"not listed: {passed:,} that passed; the report has all"
            self.console.print(words, style="dim")
        for record in run.records:
            if failed(record):
                self.console.print()
                self._failure(record)
        notes = [*conditions(run), *unread(run.records)]
        if notes:
            self.console.print()
        for line in notes[:MOST_ROWS]:
            self.console.print(line, style="yellow")
        if len(notes) > MOST_ROWS:
            self.console.print(f"… and {len(notes) - MOST_ROWS} more", style="yellow")
        self.console.print()
        self._summary(run, summary(run), bad=any(map(failed, run.records)))

    def verdict(self, record: Record) -> None:
        """A record's verdict as soon as it is there: a line, or a failure in full."""
        if failed(record):
            self._failure(record)
        else:
            name = label(record.id, record.variant)
            said = f" ({record.message})" if record.message else ""
            self.console.print(f"{MARKS[record.status]} {name}{said}", style=STYLES[record.status])

    def total(self, records: Sequence[Record], seconds: float) -> None:
        """The line that sums up some records, and the time from a save to it."""
        style = "bold red" if any(map(failed, records)) else "bold green"
        self.console.print(f"{tally(records)} in {duration(seconds)}", style=style)

    def _failure(self, record: Record) -> None:
        for line in failure(record):
            style = "red" if line.lstrip().startswith(MARKS["fail"]) else None
            self.console.print(line, style=style)

    def _summary(self, run: Run, words: str, *, bad: bool) -> None:
        """The line that sums up: red for a failure, green where all was run and passed."""
        style = "bold red" if bad else "bold yellow" if run.missing else "bold green"
        self.console.print(words, style=style)
        if renderer := run.driver.get("renderer"):
            self.console.print(f"on {renderer}", style="dim")

    def gl_calls(self, run: Run) -> None:
        """The calls of OpenGL that were recorded."""
        for record in run.records:
            for line in gl_call_lines(record):
                self.console.print(line, highlight=False, markup=False)

    def coverage(self, run: Run) -> None:
        """What the judged pixels of each case never did."""
        if run.code_coverage:
            self.console.print()
        for each in run.code_coverage:
            line, *gaps = coverage_lines(each)
            self.console.print(line, style="yellow" if gaps or each.message else None)
            for gap in gaps:
                self.console.print(f"  {gap}")

    def sweep(self, points: SweepTable, run: Run) -> None:
        """A sweep's table; of a long one the worst points, and how many there are."""
        count = points.statuses.total()
        shown = [points.row(point) for point in sorted(points.worst(MOST_ROWS))]
        swept = list(shown[0])[: list(shown[0]).index("status")] if shown else []
        numbers = ("half widths", "ulp", "outside", "vacuous", "seconds")
        table = plain_table(*swept, "status", *numbers, right=(*swept, *numbers))
        for row in shown:
            style = STYLES.get(str(row["status"]), "red")
            outside = f"{row['outside']} of {row['judged']}"
            table.add_row(
                *(f"{row[name]:.6g}" for name in swept),
                Text(str(row["status"]), style),
                *("" if row[n] is None else f"{row[n]:.3g}" for n in ("widths", "ulp")),
                outside,
                "" if row["vacuous"] is None else f"{row['vacuous']:.0%}",
                f"{row['seconds']:.3f}",
            )
        self.console.print(table)
        if len(shown) < count:
            self.console.print(f"the {len(shown)} worst of {count} points", style="dim")
        for message in points.messages[:MOST_MESSAGES]:
            self.console.print(message, style="red")
        words = f"{count} points: {counted(points.statuses, run.missing)} in {run.seconds:.1f} s"
        self._summary(run, f"\n{words}", bad=points.failed > 0)

    def where(self, page: Path) -> None:
        """The path of the page."""
        self.console.print(f"report: {display_path(page)}")

    def profile(self, run: Run) -> None:
        """The time of all records by phase, and the slowest of them."""
        spent: dict[str, float] = defaultdict(float)
        for record in run.records:
            for phase, seconds in record.timings.items():
                spent[phase] += seconds
        inside = sum(record.seconds for record in run.records)
        spent["other"] = max(inside - sum(spent.values()), 0.0)
        table = plain_table("phase", "seconds", "share", "", right=("seconds", "share"))
        for phase, seconds in spent.items():
            share = seconds / inside if inside else 0.0
            table.add_row(phase, f"{seconds:.3f}", f"{share:.0%}", "█" * round(40 * share))
        self.console.print()
        self.console.print(table)
        slowest = sorted(run.records, key=lambda record: -record.seconds)[:SLOWEST]
        for record in slowest:
            self.console.print(f"{record.seconds:8.3f} s  {label(record.id, record.variant)}")


class Reporter:
    """The progress of a run: in a bar, or in lines where that is not drawn."""

    def __init__(self, console: Console, bar: Progress, total: int, most_said: float) -> None:
        self._console = console
        self._bar = bar
        self._task = bar.add_task("", total=total)
        self._total = total
        self._done = 0
        self._failed = 0
        self._most_said = most_said
        self._began = time.monotonic()
        self._next = self._began + HEARTBEAT

    def starts(self, case_id: str, variant: str, driver: str = "") -> None:
        """A scene starts."""
        name = label(case_id, variant) + (f" on {driver}" if driver else "")
        self._bar.update(self._task, description=f"{name:<32}")
        now = time.monotonic()
        if now >= self._next:
            self._next = now + HEARTBEAT
            left = ""
            if self._done:
                seconds = (now - self._began) / self._done * (self._total - self._done)
                left = f", about {duration(seconds)} left"
            self._say(f"{self._done} of {self._total} done{left}; running {name}")

    def ends(self, record: Record) -> None:
        """A scene is done."""
        self.advance()
        if failed(record):
            self._failed += 1
            where = f" on {record.driver_name}" if record.driver_name else ""
            if self._failed <= self._most_said:
                self._say(f"{record.status}: {label(record.id, record.variant)}{where}")
            elif self._failed == self._most_said + 1:
                self._say("more do not pass, which are not named here")

    def advance(self) -> None:
        """A scene, or something else, is done."""
        self._bar.advance(self._task)
        self._done += 1

    def _say(self, line: str) -> None:
        if self._bar.disable:
            self._console.print(line)
