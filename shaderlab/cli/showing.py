"""How runs look in a terminal, and in a file or a CI log."""

import math
import sys
import time
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table
from rich.text import Text

from shaderlab.engine.jobs import Job
from shaderlab.files import display_path
from shaderlab.model.records import Outcome, Record, Run
from shaderlab.report import text

STYLES = {"pass": "green", "unsupported": "yellow"}
_HEADINGS = ("", "case", "section", "variants", "checks", "of band", "seconds", "compiled")
_INFORMATIVE = "informative"
_NAME = 8  # characters of a name that are always shown
_RIGHT = frozenset({"variants", "checks", "of band", "seconds", _INFORMATIVE})


def make_table(
    *headings: str, right: Collection[str], whole: Collection[str] | None = None
) -> Table:
    """An empty table without lines, some columns aligned to the `right`. Cells of the `whole` ones,
    by default all others, are never broken into lines."""
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in headings:
        aligned = heading in right
        table.add_column(
            heading,
            justify="right" if aligned else "left",
            no_wrap=not aligned if whole is None else heading in whole,
        )
    return table


def make_case_table(records: Iterable[Record]) -> Table:
    """A row for all variants of a case that passed, and one for each other variant.

    The least share of informative values has a column where it is not 100 % everywhere. In a
    narrow terminal names are cut.
    """
    records = list(records)
    tells = any(o.informative not in (None, 1.0) for r in records for o in r.expectations)
    headings = (*_HEADINGS, *([_INFORMATIVE] if tells else []))
    table = make_table(*headings, right=_RIGHT, whole=[h for h in headings if h != "case"])
    table.columns[1].min_width = _NAME
    cases: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        cases.setdefault((record.id, record.file), []).append(record)
    for group in cases.values():
        passed = [r for r in group if r.status == "pass"]
        if passed:
            table.add_row(*_cells(passed[0].id, passed, f"{len(passed)}/{len(group)}", tells))
        for record in group:
            if record.status != "pass":
                name = text.format_label(record.id, record.variant)
                table.add_row(*_cells(name, [record], "", tells))
    return table


def _cells(name: str, group: Sequence[Record], variants: str, tells: bool) -> Sequence[Text]:
    outcomes = [outcome for record in group for outcome in record.expectations]
    good = sum(outcome.status == "pass" for outcome in outcomes)
    widths = [o.worst.widths for o in outcomes if o.worst is not None]
    status = group[0].status
    left = sum(len(record.not_asked) for record in group)
    checks = f"{good}/{len(outcomes)}" + (f", {left} skipped" if left else "")
    plain = (
        name,
        group[0].section,
        variants,
        checks if outcomes else status,
        _format_share(max(widths)) if widths else "",
        f"{sum(record.seconds for record in group):.2f}",
    )
    # Texts, not strings: a name is no markup, and parsing markup takes half of a table's time.
    return (
        Text(text.MARKS[status], STYLES.get(status, "red")),
        *(Text(text.clean(cell)) for cell in plain),
        _format_compiled(group),
        *([Text(_format_informative(outcomes))] if tells else []),
    )


def _format_informative(outcomes: Sequence[Outcome]) -> str:
    shares = [o.informative for o in outcomes if o.informative is not None]
    return text.share(min(shares)) if shares else ""


def _format_share(widths: float) -> str:
    """How much of its band the worst value uses: 100 % is the edge."""
    if not math.isfinite(widths) or widths >= 100:
        return "> 9999 %"
    return "< 1 %" if 0 < widths < 0.01 else f"{100 * widths:.0f} %"


def _format_compiled(group: Sequence[Record]) -> Text:
    """How many targets accept, or the names of those that refuse."""
    verdicts = {item for record in group for item in record.compile.items()}
    refusing = {target for target, verdict in verdicts if verdict not in ("ok", "pass")}
    targets = {target for target, _ in verdicts}
    if refusing:
        return Text(f"not {', '.join(sorted(refusing))}", "red")
    return Text(f"{len(targets)}/{len(targets)}" if targets else "", "green")


