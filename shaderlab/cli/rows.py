"""The table of cases that `shaderlab run` prints: a row for each, and for each variant that failed.

It looks as Rich's tables do, and is one where it needs to be; but a table of Rich lays every cell
out as a text of its own, several times, and takes as long over a row as judging some small scenes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, JustifyMethod, RenderResult
from rich.segment import Segment
from rich.table import Table

from shaderlab.records import Record
from shaderlab.terminal import MARKS, label

STYLES = {"pass": "green", "unsupported": "yellow"}
_HEADINGS = ("", "case", "section", "variants", "checks", "of band", "seconds", "compiled")
_RIGHT = frozenset({"variants", "checks", "of band", "seconds"})
_GAP = "  "


@dataclass(frozen=True)
class Row:
    """The cells below the headings, and the styles of the first and the last."""

    cells: tuple[str, ...]
    mark_style: str
    compiled_style: str

    @property
    def plain(self) -> bool:
        """Whether no cell holds what Rich would take for more than itself (`:name:` is a picture)
        or what moves a terminal's cursor."""
        text = "".join(self.cells)
        return text.isprintable() and ":" not in text and "\\" not in text


class CaseTable:
    """What Rich prints for a run's records."""

    def __init__(self, records: Iterable[Record]) -> None:
        self._rows = list(_rows(records))

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        columns = zip(_HEADINGS, *(row.cells for row in self._rows), strict=True)
        widths = [max(map(cell_len, column)) for column in columns]
        room = options.max_width - len(_GAP) * (len(widths) - 1)
        if sum(widths) > room or not all(row.plain for row in self._rows):
            yield _table(self._rows)
            return
        yield _table((), widths)
        for row in self._rows:
            yield from _segments(row, widths, console)


def _segments(row: Row, widths: Sequence[int], console: Console) -> Iterator[Segment]:
    """A row where every cell has room on one line."""
    mark, *middle, compiled = row.cells
    padded = [
        " " * (width - cell_len(cell)) + cell
        if heading in _RIGHT
        else cell + " " * (width - cell_len(cell))
        for heading, cell, width in zip(_HEADINGS[1:-1], middle, widths[1:-1], strict=True)
    ]
    yield Segment(mark, console.get_style(row.mark_style))
    yield Segment(" " * (widths[0] - cell_len(mark)) + _GAP + _GAP.join(padded) + _GAP)
    if compiled:
        yield Segment(compiled, console.get_style(row.compiled_style))
    yield Segment(" " * (widths[-1] - cell_len(compiled)))
    yield Segment.line()


def _table(rows: Iterable[Row], widths: Sequence[int | None] = (None,) * len(_HEADINGS)) -> Table:
    """The rows, or with given `widths` no more than the headings, as a table of Rich."""
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading, width in zip(_HEADINGS, widths, strict=True):
        justify: JustifyMethod = "right" if heading in _RIGHT else "left"
        table.add_column(heading, justify=justify, no_wrap=heading == "case", width=width)
    for row in rows:
        mark, *middle, compiled = (cell.replace("[", r"\[") for cell in row.cells)
        table.add_row(
            f"[{row.mark_style}]{mark}[/]",
            *middle,
            f"[{row.compiled_style}]{compiled}[/]" if compiled else "",
        )
    return table


def _rows(records: Iterable[Record]) -> Iterator[Row]:
    """Variants that passed share a row, every other one has its own."""
    cases: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        cases.setdefault((record.id, record.file), []).append(record)
    for group in cases.values():
        passed = [r for r in group if r.status == "pass"]
        if passed:
            yield _row(passed[0].id, passed, f"{len(passed)}/{len(group)}")
        for record in group:
            if record.status != "pass":
                yield _row(label(record.id, record.variant), [record], "")


def _row(name: str, group: Sequence[Record], variants: str) -> Row:
    outcomes = [outcome for record in group for outcome in record.expectations]
    good = sum(outcome.status == "pass" for outcome in outcomes)
    widths = [o.worst.widths for o in outcomes if o.worst is not None]
    status = group[0].status
    compiled, style = _compiled(group)
    cells = (
        MARKS[status],
        name,
        group[0].section,
        variants,
        f"{good}/{len(outcomes)}" if outcomes else status,
        _share(max(widths)) if widths else "",
        f"{sum(record.seconds for record in group):.2f}",
        compiled,
    )
    return Row(cells, STYLES.get(status, "red"), style)


def _share(widths: float) -> str:
    """How much of its band the worst value uses: 100 % is the edge."""
    if not math.isfinite(widths) or widths >= 100:
        return "> 9999 %"
    return "< 1 %" if 0 < widths < 0.01 else f"{100 * widths:.0f} %"


def _compiled(group: Sequence[Record]) -> tuple[str, str]:
    """How many targets accept, or the names of those that refuse; and its style."""
    refusing = {
        target
        for record in group
        for target, verdict in record.compile.items()
        if verdict not in ("ok", "pass")
    }
    targets = {target for record in group for target in record.compile}
    if refusing:
        return f"not {', '.join(sorted(refusing))}", "red"
    return (f"{len(targets)}/{len(targets)}" if targets else ""), "green"
