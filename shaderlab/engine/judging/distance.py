"""How far judged values lie from the middle of their bands.

A record shows only the largest distance, a picture the largest of each pixel, so distances are
computed block by block, in memory that stays in the processor's cache, and none is stored.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands.allowed import widths
from shaderlab.model.frame import Array
from shaderlab.model.records import Row, significant

Floats = npt.NDArray[np.float64]
Distances = npt.NDArray[np.floating[Any]]
# So many rows of four components, in float64, twice: a quarter of a megabyte.
BLOCK = 4096


@dataclass(frozen=True, kw_only=True)
class Placed:
    """Measured values with their bands, all arrays (count, components).

    `inside` says which are in their band; `unit` is the size of one code for fixed-point formats,
    None for floats.
    """

    measured: Array
    low: Array
    high: Array
    inside: npt.NDArray[np.bool_]
    unit: float | None = None

    def furthest(self) -> tuple[int, int]:
        """Row and component of the value furthest from its band's middle, the first of equals.

        A value outside outranks all inside, whatever their distances.
        """
        found = furthest(self.low, self.high, self.measured, self.inside, self.unit)
        row, component = divmod(found, self.measured.shape[1])
        return row, component

    def widths_at(self, row: int, component: int) -> float:
        """One value's distance in half widths, as `Band.widths` has it."""
        at = row, slice(component, component + 1)
        low, high = (bound[at].astype(np.float64) for bound in (self.low, self.high))
        return float(widths(low, high, self.inside[at], self.measured[at], self.unit or 0.0)[0])

    def signed(self) -> Floats:
        """Of each row's components the largest distance, as (count,): negative below the middle,
        at most 1 in size inside, infinite outside."""
        signed = np.empty(len(self.measured))
        for start, distance in self.blocks():
            rows = slice(start, start + len(distance))
            distance[~self.inside[rows]] = np.inf
            at = distance.argmax(axis=1) + np.arange(0, distance.size, distance.shape[1])
            arrays = (self.low[rows], self.high[rows], self.measured[rows], distance)
            low, high, value, size = (array.reshape(-1).take(at) for array in arrays)
            with np.errstate(invalid="ignore"):
                below = value < 0.5 * np.add(low, high, dtype=np.float64)
            signed[rows] = np.where(below, -size, size)
        return signed

    def blocks(self) -> Iterator[tuple[int, Distances]]:
        """The first row and the distances of each block: at most 1 inside, at least 1 outside.
        The next block may overwrite the array."""
        alike = self.measured.dtype == self.low.dtype == self.high.dtype == np.float32
        count, components = self.measured.shape
        scratch = np.empty((3, min(BLOCK, count) if alike else 0, components), np.float32)
        for start in range(0, count, BLOCK):
            rows = slice(start, start + BLOCK)
            block = self.low[rows], self.high[rows], self.measured[rows], self.inside[rows]
            distance: Distances | None = _narrow(*block[:3], scratch) if alike else None
            if distance is None:
                distance = self._widths(*block)
            elif not block[3].all():
                beyond = ~block[3]
                distance = distance.astype(np.float64)
                distance[beyond] = self._widths(*(array[beyond] for array in block))
            yield start, distance

    def _widths(
        self, low: Array, high: Array, value: Array, inside: npt.NDArray[np.bool_]
    ) -> Floats:
        # NaN is inside only where it is legal.
        bounds = low.astype(np.float64), high.astype(np.float64)
        distance = widths(*bounds, inside, value, self.unit or 0.0)
        return np.where(inside, np.minimum(distance, 1.0), np.maximum(distance, 1.0))


def furthest(
    low: Array, high: Array, measured: Array, inside: npt.NDArray[np.bool_], unit: float | None
) -> int:
    """The number of what `Placed.furthest` finds."""
    placed = Placed(measured=measured, low=low, high=high, inside=inside, unit=unit)
    found, largest = 0, -1.0
    for start, distance in placed.blocks():
        index = int(distance.argmax())
        here = float(distance.flat[index])
        if here > largest:
            found, largest = start * distance.shape[1] + index, here
    return found


@np.errstate(all="ignore")
def _narrow(low: Array, high: Array, value: Array, scratch: Array) -> Distances | None:
    """Distances of float32 values inside float32 bounds, to a few units of the last place of 1;
    None where a band is wider than float32 can hold."""
    distance: Distances
    whole, distance, below = scratch[:, : len(value)]
    np.subtract(high, low, out=whole)
    if not whole.max() < np.inf:  # NaN too
        return None
    # How far from either bound: exact where bounds are close to each other, and the same in size
    # for a value and a band mirrored at zero.
    np.subtract(value, low, out=distance)
    np.subtract(high, value, out=below)
    distance -= below
    np.abs(distance, out=distance)
    distance /= whole
    # A band without width, or without an end, has no distance inside but 0.
    np.fmax(distance, 0.0, out=distance)
    np.minimum(distance, 1.0, out=distance)
    return distance


def figure_row(
    label: str, equals: Any, digits: int, computed: Any, measured: Any, ok: bool, note: str
) -> Row:
    """One line of a table of figures: as printed, and as measured with a few digits more, or none
    of integers."""
    found = computed if measured is None else measured
    whole = isinstance(found, np.ndarray) and found.dtype.kind in "iu"
    text = shown(found, 0 if whole else min(digits + 3, 9))
    digits = 0 if whole else digits
    return Row(label=label, expected=shown(equals, digits), measured=text, ok=ok, note=note)


def rounds_to(computed: Any, equals: Any, digits: int) -> bool:
    """Whether every component, rounded to `digits` decimals, is the printed figure.

    A tie may be printed rounded either way.
    """
    difference = np.abs(np.asarray(computed, np.float64) - np.asarray(equals, np.float64))
    return bool(np.all(difference <= 0.5 * 10.0**-digits * (1.0 + 1e-6)))


def ulp_distance(measured: float, reference: float, unit: float | None = None) -> float:
    """How many float32 units in the last place of `reference` (or `unit`s) lie between the two.

    >>> ulp_distance(1.0 + 2.0**-23, 1.0)
    1.0
    """
    unit = unit or float(np.spacing(np.float32(abs(reference))))
    return abs(float(measured) - float(reference)) / unit if np.isfinite(reference) else np.nan


def plain(values: Array) -> tuple[float, ...]:
    """A vector as a tuple of Python numbers."""
    return tuple(float(v) for v in np.ravel(values))


def shown(values: object, digits: int | None = None) -> str:
    """A number or vector for people: `digits` decimals, or nine significant digits.

    >>> shown((0.5, 1.0)), shown(0.25, 4)
    ('(0.5, 1)', '0.2500')
    """
    numbers = [float(v) for v in np.ravel(np.asarray(values, np.float64))]
    texts = [f"{n:.{digits}f}" if digits is not None else significant(n) for n in numbers]
    return texts[0] if len(texts) == 1 else f"({', '.join(texts)})"
