"""The table of cases of `shaderlab run`: a row for each, and for each variant that failed."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence

from rich.table import Table
from rich.text import Text

from shaderlab.model.records import Outcome, Record
from shaderlab.report.plain_text import MARKS, label, printable
from shaderlab.report.text import share

STYLES = {"pass": "green", "unsupported": "yellow"}
_HEADINGS = ("", "case", "section", "variants", "checks", "of band", "seconds", "compiled")
_INFORMATIVE = "informative"
_NAMES = 1  # the column of names,
_NAME = 16  # of which this much is always shown,
_HEADING = 6  # and of a heading this
# What is left out of a narrow terminal's table, the first of these first.
_LEAST = (_INFORMATIVE, "compiled", "section", "seconds", "variants", "of band", "checks")
_RIGHT = frozenset({"variants", "checks", "of band", "seconds", _INFORMATIVE})


def plain_table(
    *headings: str, right: Collection[str], whole: Collection[str] | None = None
) -> Table:
    """An empty table without lines.

    Args:
        headings: of its columns.
        right: those aligned to the right.
        whole: those whose cells are never broken into lines, by default all others.
    """
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in headings:
        aligned = heading in right
        table.add_column(
            heading,
            justify="right" if aligned else "left",
            no_wrap=not aligned if whole is None else heading in whole,
        )
    return table


def case_table(records: Iterable[Record], width: int) -> Table:
    """A row for all variants of a case that passed, and one for each other variant.

    The least share of informative values has a column where it is not 100 % everywhere. Columns are
    left out where a table of all would be wider than `width`; names are cut last.
    """
    records = list(records)
    tells = any(o.informative not in (None, 1.0) for r in records for o in r.expectations)
    headings = (*_HEADINGS, *([_INFORMATIVE] if tells else []))
    rows: list[Sequence[Text]] = []
    cases: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        cases.setdefault((record.id, record.file), []).append(record)
    for group in cases.values():
        passed = [r for r in group if r.status == "pass"]
        if passed:
            rows.append(_cells(passed[0].id, passed, f"{len(passed)}/{len(group)}", tells))
        for record in group:
            if record.status != "pass":
                rows.append(_cells(label(record.id, record.variant), [record], "", tells))
    return _fitted(headings, rows, width)


def _fitted(headings: Sequence[str], rows: Sequence[Sequence[Text]], width: int) -> Table:
    """The table without the columns that it has no room for; headings are cut before, and names
    where the others leave them no room."""
    cells = [max((row[n].cell_len for row in rows), default=0) for n in range(len(headings))]
    whole = [max(cell, len(heading)) for cell, heading in zip(cells, headings, strict=True)]
    least = [max(cell, min(len(h), _HEADING)) for cell, h in zip(cells, headings, strict=True)]
    least[_NAMES] = min(least[_NAMES], _NAME)
    shown = list(range(len(headings)))

    def needed(widths: Sequence[int]) -> int:
        return sum(widths[n] for n in shown) + 2 * len(shown) - 2

    for name in _LEAST:
        if needed(least) > width:
            shown = [n for n in shown if headings[n] != name]
    if needed(whole) > width:
        spare = width - needed(least)
        whole = [*least]
        whole[_NAMES] += max(0, min(spare, cells[_NAMES] - least[_NAMES]))
    table = plain_table(
        *(_cut(headings[n], whole[n]) for n in shown),
        right={_cut(headings[n], whole[n]) for n in shown if headings[n] in _RIGHT},
        whole={_cut(headings[n], whole[n]) for n in shown},
    )
    for row in rows:
        row[_NAMES].truncate(whole[_NAMES], overflow="ellipsis")
        table.add_row(*(row[n] for n in shown))
    return table


def _cut(heading: str, width: int) -> str:
    return heading if len(heading) <= width else heading[: width - 1] + "…"


def _cells(name: str, group: Sequence[Record], variants: str, tells: bool) -> Sequence[Text]:
    outcomes = [outcome for record in group for outcome in record.expectations]
    good = sum(outcome.status == "pass" for outcome in outcomes)
    widths = [o.worst.widths for o in outcomes if o.worst is not None]
    status = group[0].status
    left = sum(len(record.not_asked) for record in group)
    checks = f"{good}/{len(outcomes)}" + (f", {left} not asked" if left else "")
    plain = (
        name,
        group[0].section,
        variants,
        checks if outcomes else status,
        _share(max(widths)) if widths else "",
        f"{sum(record.seconds for record in group):.2f}",
    )
    # Texts, not strings: a name is no markup, and parsing markup takes half of a table's time.
    return (
        Text(MARKS[status], STYLES.get(status, "red")),
        *(Text(printable(cell)) for cell in plain),
        _compiled(group),
        *([Text(_informative(outcomes))] if tells else []),
    )


def _informative(outcomes: Sequence[Outcome]) -> str:
    shares = [o.informative for o in outcomes if o.informative is not None]
    return share(min(shares)) if shares else ""


def _share(widths: float) -> str:
    """How much of its band the worst value uses: 100 % is the edge."""
    if not math.isfinite(widths) or widths >= 100:
        return "> 9999 %"
    return "< 1 %" if 0 < widths < 0.01 else f"{100 * widths:.0f} %"


def _compiled(group: Sequence[Record]) -> Text:
    """How many targets accept, or the names of those that refuse."""
    refusing = {
        target
        for record in group
        for target, verdict in record.compile.items()
        if verdict not in ("ok", "pass")
    }
    targets = {target for record in group for target in record.compile}
    if refusing:
        return Text(f"not {', '.join(sorted(refusing))}", "red")
    return Text(f"{len(targets)}/{len(targets)}" if targets else "", "green")
