"""Holds measured values against the band that a reference formula gives them.

A record shows only the largest distance from a band's middle, a picture the largest of each
pixel, so distances are computed block by block, in memory that stays in the processor's cache.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Rules
from shaderlab.bands.bounds import contains, widths
from shaderlab.errors import FormulaError, significant
from shaderlab.model.frame import Array
from shaderlab.model.records import Curve, Outcome, Row, SourceText, Worst

from .bands import FLOAT_FORMATS, MAX_UNDECIDED, MIN_INFORMATIVE, ReferenceBand, reference_band
from .references import Inputs, Reference, evaluate, make_error, source_of

Floats = npt.NDArray[np.float64]
Distances = npt.NDArray[np.floating[Any]]
BLOCK = 4096
"""Rows whose distances are computed at a time: with four components in float64, twice, a quarter of
a megabyte."""
NOTHING_DRAWN = (
    "nothing was judged: no pixel is covered\n→ look at what hides the draw: culling, viewport, "
    "depth and stencil test, later draws, discard, places outside the clip volume"
)
MAX_VACUOUS = 0.01
"""The largest share of values whose band may allow anything."""


@dataclass(frozen=True, kw_only=True)
class BoundedValues:
    """Measured values with their bands, all arrays (count, components).

    `inside` says which are in their band; `unit` is a fixed-point format's step, None for floats.
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
        furthest, largest = 0, -1.0
        for start, distance in self.blocks():
            index = int(distance.argmax())
            here = float(distance.flat[index])
            if here > largest:
                furthest, largest = start * distance.shape[1] + index, here
        row, component = divmod(furthest, self.measured.shape[1])
        return row, component

    def widths_at(self, row: int, component: int) -> float:
        """One value's distance in half widths, as `Band.widths` has it."""
        at = row, slice(component, component + 1)
        return float(
            self._widths(self.low[at], self.high[at], self.measured[at], self.inside[at])[0]
        )

    def measure_distances(self) -> Floats:
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
        """The first row and the distances of each block: at most 1 inside, at least 1 outside."""
        alike = self.measured.dtype == self.low.dtype == self.high.dtype == np.float32
        for start in range(0, len(self.measured), BLOCK):
            rows = slice(start, start + BLOCK)
            block = self.low[rows], self.high[rows], self.measured[rows], self.inside[rows]
            distance: Distances | None = _narrow(*block[:3]) if alike else None
            if distance is None:
                distance = self._widths(*block)
            elif not block[3].all():
                beyond = ~block[3]
                distance = distance.astype(np.float64)
                distance[beyond] = self._widths(*(array[beyond] for array in block))
            # NaN is inside only where it is legal.
            yield start, np.where(block[3], np.minimum(distance, 1.0), np.maximum(distance, 1.0))

    def _widths(
        self, low: Array, high: Array, value: Array, inside: npt.NDArray[np.bool_]
    ) -> Floats:
        bounds = low.astype(np.float64), high.astype(np.float64)
        return widths(*bounds, inside, value, self.unit or 0.0)


@np.errstate(all="ignore")
def _narrow(low: Array, high: Array, value: Array) -> Distances | None:
    """Distances of float32 values inside float32 bounds, to a few units of the last place of 1;
    None where a band is wider than float32 can hold."""
    whole = high - low
    if not whole.max() < np.inf:  # NaN too
        return None
    # How far from either bound: exact where bounds are close to each other, and the same in size
    # for a value and a band mirrored at zero.
    distance: Distances = np.abs((value - low) - (high - value)) / whole
    # A band without width, or without an end, has no distance inside but 0.
    return np.fmax(distance, 0.0)


