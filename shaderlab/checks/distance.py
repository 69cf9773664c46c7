"""How far judged values lie from the middle of their bands.

Of all values only one is shown with its distance, and a picture needs the largest of each pixel.
So distances are made block by block, in memory that stays in the processor's cache, and none of
them is kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from shaderlab.bands.allowed import widths
from shaderlab.frame import Array

Floats = npt.NDArray[np.float64]
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
        found, largest = 0, -1.0
        for start, distance in self._blocks():
            index = int(distance.argmax())
            if distance.flat[index] > largest:
                found, largest = start * distance.shape[1] + index, float(distance.flat[index])
        row, component = divmod(found, self.measured.shape[1])
        return row, component

    def widths_at(self, row: int, component: int) -> float:
        """One value's distance in half widths, as `Band.widths` has it."""
        at = row, slice(component, component + 1)
        low, high = (bound[at].astype(np.float64) for bound in (self.low, self.high))
        # NaN is inside only where it is legal.
        found = widths(low, high, self.inside[at], self.measured[at], self.unit or 0.0)
        return float(found[0])

    def signed(self) -> Floats:
        """Of each row's components the largest distance, as (count,): negative below the middle,
        at most 1 in size inside, infinite outside."""
        signed = np.empty(len(self.measured))
        for start, distance in self._blocks():
            rows = slice(start, start + len(distance))
            distance[~self.inside[rows]] = np.inf
            at = distance.argmax(axis=1) + np.arange(0, distance.size, distance.shape[1])
            arrays = (self.low[rows], self.high[rows], self.measured[rows], distance)
            low, high, value, size = (array.reshape(-1).take(at) for array in arrays)
            with np.errstate(invalid="ignore"):
                below = value < 0.5 * np.add(low, high, dtype=np.float64)
            signed[rows] = np.where(below, -size, size)
        return signed

    def _blocks(self) -> Iterator[tuple[int, Floats]]:
        """The first row and the distances of each block: at most 1 inside, at least 1 outside.
        The array is used again for the next block."""
        scratch = np.empty((2, min(BLOCK, len(self.measured)), self.measured.shape[1]))
        for start in range(0, len(self.measured), BLOCK):
            rows = slice(start, start + BLOCK)
            low, high, value = self.low[rows], self.high[rows], self.measured[rows]
            half, distance = scratch[:, : len(value)]
            with np.errstate(all="ignore"):
                np.subtract(high, low, out=half, dtype=np.float64)
                half *= 0.5
                np.add(low, half, out=distance, dtype=np.float64)
                np.subtract(value, distance, out=distance)
                np.abs(distance, out=distance)
                distance /= half
                # A band without width, or without an end, has no distance inside but 0.
                np.fmax(distance, 0.0, out=distance)
                np.minimum(distance, 1.0, out=distance)
            beyond = ~self.inside[rows]
            if beyond.any():
                distance[beyond] = self._outside(low[beyond], high[beyond], value[beyond])
            yield start, distance

    def _outside(self, low: Array, high: Array, value: Array) -> Floats:
        wide = low.astype(np.float64), high.astype(np.float64)
        distance = widths(*wide, np.False_, value, self.unit or 0.0)
        return np.maximum(np.where(np.isnan(distance), np.inf, distance), 1.0)
