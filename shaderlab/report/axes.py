"""Axes of a chart: round tick marks on linear and logarithmic scales, and paths between them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

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
        """Whether the value can be shown on this axis."""
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


def axis(
    values: list[float], start: float, stop: float, *, log: bool, margin: float
) -> Axis | None:
    """An axis that holds all `values` with a margin (a share of the range); None without any.

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
