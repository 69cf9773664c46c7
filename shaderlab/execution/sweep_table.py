"""The results of a sweep: a row for each point, and plots over a parameter."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from shaderlab.activity import PHASES
from shaderlab.execution.jobs import Job
from shaderlab.execution.sweep_grid import coordinates
from shaderlab.records import Plot, PlotPoint, Record

MOST_SERIES = 6
"""The number of colours that a plot has for series."""

Cell = str | float | int | None
Row = Mapping[str, Cell]


def rows(jobs: Sequence[Job], records: Sequence[Record]) -> list[Row]:
    """A row for each point that was run, in the order of the jobs, all with the same columns.

    The parameters come first, by name. `widths` (half band widths) and `ulp` are the largest
    distances from the reference over all formulas, None if nothing was judged. `outside` and
    `judged` count values; `vacuous` is the largest share of values whose band allows any value.
    Then come the seconds, in total and in each phase.
    """
    found = {record.key: record for record in records}
    return [
        {**dict(coordinates(job)), **_figures(found[job.key])} for job in jobs if job.key in found
    ]


def plots(jobs: Sequence[Job], table: Sequence[Row]) -> tuple[Plot, ...]:
    """The largest distances over the parameter with the most values. Another parameter with few
    values, if there is one, gives the series; the maximum is taken over all others."""
    if not table or not jobs:
        return ()
    names = [name for name, _ in coordinates(jobs[0])]
    different = {name: sorted({_float(row[name]) for row in table}) for name in names}
    across = max(names, key=lambda name: len(different[name]))
    if len(different[across]) < 2:
        return ()
    few = [n for n in names if n != across and 2 <= len(different[n]) <= MOST_SERIES]
    series = few[0] if few else ""
    least, most = different[across][0], different[across][-1]
    log_x = least > 0.0 and most / least >= 50.0
    titles = {
        "widths": ("Worst distance from the band's middle", "half band widths", 1.0),
        "ulp": ("Worst distance from the reference", "ULP", math.inf),
    }
    drawn = []
    for column, (title, label, high) in titles.items():
        points = _largest(table, across, series, column, high)
        heights = [point.y for point in points]
        if not heights:
            continue
        log_y = min(heights) > 0.0 and max(heights) / min(heights) >= 1000.0
        over = [n for n in names if n not in (across, series) and len(different[n]) > 1]
        drawn.append(
            Plot(
                title=title + (f", largest over {' and '.join(over)}" if over else ""),
                x_label=across,
                y_label=label,
                points=points,
                log_x=log_x,
                log_y=log_y,
            )
        )
    return tuple(drawn)


def _largest(
    table: Sequence[Row], across: str, series: str, column: str, high: float
) -> tuple[PlotPoint, ...]:
    worst: dict[tuple[float, float], float] = {}
    for row in table:
        if row[column] is None:
            continue
        key = (_float(row[series]) if series else 0.0, _float(row[across]))
        worst[key] = max(worst.get(key, 0.0), _float(row[column]))
    return tuple(
        PlotPoint(
            series=f"{series} {of:g}" if series else column,
            x=x,
            y=y,
            low=-math.inf,
            high=high,
            ok=y <= high,
        )
        for (of, x), y in sorted(worst.items())
    )


def _figures(record: Record) -> dict[str, Cell]:
    outcomes = record.expectations
    worst = [outcome.worst for outcome in outcomes if outcome.worst is not None]
    return {
        "status": record.status,
        "widths": max((_or_infinite(w.widths) for w in worst), default=None),
        "ulp": max((_or_infinite(w.ulp) for w in worst), default=None),
        "outside": sum(outcome.outside for outcome in outcomes),
        "judged": sum(outcome.judged for outcome in outcomes),
        "vacuous": max((outcome.vacuous for outcome in outcomes), default=None),
        "seconds": record.seconds,
        **{phase: record.timings.get(phase, 0.0) for phase in PHASES},
        "message": record.message,
    }


def _or_infinite(distance: float) -> float:
    """A NaN counts as infinitely far away."""
    return math.inf if math.isnan(distance) else distance


def _float(cell: Cell) -> float:
    assert cell is not None
    return float(cell)
