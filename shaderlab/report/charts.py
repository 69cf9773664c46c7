"""Drawings of numbers: curves with their bands, and plots of figures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import itemgetter

from shaderlab.model.records import Curve, Plot, PlotPoint
from shaderlab.report.text import figure

# Larger values are not drawn: no difference of two smaller ones overflows.
_LARGEST = 1e300
_WIDTH = 460.0
_LEFT, _RIGHT = 62.0, 448.0
_TOP, _BOTTOM = 14.0, 214.0
_STRIP_TOP, _STRIP_BOTTOM = 246.0, 306.0
# Distances beyond this are drawn at the strip's edge.
_FURTHEST = 1.6
_MOST_ROWS = 120
# How many series are distinguishable: the style sheet has a colour for each.
_COLOURS = 6
# A map's colours, which the style sheet has.
_SHADES = 8
# A height outside of the drawing, where there is nothing to mark.
_NOWHERE = -99.0


@dataclass(frozen=True)
class Axis:
    """Maps values `low`…`high` to positions `start`…`stop` in a drawing."""

    low: float
    high: float
    start: float
    stop: float
    log: bool = False

    def at(self, value: float) -> float:
        """Return the position of a value, to a hundredth."""
        low, high = self._scale(self.low), self._scale(self.high)
        part = (self._scale(value) - low) / (high - low)
        return round(self.start + part * (self.stop - self.start), 2)

    def holds(self, value: float) -> bool:
        return self.low <= value <= self.high

    def ticks(self, about: int) -> list[tuple[float, str]]:
        """Return positions and labels of some round values."""
        values = _log_ticks(self.low, self.high, about) if self.log else []
        if len(values) < 2:
            values = _linear_ticks(self.low, self.high, about)
        return [(self.at(value), _format_tick(value)) for value in values]

    def _scale(self, value: float) -> float:
        return math.log10(value) if self.log else value


_STRIP = Axis(-_FURTHEST, _FURTHEST, _STRIP_BOTTOM, _STRIP_TOP)


@dataclass(frozen=True)
class Plane:
    """Two axes, and SVG paths in their coordinates."""

    across: Axis
    up: Axis

    def at(self, x: float, y: float) -> tuple[float, float] | None:
        """Return the position of a point, or None if an axis does not hold it."""
        if not (self.across.holds(x) and self.up.holds(y)):
            return None
        return self.across.at(x), self.up.at(y)

    def dots(self, points: Iterable[tuple[float, float]]) -> str:
        """Return strokes without length: with round caps each is a dot."""
        positions = (self.at(x, y) for x, y in points)
        return "".join(f"M{at[0]:g} {at[1]:g}h0" for at in positions if at)

    def line(self, points: Iterable[tuple[float, float]]) -> str:
        """Return a line through the points, broken where one can't be drawn."""
        path, pen = "", "M"
        for x, y in points:
            at = self.at(x, y)
            if at:
                path += f"{pen}{at[0]:g} {at[1]:g}"
            pen = "L" if at else "M"
        return path

    def height(self, y: float) -> float:
        return self.up.at(y) if self.up.holds(y) else _NOWHERE


def fit_axis(
    values: Iterable[float], start: float, stop: float, *, log: bool, margin: float
) -> Axis | None:
    """Return an axis that holds all `values` with a margin, a share of the range; None of none.

    On a logarithmic axis only positive values count.
    """
    shown = [v for v in values if abs(v) <= _LARGEST and (v > 1 / _LARGEST or not log)]
    if not shown:
        return None
    low, high = min(shown), max(shown)
    if log:
        decades = (math.log10(high) - math.log10(low)) * margin if high > low else 0.3
        factor = 10**decades
        return Axis(low / factor, high * factor, start, stop, log)
    pad = (high - low) * margin if high > low else abs(high) * 0.1 or 1.0
    return Axis(low - pad, high + pad, start, stop)


def _linear_ticks(low: float, high: float, about: int) -> list[float]:
    raw = (high - low) / about
    if raw < 1 / _LARGEST:
        return []
    power = 10.0 ** math.floor(math.log10(raw))
    step = next((m * power for m in (1, 2, 2.5, 5, 10) if m * power >= raw), raw)
    if abs(low / step) > 1e12:
        return [low, high]
    first = math.ceil(low / step - 1e-9)
    # Rounded to the step's own digits, or 0.1 + 0.2 would be seen.
    ticks = [float(f"{n * step:.12g}") for n in range(first, first + 2 * about + 2)]
    return [tick for tick in ticks if tick <= high + step * 1e-9]


