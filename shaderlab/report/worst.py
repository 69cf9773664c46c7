"""The value furthest from its band, laid out for reading: components, and a number line."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shaderlab.model.records import Worst

# Positions on a number line of 100 units: the band lies between these.
BAND_FROM, BAND_TO = 30.0, 70.0
_MIDDLE = (BAND_FROM + BAND_TO) / 2
_HALF = (BAND_TO - BAND_FROM) / 2


@dataclass(frozen=True)
class Component:
    """One component of a vector; `worst` marks the one that is meant."""

    index: int
    measured: float
    reference: float
    low: float
    high: float
    worst: bool

    @property
    def outside(self) -> bool:
        """Whether it lies outside its band."""
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
        """Whether the value meant lies outside."""
        return any(c.outside for c in self.components if c.worst)


def worst_panel(worst: Worst) -> WorstPanel:
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
