"""A curve as two small charts: measured points on their reference, and where in the band each is.

A derived band is mostly thinner than a line, so the second chart stretches it: −1 and 1 are its
edges at every x. What can't be drawn (NaN, an infinity, x ≤ 0 on a logarithm) is counted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from shaderlab.model.records import Curve
from shaderlab.report.axes import Axis, Plane, axis
from shaderlab.report.worst import half_widths, outside

WIDTH = 460.0
LEFT, RIGHT = 62.0, 448.0
TOP, BOTTOM = 14.0, 214.0
STRIP_TOP, STRIP_BOTTOM = 246.0, 306.0
HEIGHT = 352.0
# Distances beyond this are drawn at the strip's edge.
FURTHEST = 1.6
_MOST_ROWS = 120
_STRIP = Axis(-FURTHEST, FURTHEST, STRIP_BOTTOM, STRIP_TOP)
_BAND_HEIGHT = (STRIP_BOTTOM - STRIP_TOP) / FURTHEST


Place = tuple[float, float | None, float | None]


@dataclass(frozen=True)
class Point:
    """One row of the chart's table. `at` is where it is drawn: x, and its height in each of the
    two charts, None where it is in none of them."""

    x: float
    measured: float
    reference: float
    low: float
    high: float
    widths: float
    outside: bool
    at: Place | None = None


@dataclass(frozen=True)
class Chart:
    """Everything the template draws, in the coordinates of a WIDTH × HEIGHT drawing.

    Without `x_ticks` there is nothing that could be drawn.
    """

    curve: Curve
    rows: list[Point]
    hidden: int
    bad: int
    x_ticks: Sequence[tuple[float, str]] = ()
    y_ticks: Sequence[tuple[float, str]] = ()
    band: str = ""
    reference: str = ""
    inside: str = ""
    outside: str = ""
    strip_inside: str = ""
    strip_outside: str = ""

    width, height, left, right, top, bottom = WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM
    strip_top, foot = STRIP_TOP, STRIP_BOTTOM
    strip_ticks = tuple((_STRIP.at(at), label) for at, label in ((1, "+1"), (0, "0"), (-1, "−1")))
    band_top, band_height = _STRIP.at(1), _BAND_HEIGHT


def chart(curve: Curve) -> Chart:
    """Lay out a curve."""
    given = zip(curve.x, curve.measured, curve.reference, curve.low, curve.high, strict=False)
    points = [
        Point(x, y, reference, low, high, half_widths(y, low, high), outside(y, low, high))
        for x, y, reference, low, high in given
    ]
    bad = [p for p in points if p.outside]
    across = axis([p.x for p in points], LEFT, RIGHT, log=curve.log_x, margin=0.02)
    up = axis(_heights(points), BOTTOM, TOP, log=False, margin=0.06)
    if across is None or up is None:
        return Chart(curve, _rows(points), hidden=len(points), bad=len(bad))
    plane, strip = Plane(across, up), Plane(across, _STRIP)
    drawn = [p for p in points if plane.at(p.x, p.measured)]
    return Chart(
        curve=curve,
        rows=[replace(p, at=_at(p, across, up)) for p in _rows(points)],
        hidden=len(points) - len(drawn),
        bad=len(bad),
        x_ticks=across.ticks(6),
        y_ticks=up.ticks(5),
        band=_band(points, plane),
        reference=plane.line((p.x, p.reference) for p in points),
        inside=plane.dots((p.x, p.measured) for p in drawn if not p.outside),
        outside=plane.dots((p.x, p.measured) for p in drawn if p.outside),
        strip_inside=strip.dots((p.x, p.widths) for p in points if not p.outside),
        strip_outside=strip.dots((p.x, _within_strip(p.widths)) for p in bad),
    )


def _rows(points: Sequence[Point]) -> list[Point]:
    """Rows for the table: of many points some, evenly chosen, and those outside."""
    step = max(1, math.ceil(len(points) / _MOST_ROWS))
    rows = [p for index, p in enumerate(points) if index % step == 0 or p.outside]
    return rows[: 4 * _MOST_ROWS]


def _at(point: Point, across: Axis, up: Axis) -> Place | None:
    if not across.holds(point.x):
        return None
    height = up.at(point.measured) if up.holds(point.measured) else None
    return across.at(point.x), height, _STRIP.at(_within_strip(point.widths))


def _within_strip(widths: float) -> float:
    return max(-FURTHEST, min(FURTHEST, widths))


def _heights(points: Sequence[Point]) -> list[float]:
    """What the upright axis must show: the reference, and measured values not far from it.

    One wild value would press everything else into a line; it is left to the lower chart.
    """
    reference = [p.reference for p in points if math.isfinite(p.reference)]
    if not reference:
        return [p.measured for p in points]
    low, high = min(reference), max(reference)
    span = high / 2 - low / 2 or abs(high) or 1.0
    near = [p.measured for p in points if -2 <= (p.measured / 2 - low / 2) / span <= 4]
    return reference + near


def _band(points: Sequence[Point], plane: Plane) -> str:
    """A closed SVG path around the band; parts without a finite band are left out."""
    runs: list[list[Point]] = [[]]
    for point in points:
        if plane.across.holds(point.x) and all(map(math.isfinite, (point.low, point.high))):
            runs[-1].append(point)
        elif runs[-1]:
            runs.append([])
    # Cut at the frame, or one wide band would leave the paper.
    low, high = plane.up.low, plane.up.high
    path = ""
    for run in runs:
        if len(run) > 1:
            edge = [(p.x, p.high) for p in run] + [(p.x, p.low) for p in reversed(run)]
            path += plane.line((x, min(max(y, low), high)) for x, y in edge) + "Z"
    return path
