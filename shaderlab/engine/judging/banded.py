"""Judging numbers by the band that a reference formula gives them: formula, sweep and value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shaderlab.bands import Rules
from shaderlab.bands.allowed import contains
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array
from shaderlab.model.records import Row, SourceText, Worst

from .distance import Placed, plain, ulp_distance
from .formats import FLOAT_FORMATS, source_of
from .inputs import Inputs, Reference, evaluate
from .reference_bands import (
    MAX_UNDECIDED,
    MIN_INFORMATIVE,
    Plausible,
    ReferenceBand,
    reference_band,
)

MAX_VACUOUS = 0.01


@dataclass(frozen=True, kw_only=True)
class Banded(Placed):
    """Measured values beside their reference and band; all arrays are (count, components).

    `low` and `high` are in the measured values' units, and float32 where the attachment's format
    is.
    """

    band: ReferenceBand

    @property
    def inputs(self) -> Inputs:
        """What the reference was given."""
        return self.band.exact.inputs

    @property
    def source(self) -> SourceText:
        """Where the reference stands, and its text."""
        return source_of(self.band.exact.reference)

    @property
    def vacuous_share(self) -> float:
        """The share of values whose band allows anything."""
        return self.band.vacuous / max(self.measured.size, 1)

    @property
    def undecided_share(self) -> float:
        """The share of values that took both sides of a branch."""
        return self.band.undecided / max(self.measured.size, 1)

    @property
    def reference(self) -> Array:
        """What the formula gives in float64, as the attachment would hold it, unrounded."""
        return self.band.values

    @cached_property
    def outside(self) -> int:
        """How many values lie outside their band."""
        return self.inside.size - int(np.count_nonzero(self.inside))

    @cached_property
    def informative_share(self) -> float:
        """The share of values whose band excludes something plausible (see `informative`)."""
        plausible = Plausible.of(self._sample[0], self.band.exact.format)
        return plausible.informative_share(self.low, self.high)

    @cached_property
    def _furthest(self) -> tuple[int, int]:
        return self.furthest()

    @cached_property
    def _sample(self) -> tuple[Array, Array]:
        """What the formula gives in float64 in rows from all over, and in the worst value's."""
        return self.band.sample(self._furthest[0] if self.measured.size else 0)

    def worst(self, covered: Array | None = None) -> Worst | None:
        """The value furthest from its band's middle, as seen from the band; None of nothing.

        `covered` (height, width) says which pixels the values are those of.
        """
        if not self.measured.size:
            return None
        i, c = self._furthest
        reference = self._sample[1][0]
        self._require_inside(i, reference)
        return Worst(
            pixel=None if covered is None else _pixel(covered, i),
            component=c,
            measured=plain(self.measured[i]),
            reference=plain(reference),
            low=plain(self.low[i]),
            high=plain(self.high[i]),
            ulp=ulp_distance(self.measured[i, c], reference[c], self.unit),
            widths=self.widths_at(i, c),
            inputs=self.inputs.at(i, self.band.names),
        )

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
            return "fail", "nothing was judged: no pixel is covered"
        if self.outside:
            return "fail", f"{self.outside} of {self.measured.size} values lie outside their band"
        if self.vacuous_share > MAX_VACUOUS:
            return "fail", (
                f"{self.vacuous_share:.1%} of the values may be anything under the precision "
                f"rules (at most {MAX_VACUOUS:.0%} may): this check could hardly fail\n→ give "
                "inputs at which each step is specified: sin and cos within [-π, π], divisors, "
                "roots and powers away from 0; or judge the steps one by one"
            )
        if self.informative_share < MIN_INFORMATIVE:
            return "fail", (
                f"only {self.informative_share:.1%} of the values have a band that excludes "
                f"anything plausible (at least {MIN_INFORMATIVE:.0%} must): the others hold all "
                "that the formula gives over the frame\n→ give inputs at which it varies "
                "by more than its precision, or judge a step before the precision is lost"
            )
        if self.undecided_share > MAX_UNDECIDED:
            return "fail", (
                f"{self.undecided_share:.1%} of the values took both sides of a branch (at most "
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
    """Evaluate `reference` as a band, and hold the measured values against it.

    Args:
        measured: (count, components) as read back from an attachment of `format`.
        reference: the formula.
        inputs: what the shader got.
        rules: precision rules; None for the default ones.
        format: the attachment's format; the band is rounded as storing to it rounds.

    Raises:
        FormulaError: the formula fails or gives another number of components.
    """
    if measured.dtype.kind in "iu" and format in FLOAT_FORMATS:
        format = "r32i" if measured.dtype.kind == "i" else "r32ui"
    band = reference_band(
        reference, inputs, shape=measured.shape, rules=rules or Rules(), format=format
    )
    return Banded(
        measured=measured,
        low=band.low,
        high=band.high,
        inside=contains(band.low, band.high, band.nan, measured),
        unit=band.unit,
        band=band,
    )


def independent_references(banded: Banded, also: Mapping[str, Reference]) -> list[Row]:
    """Each independent implementation, in float64 on the same inputs, against the band."""
    rows = []
    for name, implementation in also.items():
        values = np.asarray(evaluate(implementation, banded.inputs, rules=None, decimal=False))
        try:
            values = np.broadcast_to(values, banded.low.shape)
        except ValueError:
            place = source_of(implementation)
            raise FormulaError(
                f"{name} gives an array of shape {values.shape}, "
                f"the reference one of shape {banded.low.shape}",
                file=place.file,
                line=place.line,
            ) from None
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
    """x and y of covered pixel number `index`, counted along rows."""
    y, x = divmod(int(np.flatnonzero(covered)[index]), covered.shape[1])
    return x, y
