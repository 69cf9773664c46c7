"""Plots of a sweep: the largest distances over a parameter."""

from __future__ import annotations

import math
from collections.abc import Iterator

from shaderlab.model.records import Plot, PlotPoint

from .sweep_grid import SIZE
from .sweep_table import SweepTable

MOST_SERIES = 6
"""The number of colours that a plot has for series."""
MOST_DOTS = 1000
PARTS = 300
"""A plot that would have more dots has one for each series in so many equal parts of its points:
about two pixels of a page."""

_TITLES = {
    "widths": ("Worst distance from the band's middle", "half band widths", 1.0),
    "ulp": ("Worst distance from the reference", "ULP", math.inf),
}


def plots(table: SweepTable) -> tuple[Plot, ...]:
    """The largest distances over the parameter with the most values. Another parameter with few
    values, if there is one, gives the series; the maximum is taken over all others, and over
    neighbouring values where there are very many."""
    swept = table.grid.parameters
    seen = _seen(table)
    axes = sorted(range(len(swept)), key=lambda axis: swept[axis].name == SIZE)  # sizes last
    across = max(axes, key=lambda axis: len(seen[axis]))
    if len(seen[across]) < 2:
        return ()
    few = (axis for axis in axes if axis != across and 2 <= len(seen[axis]) <= MOST_SERIES)
    series = next(few, None)
    parts = _parts(len(seen[across]), 1 if series is None else len(seen[series]))
    over = [
        parameter.name
        for axis, parameter in enumerate(swept)
        if axis not in (across, series) and len(seen[axis]) > 1
    ]
    least, most = min(seen[across]), max(seen[across])
    drawn = []
    for column, (title, label, high) in _TITLES.items():
        points = tuple(_largest(table, across, series, seen[across], parts, column, high))
        heights = [point.y for point in points]
        if not heights:
            continue
        what = f"largest over {' and '.join(over)}" if over else "largest"
        binned = f" in each of {parts} parts" if parts < len(seen[across]) else ""
        drawn.append(
            Plot(
                title=title + (f", {what}{binned}" if over or binned else ""),
                x_label=swept[across].name,
                y_label=label,
                points=points,
                log_x=least > 0.0 and most / least >= 50.0,
                log_y=min(heights) > 0.0 and max(heights) / min(heights) >= 1000.0,
            )
        )
    return tuple(drawn)


def _seen(table: SweepTable) -> list[dict[float, int]]:
    """For each parameter its values at points that were run, and which of them each is by size."""
    grid = table.grid
    found: list[set[int]] = [set() for _ in grid.parameters]
    for point in table.points():
        for places, place in zip(found, grid.places(point), strict=True):
            places.add(place)
    values = (
        sorted(parameter.values[place] for place in places)
        for parameter, places in zip(grid.parameters, found, strict=True)
    )
    return [{value: n for n, value in enumerate(some)} for some in values]


def _parts(values: int, series: int) -> int:
    """Into how many parts so many values are taken."""
    return values if values * series <= MOST_DOTS else min(values, PARTS)


def _largest(
    table: SweepTable,
    across: int,
    series: int | None,
    seen: dict[float, int],
    parts: int,
    column: str,
    high: float,
) -> Iterator[PlotPoint]:
    """The largest value of a column in each part, where it is."""
    grid, values = table.grid, table.column(column)
    worst: dict[tuple[float, int], tuple[float, float]] = {}
    for point in table.points():
        if math.isnan(values[point]):
            continue
        found = [p.values[n] for p, n in zip(grid.parameters, grid.places(point), strict=True)]
        of, x = 0.0 if series is None else found[series], found[across]
        key = of, seen[x] * parts // len(seen)
        if key not in worst or values[point] > worst[key][0]:
            worst[key] = values[point], x
    for (of, _), (y, x) in sorted(worst.items()):
        name = column if series is None else f"{grid.parameters[series].name} {of:g}"
        yield PlotPoint(series=name, x=x, y=y, low=-math.inf, high=high, ok=y <= high)