def _log_ticks(low: float, high: float, about: int) -> list[float]:
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    apart = max(1, (last - first) // about)
    steps = (1, 2, 5) if last - first <= 3 else (1,)
    values = [m * float(f"1e{e}") for e in range(first, last + 1, apart) for m in steps]
    return [value for value in values if low <= value <= high]


def _format_tick(value: float) -> str:
    if value == 0:
        return "0"
    if 1e-4 <= abs(value) < 1e6:
        return f"{value:.6g}".replace("-", "−")
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}".replace("-", "−")


@dataclass(frozen=True)
class ChartRow:
    """One row of a chart's table; `at` is where its point is drawn: x and heights; else ""."""

    cells: tuple[str, ...]
    bad: bool
    at: str = ""


Marks = list[tuple[str, str]]
Labels = list[tuple[float, float, str, str]]


@dataclass(frozen=True)
class Chart:
    """Everything the template draws, in the coordinates of a drawing of WIDTH × `height`.

    Attributes:
        drawn: what has its title and the names of its axes.
        marks: (CSS class, SVG path), the lowest first; none where nothing can be drawn.
        labels: texts as (x, y, CSS class, text).
        key: (CSS class, words) of each kind of mark.
        hidden: how many points are not in the drawing.
        foot: the lowest part's edge.
    """

    drawn: Curve | Plot
    marks: Marks
    labels: Labels
    key: Marks
    hidden: int
    heads: tuple[str, ...]
    points: Sequence[ChartRow]
    foot: float = _BOTTOM
    width, middle, top = _WIDTH, (_LEFT + _RIGHT) / 2, _TOP

    @property
    def height(self) -> float:
        return self.foot + 46

    @property
    def bad(self) -> int:
        """How many points are outside."""
        return sum(row.bad for row in self.points)

    @property
    def rows(self) -> Sequence[ChartRow]:
        """Of many points some, evenly chosen, and those outside."""
        step = max(1, math.ceil(len(self.points) / _MOST_ROWS))
        some = [row for index, row in enumerate(self.points) if index % step == 0 or row.bad]
        return some[: 4 * _MOST_ROWS]


def draw_curve(curve: Curve) -> Chart:
    """Draw a curve as two charts: points on their reference, and where in the band each is.

    A derived band is mostly thinner than a line, so the second chart stretches it to −1…1. What
    can't be drawn (NaN, an infinity, x ≤ 0 on a logarithm) is counted. Over two inputs it is a map.
    """
    if curve.y:
        return _draw_map(curve)
    points = list(
        zip(curve.x, curve.measured, curve.reference, curve.low, curve.high, strict=False)
    )
    bad = [is_outside(y, low, high) for _, y, _, low, high in points]
    strip = [_find_strip_place(y, low, high) for _, y, _, low, high in points]
    across = fit_axis(curve.x, _LEFT, _RIGHT, log=curve.log_x, margin=0.02)
    up = fit_axis(_curve_heights(curve), _BOTTOM, _TOP, log=False, margin=0.06)
    plane = Plane(across, up) if across and up else None
    marks, labels = _draw_axes(plane, _STRIP_BOTTOM)
    if plane:
        marks += _draw_curve_marks(curve, plane, bad, strip)
        for edge, label in ((1, "+1"), (0, "0"), (-1, "−1")):
            labels.append((_LEFT - 8, _STRIP.at(edge) + 4, "end", label))
        words = "position in the band (−1 and +1 are its edges)"
        labels.append((_LEFT, _STRIP_TOP - 6, "label", words))
    rows = []
    for point, is_bad, widths in zip(points, bad, strip, strict=True):
        at = ""
        if plane and plane.across.holds(point[0]):
            heights = plane.height(point[1]), Plane(plane.across, _STRIP).height(widths)
            at = f"{plane.across.at(point[0]):g} {heights[0]:g} {heights[1]:g}"
        first = figure(point[0]) + " outside" * is_bad
        rows.append(ChartRow((first, *map(figure, point[1:])), is_bad, at))
    key = [(name, name) for name in ("measured", "reference", "band")]
    heads = (curve.x_label, "measured", "reference", "band from", "to")
    hidden = sum(plane is None or plane.at(x, y) is None for x, y, *_ in points)
    return Chart(curve, marks, labels, key, hidden, heads, rows, _STRIP_BOTTOM)


