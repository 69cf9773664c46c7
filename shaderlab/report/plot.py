"""Measured figures over a number, as one chart: a line with dots for each series, and bounds.

Every series has a colour and a dash of its own, so that colour alone need not tell them apart. A
bound is a short bar above or below its point, with a stem towards what it allows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter

from shaderlab.model.records import Plot, PlotPoint
from shaderlab.report.axes import Plane, axis
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
    """Everything the template draws, in the coordinates of a `width` × `height` drawing.

    Without `x_ticks` there is nothing that could be drawn.
    """

    plot: Plot
    rows: list[PlotRow]
    x_ticks: Sequence[tuple[float, str]] = ()
    y_ticks: Sequence[tuple[float, str]] = ()
    series: Sequence[SeriesView] = ()
    bounds: str = ""
    outside: str = ""

    width, height, left, right, top, bottom = WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM
    strip_top, foot = None, BOTTOM

    @property
    def several(self) -> bool:
        """Whether series have to be told apart."""
        return len(self.series) > 1

    @property
    def bad(self) -> int:
        """How many points are out of bounds."""
        return sum(not row.point.ok for row in self.rows)

    @property
    def hidden(self) -> int:
        """How many points can't be drawn."""
        return sum(row.at is None for row in self.rows)


def plot_view(plot: Plot) -> PlotView:
    """Lay a plot out."""
    points = plot.points
    across = axis([p.x for p in points], LEFT, RIGHT, log=plot.log_x, margin=0.04)
    up = axis(_heights(plot), BOTTOM, TOP, log=plot.log_y, margin=0.08)
    if across is None or up is None:
        return PlotView(plot, [PlotRow(p, _expected(p), None) for p in points])
    plane = Plane(across, up)
    series = []
    for n, name in enumerate(dict.fromkeys(p.series for p in points)):
        own = [(p.x, p.y) for p in points if p.series == name]
        line = plane.line(sorted(own, key=itemgetter(0)))
        series.append(SeriesView(name, n % COLOURS, line, plane.dots(own)))
    return PlotView(
        plot=plot,
        rows=[PlotRow(p, _expected(p), plane.at(p.x, p.y)) for p in points],
        x_ticks=across.ticks(6),
        y_ticks=up.ticks(5),
        series=series,
        bounds="".join(_bounds(p, plane) for p in points),
        outside=plane.dots((p.x, p.y) for p in points if not p.ok),
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


def _bounds(point: PlotPoint, plane: Plane) -> str:
    at = plane.at(point.x, point.y)
    path = ""
    for bound, towards in ((point.low, -1.0), (point.high, 1.0)):
        if at and plane.up.holds(bound):
            y = plane.up.at(bound)
            # Upwards on the page is towards smaller y.
            path += f"M{at[0] - 6:g} {y:g}h12M{at[0]:g} {y:g}v{towards * _STEM:g}"
    return path


def _expected(point: PlotPoint) -> str:
    low, high = figure(point.low), figure(point.high)
    if point.low == float("-inf"):
        return "–" if point.high == float("inf") else f"≤ {high}"
    return f"≥ {low}" if point.high == float("inf") else f"{low} … {high}"
