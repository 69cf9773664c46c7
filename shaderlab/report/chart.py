"""A curve as two small charts: measured points on their reference, and where in the band each is.

A derived band is mostly thinner than a line, so the second chart stretches it: −1 and 1 are its
edges at every x. What can't be drawn (NaN, an infinity, x ≤ 0 on a logarithm) is counted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from shaderlab.records import Curve
from shaderlab.report.axes import Axis, axis

WIDTH = 460.0
LEFT, RIGHT = 62.0, 448.0
TOP, BOTTOM = 14.0, 214.0
STRIP_TOP, STRIP_BOTTOM = 246.0, 306.0
HEIGHT = 352.0
# Distances beyond this are drawn at the strip's edge.
FURTHEST = 1.6
_MOST_ROWS = 120


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
    at: tuple[float, float | None, float | None] | None = None


@dataclass(frozen=True)
class Chart:
    """Everything the template draws, in the coordinates of a WIDTH × HEIGHT drawing."""

    title: str
    x_label: str
    y_label: str
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    strip_ticks: list[tuple[float, str]]
    band: str
    reference: str
    inside: str
    outside: str
    strip_inside: str
    strip_outside: str
    points: list[Point]
    rows: list[Point]
    hidden: int
    bad: int


def chart(curve: Curve) -> Chart:
    """Lay out a curve; a chart without `x_ticks` has nothing that could be drawn."""
    points = [
        _point(*values)
        for values in zip(
            curve.x, curve.measured, curve.reference, curve.low, curve.high, strict=False
        )
    ]
    bad = [point for point in points if point.outside]
    across = axis([p.x for p in points], LEFT, RIGHT, log=curve.log_x, margin=0.02)
    up = axis(_heights(points), BOTTOM, TOP, log=False, margin=0.06)
    strip = Axis(-FURTHEST, FURTHEST, STRIP_BOTTOM, STRIP_TOP)
    drawn: list[Point] = []
    if across is not None and up is not None:
        drawn = [p for p in points if across.holds(p.x) and up.holds(p.measured)]
        points = [replace(p, at=_places(p, across, up, strip)) for p in points]
    step = max(1, math.ceil(len(points) / _MOST_ROWS))
    rows = [p for index, p in enumerate(points) if index % step == 0 or p.outside]
    empty = across is None or up is None
    return Chart(
        title=curve.title,
        x_label=curve.x_label,
        y_label=curve.y_label,
        x_ticks=[] if across is None or empty else across.ticks(6),
        y_ticks=[] if up is None or empty else up.ticks(5),
        strip_ticks=[(strip.at(1), "+1"), (strip.at(0), "0"), (strip.at(-1), "−1")],
        band=_band(points, across, up),
        reference=_line([(p.x, p.reference) for p in points], across, up),
        inside=_dots([(p.x, p.measured) for p in drawn if not p.outside], across, up),
        outside=_dots([(p.x, p.measured) for p in drawn if p.outside], across, up),
        strip_inside=_dots([(p.x, p.widths) for p in points if not p.outside], across, strip),
        strip_outside=_dots(
            [(p.x, max(-FURTHEST, min(FURTHEST, p.widths))) for p in bad], across, strip
        ),
        points=points,
        rows=rows[: 4 * _MOST_ROWS],
        hidden=len(points) - len(drawn),
        bad=len(bad),
    )


def _point(x: float, measured: float, reference: float, low: float, high: float) -> Point:
    # What is NaN lies in no band, and nothing lies in a band that is NaN, unless both are.
    outside = not (low <= measured <= high) and not (math.isnan(measured) and math.isnan(low))
    middle, half = low / 2 + high / 2, high / 2 - low / 2
    if half > 0 and math.isfinite(half):
        widths = (measured - middle) / half
    else:
        widths = 0.0 if measured == middle else math.nan
        if outside and not math.isnan(measured):
            widths = math.copysign(math.inf, measured - middle)
    return Point(x, measured, reference, low, high, widths, outside)


def _places(
    point: Point, across: Axis, up: Axis, strip: Axis
) -> tuple[float, float | None, float | None] | None:
    if not across.holds(point.x):
        return None
    width = max(-FURTHEST, min(FURTHEST, point.widths))
    return (
        across.at(point.x),
        up.at(point.measured) if up.holds(point.measured) else None,
        strip.at(width) if strip.holds(width) else None,
    )


def _heights(points: list[Point]) -> list[float]:
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


def _line(pairs: list[tuple[float, float]], across: Axis | None, up: Axis | None) -> str:
    """An SVG path through the pairs, broken where one can't be drawn."""
    if across is None or up is None:
        return ""
    parts: list[str] = []
    pen_up = True
    for x, y in pairs:
        if across.holds(x) and up.holds(y):
            parts.append(f"{'M' if pen_up else 'L'}{across.at(x):g} {up.at(y):g}")
            pen_up = False
        else:
            pen_up = True
    return "".join(parts)


def _dots(pairs: list[tuple[float, float]], across: Axis | None, up: Axis | None) -> str:
    """An SVG path of strokes without length: with round caps each is a dot."""
    if across is None or up is None:
        return ""
    return "".join(
        f"M{across.at(x):g} {up.at(y):g}h0" for x, y in pairs if across.holds(x) and up.holds(y)
    )


def _band(points: list[Point], across: Axis | None, up: Axis | None) -> str:
    """A closed SVG path around the band; parts without a finite band are left out."""
    if across is None or up is None:
        return ""
    runs: list[list[Point]] = [[]]
    for point in points:
        if across.holds(point.x) and math.isfinite(point.low) and math.isfinite(point.high):
            runs[-1].append(point)
        elif runs[-1]:
            runs.append([])
    paths = []
    for run in runs:
        if len(run) < 2:
            continue
        # Cut at the frame, or one wide band would leave the paper.
        edge = [(p.x, min(p.high, up.high)) for p in run]
        edge += [(p.x, max(p.low, up.low)) for p in reversed(run)]
        corners = [f"{across.at(x):g} {up.at(min(max(y, up.low), up.high)):g}" for x, y in edge]
        paths.append("M" + "L".join(corners) + "Z")
    return "".join(paths)