@dataclass(frozen=True, kw_only=True)
class Banded(BoundedValues):
    """Measured values beside their reference and band; all arrays are (count, components).

    `low` and `high` are in the measured values' units, and float32 where the attachment's format
    is.
    """

    band: ReferenceBand

    @property
    def inputs(self) -> Inputs:
        """What the reference was given."""
        return self.band.inputs

    @property
    def source(self) -> SourceText:
        """Where the reference stands, and its text."""
        return source_of(self.band.reference)

    def outcome(self, covered: Array | None = None, **said: Any) -> Outcome:
        """What came of it, as a record has it, with the fields that are `said`; the shares are
        those of values whose band allows anything, and that took both sides of a branch."""
        count = max(self.measured.size, 1)
        return Outcome(
            judged=int(self.measured.size),
            outside=self.outside,
            worst=self.worst(covered),
            vacuous=self.band.vacuous / count,
            undecided=self.band.undecided / count,
            informative=self.band.informative_share,
            **said,
        )

    @property
    def reference(self) -> Array:
        """What the formula gives in float64, as the attachment would hold it, unrounded."""
        return self.band.values

    @cached_property
    def outside(self) -> int:
        """How many values lie outside their band."""
        return self.inside.size - int(np.count_nonzero(self.inside))

    def worst(self, covered: Array | None = None) -> Worst | None:
        """The value furthest from its band's middle, as seen from the band; None of nothing.

        `covered` (height, width) says which pixels the values are those of.
        """
        if not self.measured.size:
            return None
        i, c = self.furthest()
        reference = self.band.values_at(np.array([i]))[0]
        self._require_inside(i, reference)
        names = [name for names in self.band.parameters.values() for name in names]
        return Worst(
            pixel=None if covered is None else _pixel(covered, i),
            component=c,
            measured=to_tuple(self.measured[i]),
            reference=to_tuple(reference),
            low=to_tuple(self.low[i]),
            high=to_tuple(self.high[i]),
            ulp=ulp_distance(self.measured[i, c], reference[c], self.unit),
            widths=self.widths_at(i, c),
            inputs=self.inputs.at(i, names),
        )

    def curve(
        self, title: str, over: str, label: str, x: Sequence[float], rows: Any = slice(None)
    ) -> Curve:
        """What the report draws over an input: of the component that the reference varies most."""
        number = int(np.argmax(np.ptp(self.reference, axis=0)))
        y_label = f"{label}.{'xyzw'[number]}" if self.measured.shape[1] > 1 else label
        names = ("measured", "reference", "low", "high")
        numbers: Any = {name: tuple(getattr(self, name)[rows, number].tolist()) for name in names}
        return Curve(title=title, x_label=over, y_label=y_label, x=tuple(x), **numbers)

    @np.errstate(invalid="ignore")
    def _require_inside(self, i: int, reference: Array) -> None:
        """Raise FormulaError where the reference leaves its own band, but for float64's roundings
        and the format's: then one of the two is wrong, whatever the shader does."""
        low, high = self.low[i].astype(np.float64), self.high[i].astype(np.float64)
        give = (self.unit or 0.0) + 2.0**-40 * np.maximum(1.0, np.abs(reference))
        outside = (reference < low - give) | (reference > high + give)
        if outside.any():
            c = int(np.argmax(outside))
            raise FormulaError(
                f"the reference's float64 value lies outside its band: {reference[c]:.9g} is not "
                f"in [{low[c]:.9g}, {high[c]:.9g}]",
                file=self.source.file,
                line=self.source.line,
                remedy="the formula gives arrays and bands different values, or the lab is wrong; "
                "in the latter case please report it",
            )

    def verdict(self) -> tuple[str, str]:
        """("pass" or "fail", what to say about it)."""
        if not self.measured.size:
            return "fail", NOTHING_DRAWN
        if self.outside:
            return "fail", f"{self.outside} of {self.measured.size} values lie outside their band"
        vacuous, undecided = (
            n / self.measured.size for n in (self.band.vacuous, self.band.undecided)
        )
        if vacuous > MAX_VACUOUS:
            return "fail", (
                f"{vacuous:.1%} of the values may be anything under the precision "
                f"rules (at most {MAX_VACUOUS:.0%} may): this check could hardly fail\n→ give "
                "inputs at which each step is specified: sin and cos within [-π, π], divisors, "
                "roots and powers away from 0; or judge the steps one by one"
            )
        if self.band.informative_share < MIN_INFORMATIVE:
            return "fail", (
                f"only {self.band.informative_share:.1%} of the values have a band that excludes "
                f"anything plausible (at least {MIN_INFORMATIVE:.0%} must): the others hold all "
                "that the formula gives over the frame\n→ give inputs at which it varies "
                "by more than its precision, or judge a step before the precision is lost"
            )
        if undecided > MAX_UNDECIDED:
            return "fail", (
                f"{undecided:.1%} of the values took both sides of a branch (at most "
                f"{MAX_UNDECIDED:.0%} may)\n→ give inputs further from where the branch changes"
            )
        return "pass", ""


