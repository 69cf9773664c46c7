"""Measured figures over a number, as one chart: a line with dots for each series, and bounds.

Every series has a colour and a dash of its own, so that colour alone need not tell them apart. A
bound is a short bar above or below its point, with a stem towards what it allows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from shaderlab.records import Plot, PlotPoint
from shaderlab.report.axes import Axis, axis
from shaderlab.report.chart import BOTTOM, LEFT, RIGHT, TOP, WIDTH
from shaderlab.report.text import figure

HEIGHT = 262.0
# How many series can be told apart: the style sheet has a colour for each.
COLOURS = 6
_STEM = 9.0


@dataclass(frozen=True)
class SeriesView:
    """One series: its name, the number of its colour, its line and its dots as SVG paths."""

    name: str
    colour: int
    line: str
    dots: str


@dataclass(frozen=True)
class PlotRow:
    """One row of the table: the point, what was expected, and where it is drawn or None."""

    point: PlotPoint
    expected: str
    at: tuple[float, float] | None


@dataclass(frozen=True)
class PlotView:
    """Everything the template draws, in the coordinates of a `width` × `height` drawing."""

    plot: Plot
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    series: list[SeriesView]
    bounds: str
    outside: str
    rows: list[PlotRow]
    bad: int
    hidden: int
    width: float = WIDTH
    height: float = HEIGHT
    left: float = LEFT
    right: float = RIGHT
    top: float = TOP
    bottom: float = BOTTOM

    @property
    def several(self) -> bool:
        """Whether series have to be told apart."""
        return len(self.series) > 1


def plot_view(plot: Plot) -> PlotView:
    """Lay a plot out; one without `x_ticks` has nothing that could be drawn."""
    across = axis([p.x for p in plot.points], LEFT, RIGHT, log=plot.log_x, margin=0.04)
    up = axis(_heights(plot), BOTTOM, TOP, log=plot.log_y, margin=0.08)
    names = list(dict.fromkeys(p.series for p in plot.points))
    if across is None or up is None:
        rows = [PlotRow(p, _expected(p), None) for p in plot.points]
        hidden, bad = len(rows), sum(not p.ok for p in plot.points)
        return PlotView(plot, [], [], [], "", "", rows, bad, hidden)
    rows = [PlotRow(p, _expected(p), _place(p, across, up)) for p in plot.points]
    return PlotView(
        plot=plot,
        x_ticks=across.ticks(6),
        y_ticks=up.ticks(5),
        series=[
            _series(name, n % COLOURS, [r for r in rows if r.point.series == name])
            for n, name in enumerate(names)
        ],
        bounds="".join(_bounds(row, up) for row in rows),
        outside=_dots([row.at for row in rows if row.at and not row.point.ok]),
        rows=rows,
        bad=sum(not p.ok for p in plot.points),
        hidden=sum(row.at is None for row in rows),
    )


def _heights(plot: Plot) -> list[float]:
    """What the upright axis must show: the figures, and the bounds that are near them."""
    figures = [p.y for p in plot.points if math.isfinite(p.y)]
    bounds = [b for p in plot.points for b in (p.low, p.high)]
    if plot.log_y or not figures:
        return figures + bounds
    low, high = min(figures), max(figures)
    room = 2.0 * (high - low) or abs(high) or 1.0
    return figures + [b for b in bounds if low - room <= b <= high + room]


def _place(point: PlotPoint, across: Axis, up: Axis) -> tuple[float, float] | None:
    if not (across.holds(point.x) and up.holds(point.y)):
        return None
    return across.at(point.x), up.at(point.y)


def _series(name: str, colour: int, rows: list[PlotRow]) -> SeriesView:
    line, pen_up = "", True
    for row in sorted(rows, key=lambda row: row.point.x):
        if row.at is None:
            pen_up = True
            continue
        line += f"{'M' if pen_up else 'L'}{row.at[0]:g} {row.at[1]:g}"
        pen_up = False
    return SeriesView(name, colour, line, _dots([row.at for row in rows if row.at]))


def _dots(places: list[tuple[float, float]]) -> str:
    """Strokes without length: with round caps each is a dot."""
    return "".join(f"M{x:g} {y:g}h0" for x, y in places)


def _bounds(row: PlotRow, up: Axis) -> str:
    if row.at is None:
        return ""
    x, point, path = row.at[0], row.point, ""
    for bound, towards in ((point.low, -1.0), (point.high, 1.0)):
        if up.holds(bound):
            y = up.at(bound)
            # Upwards on the page is towards smaller y.
            path += f"M{x - 6:g} {y:g}h12M{x:g} {y:g}v{towards * _STEM:g}"
    return path


def _expected(point: PlotPoint) -> str:
    low, high = figure(point.low), figure(point.high)
    if point.low == float("-inf"):
        return "–" if point.high == float("inf") else f"≤ {high}"
    return f"≥ {low}" if point.high == float("inf") else f"{low} … {high}"
