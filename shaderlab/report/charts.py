"""Drawings of numbers: axes with round ticks, curves with their bands, plots of figures, and the
value that is furthest from its band."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter

from shaderlab.model.records import Curve, Plot, PlotPoint, Worst
from shaderlab.report.text import figure

_SMALLEST, _LARGEST = 1e-307, 1e308


@dataclass(frozen=True)
class Axis:
    """Maps values `low`…`high` to positions `start`…`stop` on the paper."""

    low: float
    high: float
    start: float
    stop: float
    log: bool = False

    def at(self, value: float) -> float:
        """The position of a value, to a hundredth."""
        low, high = self._scale(self.low), self._scale(self.high)
        # Divided before subtracting: the difference of the largest floats overflows.
        size = max(abs(low), abs(high)) or 1.0
        part = (self._scale(value) / size - low / size) / (high / size - low / size)
        return round(self.start + part * (self.stop - self.start), 2)

    def holds(self, value: float) -> bool:
        return math.isfinite(value) and self.low <= value <= self.high

    def ticks(self, about: int = 6) -> list[tuple[float, str]]:
        """Positions and labels of some round values."""
        values = _log_ticks(self.low, self.high, about) if self.log else []
        if len(values) < 2:
            values = _linear_ticks(self.low, self.high, about)
        return [(self.at(value), _label(value)) for value in values]

    def _scale(self, value: float) -> float:
        return math.log10(value) if self.log else value


@dataclass(frozen=True)
class Plane:
    """Two axes, and SVG paths in their coordinates."""

    across: Axis
    up: Axis

    def at(self, x: float, y: float) -> tuple[float, float] | None:
        """The position of a point, or None if an axis does not hold it."""
        if not (self.across.holds(x) and self.up.holds(y)):
            return None
        return self.across.at(x), self.up.at(y)

    def dots(self, points: Iterable[tuple[float, float]]) -> str:
        """Strokes without length: with round caps each is a dot."""
        positions = (self.at(x, y) for x, y in points)
        return "".join(f"M{at[0]:g} {at[1]:g}h0" for at in positions if at)

    def line(self, points: Iterable[tuple[float, float]]) -> str:
        """A line through the points, broken where one can't be drawn."""
        path, pen = "", "M"
        for x, y in points:
            at = self.at(x, y)
            if at:
                path += f"{pen}{at[0]:g} {at[1]:g}"
            pen = "L" if at else "M"
        return path


def fit_axis(
    values: list[float], start: float, stop: float, *, log: bool, margin: float
) -> Axis | None:
    """Return an axis that holds all `values` with a margin, a share of the range; None of none.

    On a logarithmic axis only positive values count.
    """
    shown = [v for v in values if math.isfinite(v) and (v > 0 or not log)]
    if not shown:
        return None
    low, high = min(shown), max(shown)
    if log:
        decades = (math.log10(high) - math.log10(low)) * margin if high > low else 0.3
        return Axis(
            max(low * 10**-decades, _SMALLEST), min(high * 10**decades, _LARGEST), start, stop, True
        )
    pad = (high / 2 - low / 2) * 2 * margin if high > low else abs(high) * 0.1 or 1.0
    return Axis(max(low - pad, -_LARGEST), min(high + pad, _LARGEST), start, stop)


def _linear_ticks(low: float, high: float, about: int) -> list[float]:
    raw = high / about - low / about
    if not math.isfinite(raw) or raw <= 0:
        return []
    power = 10.0 ** math.floor(math.log10(raw))
    step = next((m * power for m in (1, 2, 2.5, 5, 10) if m * power >= raw), raw)
    if step <= 0 or not math.isfinite(low / step) or abs(low / step) > 1e12:
        return [low, high]
    first = math.ceil(low / step - 1e-9)
    # Rounded to the step's own digits, or 0.1 + 0.2 would be seen.
    ticks = [float(f"{n * step:.12g}") for n in range(first, first + 2 * about + 2)]
    return [tick for tick in ticks if tick <= high + step * 1e-9]


def _log_ticks(low: float, high: float, about: int) -> list[float]:
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    decades = last - first
    apart = -(-decades // about) if decades > 2 * about else 1
    steps = (1, 2, 5) if decades <= 3 and apart == 1 else (1,)
    values = [m * float(f"1e{e}") for e in range(first, last + 1, apart) for m in steps]
    return [value for value in values if low <= value <= high]


def _label(value: float) -> str:
    if value == 0:
        return "0"
    if 1e-4 <= abs(value) < 1e6:
        return f"{value:.6g}".replace("-", "−")
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}".replace("-", "−")


# Positions on a number line of 100 units: the band lies between these.
_BAND_FROM, _BAND_TO = 30.0, 70.0
_MIDDLE = (_BAND_FROM + _BAND_TO) / 2
_HALF = (_BAND_TO - _BAND_FROM) / 2


@dataclass(frozen=True)
class Component:
    index: int
    measured: float
    reference: float
    low: float
    high: float
    worst: bool

    @property
    def outside(self) -> bool:
        return outside(self.measured, self.low, self.high)


@dataclass(frozen=True)
class WorstPanel:
    """`measured_at` and `reference_at` are positions in 0…100 on the number line, or None
    where there is no such place (NaN, an infinite band)."""

    worst: Worst
    components: tuple[Component, ...]
    measured_at: float | None
    reference_at: float | None

    @property
    def outside(self) -> bool:
        return any(c.outside for c in self.components if c.worst)