def judge_band(
    measured: Array,
    reference: Reference,
    inputs: Inputs,
    *,
    rules: Rules | None,
    format: str = "rgba32f",
) -> Banded:
    """Evaluate `reference` as a band, and hold the measured values (count, components), as read
    back from an attachment of `format`, against it: the band is rounded as storing to it rounds.
    Raises FormulaError: the formula fails or gives another number of components."""
    if measured.dtype.kind in "iu" and format in FLOAT_FORMATS:
        format = "r32i" if measured.dtype.kind == "i" else "r32ui"
    band = reference_band(
        reference, inputs, shape=measured.shape, rules=rules or Rules(), format=format
    )
    inside = contains(band.low, band.high, band.nan, measured)
    if np.any(band.nan) and (rows := np.flatnonzero((np.isnan(measured) & inside).any(-1))).size:
        # A band without an end allows NaN, but a number that the formula gives does not.
        inside[rows] &= ~(np.isnan(measured[rows]) & np.isfinite(band.values_at(rows)))
    return Banded(
        measured=measured, low=band.low, high=band.high, inside=inside, unit=band.unit, band=band
    )


def independent_references(banded: Banded, also: Mapping[str, Reference]) -> list[Row]:
    """Each independent implementation, in float64 on the same inputs, against the band."""
    rows = []
    for name, implementation in also.items():
        values = np.asarray(evaluate(implementation, banded.inputs, rules=None, decimal=False))
        try:
            values = np.broadcast_to(values, banded.low.shape)
        except ValueError:
            shapes = f"{values.shape}, the reference one of shape {banded.low.shape}"
            message = f"{name} gives an array of shape {shapes}"
            raise make_error(implementation, message) from None
        outside = int((~((values >= banded.low) & (values <= banded.high))).sum())
        off = float(np.nanmax(np.abs(values - banded.reference))) if values.size else 0.0
        rows.append(
            Row(
                label=name,
                expected="in the band everywhere",
                measured=f"{outside} of {values.size} values outside",
                ok=outside == 0,
                note=f"at most {off:.3g} from the reference",
            )
        )
    return rows


def _pixel(covered: Array, index: int) -> tuple[int, int]:
    y, x = divmod(int(np.flatnonzero(covered)[index]), covered.shape[1])
    return x, y


def figure_row(
    label: str, equals: Any, digits: int, computed: Any, measured: Any, ok: bool, note: str
) -> Row:
    """One line of a table of figures: as printed, and as measured with a few digits more, or none
    of integers."""
    found = computed if measured is None else measured
    whole = isinstance(found, np.ndarray) and found.dtype.kind in "iu"
    text = format_value(found, 0 if whole else min(digits + 3, 9))
    digits = 0 if whole else digits
    return Row(label=label, expected=format_value(equals, digits), measured=text, ok=ok, note=note)


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
    unit = unit or float(np.spacing(np.float32(min(abs(reference), 2.0**127))))
    return abs(float(measured) - float(reference)) / unit if np.isfinite(reference) else np.nan


def to_tuple(values: Array) -> tuple[float, ...]:
    """A vector as a tuple of Python numbers."""
    return tuple(float(v) for v in np.ravel(values))


def format_value(values: object, digits: int | None = None) -> str:
    """A number or vector for people: `digits` decimals, or nine significant digits.

    >>> format_value((0.5, 1.0)), format_value(0.25, 4)
    ('(0.5, 1)', '0.2500')
    """
    numbers = [float(v) for v in np.ravel(np.asarray(values, np.float64))]
    texts = [f"{n:.{digits}f}" if digits is not None else significant(n) for n in numbers]
    return texts[0] if len(texts) == 1 else f"({', '.join(texts)})"