HEARTBEAT = 10.0
MOST_ROWS = 40
MOST_CASES = 200
"""More than the catalogue has, and more than people read."""


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
        if not self.console.is_terminal:  # a file has no width, and cut names are of no use
            self.console.width = max(self.console.width, 160)

    @contextmanager
    def progress(self, total: int) -> "Iterator[Reporter]":
        """A bar on a terminal; elsewhere a line for each failure, and one now and then."""
        with self.bar() as bar:
            yield Reporter(self.console, bar, total)

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
            self.console.print(make_case_table(listed))
        if passed := len(run.records) - len(listed):
            words = f"not listed: {passed:,} that passed; the report has all"
            self.console.print(words, style="dim")
        for record in run.records:
            if text.has_failed(record):
                self.console.print()
                self._failure(record)
        notes = [
            f"{text.format_label(r.id, r.variant)} is unsupported: "
            + " ".join(text.clean(r.message).split())
            for r in run.records
            if r.status == "unsupported"
        ]
        notes += [*text.format_conditions(run), *text.format_unread(run.records)]
        notes += [
            text.clean(f"{text.format_label(r.id, r.variant)}, {o.name}: {o.message}")
            for r in run.records
            for o in r.expectations
            if o.status == "pass" and o.message
        ]
        if notes:
            self.console.print()
        for line in notes[:MOST_ROWS]:
            self.console.print(line, style="yellow")
        if len(notes) > MOST_ROWS:
            self.console.print(f"… and {len(notes) - MOST_ROWS} more", style="yellow")
        self.console.print()
        bad = any(map(text.has_failed, run.records))
        style = "bold red" if bad else "bold yellow" if run.missing else "bold green"
        self.console.print(text.format_summary(run), style=style)
        if renderer := run.driver.get("renderer"):
            self.console.print(f"on {renderer}", style="dim")

    def verdict(self, record: Record) -> None:
        """A record's verdict as soon as it is there: a line, or a failure in full."""
        if text.has_failed(record):
            self._failure(record)
        else:
            name = text.format_label(record.id, record.variant)
            said = f" ({record.message})" if record.message else ""
            self.console.print(
                f"{text.MARKS[record.status]} {name}{said}", style=STYLES[record.status]
            )

    def total(self, records: Sequence[Record], seconds: float) -> None:
        """The line that sums up some records, and the time from a save to it."""
        style = "bold red" if any(map(text.has_failed, records)) else "bold green"
        self.console.print(f"{text.format_tally(records)} in {text.duration(seconds)}", style=style)

    def _failure(self, record: Record) -> None:
        for line in text.format_failure(record):
            style = "red" if line.lstrip().startswith(text.MARKS["fail"]) else None
            self.console.print(line, style=style)

    def gl_calls(self, run: Run) -> None:
        for record in run.records:
            for line in text.format_gl_calls(record):
                self.console.print(line, highlight=False, markup=False)

    def where(self, page: Path) -> None:
        self.console.print(f"report: {display_path(page)}")


class Reporter:
    """The progress of a run: in a bar, or in lines where that is not drawn."""

    def __init__(self, console: Console, bar: Progress, total: int) -> None:
        self._console = console
        self._bar = bar
        self._task = bar.add_task("", total=total)
        self._total = total
        self._done = 0
        self._began = time.monotonic()
        self._next = self._began + HEARTBEAT

    def follow(
        self, jobs: Sequence[Job], results: Iterator[tuple[Job, Record]]
    ) -> Iterator[tuple[Job, Record]]:
        """Yield the jobs' results as they come, and show how far they are."""
        waiting = {job.key: job for job in jobs}
        while waiting:
            self.starts(*next(iter(waiting)))
            job, record = next(results)
            yield job, record
            del waiting[job.key]
            self.ends(record)

    def starts(self, case_id: str, variant: str, driver: str = "") -> None:
        name = text.format_label(case_id, variant) + (f" on {driver}" if driver else "")
        self._bar.update(self._task, description=f"{name:<32}")
        now = time.monotonic()
        if now >= self._next:
            self._next = now + HEARTBEAT
            left = ""
            if self._done:
                seconds = (now - self._began) / self._done * (self._total - self._done)
                left = f", about {text.duration(seconds)} left"
            self._print_line(f"{self._done} of {self._total} done{left}; running {name}")

    def ends(self, record: Record) -> None:
        self._bar.advance(self._task)
        self._done += 1
        if text.has_failed(record):
            where = f" on {record.driver_name}" if record.driver_name else ""
            self._print_line(
                f"{record.status}: {text.format_label(record.id, record.variant)}{where}"
            )

    def _print_line(self, line: str) -> None:
        if self._bar.disable:
            self._console.print(line)