def _draw_map(curve: Curve) -> Chart:
    """Draw measured values over two inputs as squares in shades, and a dot where one is outside."""
    points = list(
        zip(curve.x, curve.y, curve.measured, curve.reference, curve.low, curve.high, strict=True)
    )
    across = fit_axis(curve.x, _LEFT, _RIGHT, log=False, margin=0.02)
    up = fit_axis(curve.y, _BOTTOM, _TOP, log=False, margin=0.04)
    shades = fit_axis(curve.measured, 0, _SHADES - 1, log=False, margin=0.0)
    plane = Plane(across, up) if across and up and shades else None
    marks, labels = _draw_axes(plane, _BOTTOM)
    key: Marks = []
    rows = []
    by_shade: list[list[tuple[float, float]]] = [[] for _ in range(_SHADES)]
    for x, y, value, *rest in points:
        at = plane and plane.at(x, y)
        outside = is_outside(value, *rest[1:])
        cells = figure(x) + " outside" * outside, *map(figure, (y, value, *rest))
        rows.append(ChartRow(cells, outside, f"{at[0]:g} {at[1]:g}" if at else ""))
        if shades and shades.holds(value):
            by_shade[round(shades.at(value))].append((x, y))
    if plane and shades:
        marks += [(f"dots shade-{n}", plane.dots(some)) for n, some in enumerate(by_shade)]
        bad = [point[:2] for point, row in zip(points, rows, strict=True) if row.bad]
        marks.append(("dots is-outside", plane.dots(bad)))
        ends = {0: f"measured {_format_tick(shades.low)} to {_format_tick(shades.high)}"}
        key = [(f"series shade-{n}", ends.get(_SHADES - 1 - n, "")) for n in range(_SHADES)]
    heads = (curve.x_label, curve.y_label, "measured", "reference", "band from", "to")
    hidden = len(points) - sum(map(len, by_shade))
    return Chart(curve, marks, labels, key, hidden, heads, rows)


def _draw_curve_marks(
    curve: Curve, plane: Plane, bad: Sequence[bool], strip: Sequence[float]
) -> Marks:
    lower = Plane(plane.across, _STRIP)
    marks = [
        ("band", _band_path(curve, plane)),
        ("reference", plane.line(zip(curve.x, curve.reference, strict=False))),
        ("band", f"M{_LEFT} {_STRIP.at(1)}H{_RIGHT}V{_STRIP.at(-1)}H{_LEFT}Z"),
        ("middle", f"M{_LEFT} {_STRIP.at(0)}H{_RIGHT}"),
    ]
    for name, outside in (("dots", False), ("dots is-outside", True)):
        for part, heights in ((plane, curve.measured), (lower, strip)):
            some = zip(curve.x, heights, bad, strict=False)
            marks.append((name, part.dots((x, y) for x, y, is_bad in some if is_bad is outside)))
    return marks


def _find_strip_place(value: float, low: float, high: float) -> float:
    """A value's place in its band, at the strip's edge where it is further away; NaN where it is
    inside a band without a middle."""
    widths = half_widths(value, low, high)
    if math.isnan(widths):
        return _FURTHEST if is_outside(value, low, high) else widths
    return max(-_FURTHEST, min(_FURTHEST, widths))


def _draw_axes(plane: Plane | None, foot: float) -> tuple[Marks, Labels]:
    """The grid of a drawing, and the labels of its ticks; `foot` is the lowest part's edge."""
    if plane is None:
        return [], []
    columns, lines = plane.across.ticks(6), plane.up.ticks(5)
    strip = f"M{{x}} {_STRIP_TOP}V{foot}" if foot > _BOTTOM else ""
    grid = "".join(f"M{_LEFT} {y}H{_RIGHT}" for y, _ in lines)
    grid += "".join(f"M{x} {_TOP}V{_BOTTOM}{strip.format(x=x)}" for x, _ in columns)
    labels: Labels = [(_LEFT - 8, y + 4, "end", label) for y, label in lines]
    labels += [(x, foot + 18, "centred", label) for x, label in columns]
    return [("grid", grid)], labels


def _curve_heights(curve: Curve) -> list[float]:
    """What the upright axis must show: the reference, and measured values not far from it.

    One wild value would press everything else into a line; it is left to the lower chart.
    """
    reference = [y for y in curve.reference if abs(y) <= _LARGEST]
    if not reference:
        return list(curve.measured)
    low, high = min(reference), max(reference)
    span = high - low or abs(high) or 1.0
    return reference + [y for y in curve.measured if -2 <= (y - low) / span <= 4]