def lay_out_worst(worst: Worst) -> WorstPanel:
    """Lay out a worst value; vectors of unequal length show as far as all of them reach."""
    components = tuple(
        Component(index, *values, worst=index == worst.component)
        for index, values in enumerate(
            zip(worst.measured, worst.reference, worst.low, worst.high, strict=False)
        )
    )
    meant = next((c for c in components if c.worst), None)
    if meant is None:
        return WorstPanel(worst, components, None, None)
    return WorstPanel(
        worst, components, _place(meant.measured, meant), _place(meant.reference, meant)
    )


def _place(value: float, band: Component) -> float | None:
    widths = half_widths(value, band.low, band.high)
    if math.isnan(widths) or not math.isfinite(band.high / 2 - band.low / 2):
        return None
    return _MIDDLE + max(-2.4, min(2.4, widths)) * _HALF


def outside(value: float, low: float, high: float) -> bool:
    """Whether a value lies outside its band: NaN lies in no band but one that is NaN itself."""
    return not low <= value <= high and not (math.isnan(value) and math.isnan(low))


def half_widths(value: float, low: float, high: float) -> float:
    """The distance from a band's middle in half band widths; NaN where there is no such number."""
    middle, half = low / 2 + high / 2, high / 2 - low / 2
    if half > 0 and math.isfinite(half):
        return (value - middle) / half
    if value == middle:
        return 0.0
    beyond = outside(value, low, high) and not math.isnan(value)
    return math.copysign(math.inf, value - middle) if beyond else math.nan


WIDTH = 460.0
LEFT, RIGHT = 62.0, 448.0
TOP, BOTTOM = 14.0, 214.0
STRIP_TOP, STRIP_BOTTOM = 246.0, 306.0
HEIGHT = 352.0
# Distances beyond this are drawn at the strip's edge.
_FURTHEST = 1.6
_MOST_ROWS = 120
_STRIP = Axis(-_FURTHEST, _FURTHEST, STRIP_BOTTOM, STRIP_TOP)
_BAND_HEIGHT = (STRIP_BOTTOM - STRIP_TOP) / _FURTHEST


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


def lay_out_curve(curve: Curve) -> Chart:
    """Lay a curve out as two charts: points on their reference, and where in the band each is.

    A derived band is mostly thinner than a line, so the second chart stretches it: −1 and 1 are its
    edges at every x. What can't be drawn (NaN, an infinity, x ≤ 0 on a logarithm) is counted.
    """
    rows = zip(curve.x, curve.measured, curve.reference, curve.low, curve.high, strict=False)
    points = [
        Point(x, y, reference, low, high, half_widths(y, low, high), outside(y, low, high))
        for x, y, reference, low, high in rows
    ]
    bad = [p for p in points if p.outside]
    across = fit_axis([p.x for p in points], LEFT, RIGHT, log=curve.log_x, margin=0.02)
    up = fit_axis(_heights(points), BOTTOM, TOP, log=False, margin=0.06)
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
        band=_band_path(points, plane),
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
    return max(-_FURTHEST, min(_FURTHEST, widths))


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


def _band_path(points: Sequence[Point], plane: Plane) -> str:
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


_PLOT_HEIGHT = 262.0
# How many series are distinguishable: the style sheet has a colour for each.
_COLOURS = 6
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

    width, height, left, right, top, bottom = WIDTH, _PLOT_HEIGHT, LEFT, RIGHT, TOP, BOTTOM
    strip_top, foot = None, BOTTOM

    @property
    def several(self) -> bool:
        return len(self.series) > 1

    @property
    def bad(self) -> int:
        return sum(not row.point.ok for row in self.rows)

    @property
    def hidden(self) -> int:
        return sum(row.at is None for row in self.rows)


def lay_out_plot(plot: Plot) -> PlotView:
    """Lay a plot out: a line with dots for each series, and bounds.

    Every series has its own colour and dash, so that colour alone need not distinguish them.
    A bound is a short bar above or below its point, with a stem towards what it allows.
    """
    points = plot.points
    across = fit_axis([p.x for p in points], LEFT, RIGHT, log=plot.log_x, margin=0.04)
    up = fit_axis(_plot_heights(plot), BOTTOM, TOP, log=plot.log_y, margin=0.08)
    if across is None or up is None:
        return PlotView(plot, [PlotRow(p, _expected(p), None) for p in points])
    plane = Plane(across, up)
    series = []
    for n, name in enumerate(dict.fromkeys(p.series for p in points)):
        own = [(p.x, p.y) for p in points if p.series == name]
        line = plane.line(sorted(own, key=itemgetter(0)))
        series.append(SeriesView(name, n % _COLOURS, line, plane.dots(own)))
    return PlotView(
        plot=plot,
        rows=[PlotRow(p, _expected(p), plane.at(p.x, p.y)) for p in points],
        x_ticks=across.ticks(6),
        y_ticks=up.ticks(5),
        series=series,
        bounds="".join(_draw_bounds(p, plane) for p in points),
        outside=plane.dots((p.x, p.y) for p in points if not p.ok),
    )


def _plot_heights(plot: Plot) -> list[float]:
    """What the upright axis must show: the figures, and the bounds that are near them."""
    figures = [p.y for p in plot.points if math.isfinite(p.y)]
    bounds = [b for p in plot.points for b in (p.low, p.high)]
    if plot.log_y or not figures:
        return figures + bounds
    low, high = min(figures), max(figures)
    margin = 2.0 * (high - low) or abs(high) or 1.0
    return figures + [b for b in bounds if low - margin <= b <= high + margin]


def _draw_bounds(point: PlotPoint, plane: Plane) -> str:
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