def _band_path(curve: Curve, plane: Plane) -> str:
    """A closed SVG path around the band; parts without a finite band are left out."""
    runs: list[list[tuple[float, float, float]]] = [[]]
    for x, low, high in zip(curve.x, curve.low, curve.high, strict=False):
        if plane.across.holds(x) and math.isfinite(low) and math.isfinite(high):
            runs[-1].append((x, low, high))
        elif runs[-1]:
            runs.append([])
    # Cut at the frame, or one wide band would leave the paper.
    least, most = plane.up.low, plane.up.high
    path = ""
    for run in runs:
        if len(run) > 1:
            edge = [(x, high) for x, _, high in run] + [(x, low) for x, low, _ in reversed(run)]
            path += plane.line((x, min(max(y, least), most)) for x, y in edge) + "Z"
    return path


def draw_plot(plot: Plot) -> Chart:
    """Draw a plot: a line with dots for each series, and bounds.

    Every series has its own colour and dash, so that colour alone need not distinguish them.
    A bound is a short bar above or below its point, with a stem towards what it allows.
    """
    points = plot.points
    names = list(dict.fromkeys(p.series for p in points))
    across = fit_axis((p.x for p in points), _LEFT, _RIGHT, log=plot.log_x, margin=0.04)
    up = fit_axis(_plot_heights(plot), _BOTTOM, _TOP, log=plot.log_y, margin=0.08)
    plane = Plane(across, up) if across and up else None
    places = [plane.at(p.x, p.y) if plane else None for p in points]
    marks, labels = _draw_axes(plane, _BOTTOM)
    key = [(f"series series-{n % _COLOURS}", name or "measured") for n, name in enumerate(names)]
    if plane:
        bounds = "".join(_draw_bounds(p, plane) for p in points)
        marks.append(("bounds", bounds))
        for n, name in enumerate(names):
            own = [(p.x, p.y) for p in points if p.series == name]
            series = f"series-{n % _COLOURS}"
            marks.append((f"line {series}", plane.line(sorted(own, key=itemgetter(0)))))
            marks.append((f"dots {series}", plane.dots(own)))
        marks.append(("dots is-outside", plane.dots((p.x, p.y) for p in points if not p.ok)))
        key += [("bound", "bound")] if bounds else []
    several = len(names) > 1
    rows = [
        ChartRow(
            (figure(p.x) + " outside" * (not p.ok), figure(p.y), _format_bounds(p))
            + ((p.series,) if several else ()),
            not p.ok,
            f"{at[0]:g} {at[1]:g}" if at else "",
        )
        for p, at in zip(points, places, strict=True)
    ]
    heads = (plot.x_label, "measured", "expected") + (("series",) if several else ())
    return Chart(plot, marks, labels, key, places.count(None), heads, rows)


def _plot_heights(plot: Plot) -> list[float]:
    """What the upright axis must show: the figures, and the bounds that are near them."""
    figures = [p.y for p in plot.points if abs(p.y) <= _LARGEST]
    bounds = [b for p in plot.points for b in (p.low, p.high)]
    if plot.log_y or not figures:
        return figures + bounds
    low, high = min(figures), max(figures)
    margin = 2.0 * (high - low) or abs(high) or 1.0
    return figures + [b for b in bounds if low - margin <= b <= high + margin]


def _draw_bounds(point: PlotPoint, plane: Plane) -> str:
    at = plane.at(point.x, point.y)
    path = ""
    # Upwards on the page is towards smaller y.
    for bound, stem in ((point.low, -9), (point.high, 9)):
        if at and plane.up.holds(bound):
            y = plane.up.at(bound)
            path += f"M{at[0] - 6:g} {y:g}h12M{at[0]:g} {y:g}v{stem}"
    return path


def _format_bounds(point: PlotPoint) -> str:
    low, high = figure(point.low), figure(point.high)
    if point.low == -math.inf:
        return "–" if point.high == math.inf else f"≤ {high}"
    return f"≥ {low}" if point.high == math.inf else f"{low} … {high}"


def is_outside(value: float, low: float, high: float) -> bool:
    """Whether a value lies outside its band: NaN lies in no band but one that is NaN itself."""
    return not low <= value <= high and not (math.isnan(value) and math.isnan(low))


def half_widths(value: float, low: float, high: float) -> float:
    """Return the distance from a band's middle in half band widths; NaN where there is none."""
    middle, half = low / 2 + high / 2, high / 2 - low / 2
    if half > 0 and math.isfinite(half):
        return (value - middle) / half
    if value == middle:
        return 0.0
    beyond = is_outside(value, low, high) and not math.isnan(value)
    return math.copysign(math.inf, value - middle) if beyond else math.nan
