"""Judging numbers by the band that a reference formula gives them: formula, sweep and value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Allowed, Band, Rules
from shaderlab.bands.allowed import contains
from shaderlab.checks.inputs import Inputs, Reference, evaluate, source_of, wanted
from shaderlab.checks.judgement import plain, shown
from shaderlab.errors import FormulaError
from shaderlab.frame import Array
from shaderlab.records import Row, SourceText, Worst

MAX_VACUOUS = 0.01
# How many values a band is evaluated for at a time: a formula of fifty operations keeps a few
# dozen arrays of them, 16 MB or so a component, instead of gigabytes for a large frame.
CHUNK = 16384
_FLOAT_FORMATS = ("r32f", "rg32f", "rgba32f")
_UNORM_FORMATS = ("r8", "rg8", "rgb8", "rgba8")


@dataclass(frozen=True, kw_only=True)
class Banded:
    """Measured values beside their reference and band; all arrays are (count, components).

    `low` and `high` are float32 where the attachment's format is: a band's bounds are.
    `inside` says which are in their band, `widths` how far each is from its middle in half
    widths, `low` and `high` are the band in the measured values' own units. `unit` is the size
    of one code for fixed-point formats, None for floats.
    """

    measured: Array
    reference: Array
    low: Array
    high: Array
    inside: npt.NDArray[np.bool_]
    widths: Array
    vacuous: npt.NDArray[np.bool_]
    undecided: npt.NDArray[np.bool_]
    source: SourceText
    names: tuple[str, ...]
    inputs: Inputs
    unit: float | None = None

    @property
    def vacuous_share(self) -> float:
        """Share of values whose band allows anything."""
        return float(self.vacuous.mean()) if self.vacuous.size else 0.0

    @property
    def undecided_share(self) -> float:
        """Share of values that went both ways of a branch."""
        return float(self.undecided.mean()) if self.undecided.size else 0.0

    def worst(self, pixels: Array | None = None) -> Worst | None:
        """The value furthest from its band's middle, as seen from the band; None of nothing.

        `pixels` are the values' places, (count, 2): x and y.
        """
        if not self.measured.size:
            return None
        distance = np.where(np.isnan(self.widths), np.inf, self.widths)
        # A value outside outranks all inside, whatever their widths.
        distance = np.where(self.inside, np.minimum(distance, 1.0), np.maximum(distance, 1.0))
        index, component = np.unravel_index(int(np.argmax(distance)), distance.shape)
        i, c = int(index), int(component)
        return Worst(
            pixel=None if pixels is None else (int(pixels[i, 0]), int(pixels[i, 1])),
            component=c,
            measured=plain(self.measured[i]),
            reference=plain(self.reference[i]),
            low=plain(self.low[i]),
            high=plain(self.high[i]),
            ulp=ulp_distance(self.measured[i, c], self.reference[i, c], self.unit),
            widths=float(self.widths[i, c]),
            inputs=self.inputs.at(i, self.names),
        )

    def signed_distance(self) -> Array:
        """Distance from the band's middle in half widths, negative below it, as (count,): that
        of the component that is furthest out; infinite for a value outside."""
        size = np.where(self.inside, np.minimum(self.widths, 1.0), np.inf)
        worst = np.argmax(size, axis=1)[:, None]
        with np.errstate(invalid="ignore"):
            below = self.measured < 0.5 * np.add(self.low, self.high, dtype=np.float64)
        signed = np.where(below, -size, size)
        return np.take_along_axis(signed, worst, axis=1)[:, 0]

    def verdict(self) -> tuple[str, str]:
        """("pass" or "fail", what to say about it)."""
        outside = int((~self.inside).sum())
        if not self.measured.size:
            return "fail", "nothing was judged: no pixel is covered"
        if outside:
            return "fail", f"{outside} of {self.measured.size} values lie outside their band"
        if self.vacuous_share > MAX_VACUOUS:
            return "fail", (
                f"{self.vacuous_share:.1%} of the values may be anything under the precision "
                f"rules (at most {MAX_VACUOUS:.0%} may): this check could hardly fail"
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
    """Evaluate `reference` in float64 and as a band, and hold the measured values against both.

    Args:
        measured: (count, components) as read back from an attachment of `format`.
        reference: the formula.
        inputs: what the shader got.
        rules: precision rules; None for the default ones.
        format: the attachment's format; the band is rounded as storing to it rounds.

    Raises:
        FormulaError: the formula fails or gives another number of components.
    """
    shape = measured.shape
    chosen = rules or Rules()
    numbers = {name: np.empty(shape) for name in ("reference", "widths")}
    bounds = np.float32 if format in _FLOAT_FORMATS else np.float64
    low, high = np.empty(shape, bounds), np.empty(shape, bounds)
    flags = {name: np.empty(shape, np.bool_) for name in ("inside", "vacuous", "undecided")}
    unit = None
    for start in range(0, max(len(measured), 1), CHUNK):
        rows = slice(start, start + CHUNK)
        some = measured[rows]
        part = inputs.part(rows)
        exact = evaluate(reference, part, rules=None, decimal=False)
        band = evaluate(reference, part, rules=chosen, decimal=False)
        if not isinstance(band, Band):
            band = Band.literal(np.asarray(band, np.float64), chosen)
        _check_shape(reference, band, some)
        allowed = _stored(band, format, shape[1])
        unit = None if isinstance(allowed, Band) else float(allowed.unit) or None
        numbers["reference"][rows] = np.asarray(exact, np.float64)
        low[rows], high[rows] = allowed.lo, allowed.hi
        numbers["widths"][rows] = allowed.widths(some)
        flags["inside"][rows] = contains(low[rows], high[rows], allowed.nan, some)
        flags["vacuous"][rows], flags["undecided"][rows] = band.vacuous, band.undecided
    with np.errstate(invalid="ignore"):  # a signalling NaN, read back, is a NaN like any other
        values = measured.astype(np.float64)
    return Banded(
        measured=values,
        reference=in_format(numbers["reference"], format),
        low=low,
        high=high,
        widths=numbers["widths"],
        **flags,
        source=source_of(reference),
        names=tuple(n for names in wanted(reference, inputs).values() for n in names),
        inputs=inputs,
        unit=unit,
    )


def second_opinions(banded: Banded, also: Mapping[str, Reference]) -> list[Row]:
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


def ulp_distance(measured: float, reference: float, unit: float | None = None) -> float:
    """How many float32 units in the last place of `reference` (or `unit`s) lie between the two.

    >>> ulp_distance(1.0 + 2.0**-23, 1.0)
    1.0
    """
    unit = unit or float(np.spacing(np.float32(abs(reference))))
    return abs(float(measured) - float(reference)) / unit if np.isfinite(reference) else np.nan


def _stored(band: Band, format: str, components: int) -> Band | Allowed:
    """The band as it may come back from an attachment of this format."""
    if format in _FLOAT_FORMATS:
        return band
    if format.startswith("depth"):
        return band.quantise(format.removesuffix("_stencil8"))
    if format.endswith("16f"):
        return band.quantise("rgba16f")
    if format in _UNORM_FORMATS:
        return band.quantise("rgba8")
    if format != "srgb8_alpha8":
        raise FormulaError(f"a formula over a {format} attachment: judge integers with exact(…)")
    color = band.quantise("srgb8")
    alpha = band.quantise("rgba8")
    # Alpha is not encoded (OpenGL 4.5, §17.3.7): the last component keeps its own rule.
    is_alpha = np.arange(components) == 3

    def pick(of_color: Array, of_alpha: Array) -> Array:
        return np.where(is_alpha, of_alpha, of_color)

    return Allowed(
        pick(color.lo, alpha.lo),
        pick(color.hi, alpha.hi),
        pick(color.nan, alpha.nan),
        pick(color.vacuous, alpha.vacuous),
        pick(color.undecided, alpha.undecided),
        unit=1.0,
    )


def in_format(values: Array, format: str) -> Array:
    """A float64 reference as it would be read back from `format`, unrounded."""
    if format in _UNORM_FORMATS:
        return np.clip(values, 0.0, 1.0) * 255.0
    if format.startswith("depth"):
        return np.clip(values, 0.0, 1.0)
    if format == "srgb8_alpha8":
        from shaderlab.reference.gamma import srgb_encode

        linear = np.clip(values, 0.0, 1.0)
        encoded = np.array(srgb_encode(linear))
        encoded[..., 3:] = linear[..., 3:]
        return encoded * 255.0
    return values


def figure_row(
    label: str, equals: Any, digits: int, computed: Any, measured: Any, ok: bool, note: str
) -> Row:
    """One line of a table of figures: as printed, and as measured with a few digits more."""
    more = min(digits + 3, 9)
    text = shown(computed, more) if measured is None else shown(measured, more)
    return Row(label=label, expected=shown(equals, digits), measured=text, ok=ok, note=note)


def rounds_to(computed: Any, equals: Any, digits: int) -> bool:
    """Whether every component, rounded to `digits` decimals, is the printed figure.

    A tie may have been rounded either way by whoever printed it.
    """
    difference = np.abs(np.asarray(computed, np.float64) - np.asarray(equals, np.float64))
    return bool(np.all(difference <= 0.5 * 10.0**-digits * (1.0 + 1e-6)))


def _check_shape(reference: Reference, band: Band, measured: Array) -> None:
    got = band.shape[-1] if band.shape else 1
    if got not in (1, measured.shape[1]):
        place = source_of(reference)
        raise FormulaError(
            f"{reference.__name__}() gives {got} components, the shader's output has "
            f"{measured.shape[1]}",
            file=place.file,
            line=place.line,
        )
    if len(band.shape) > 2 or (len(band.shape) == 2 and band.shape[0] not in (1, len(measured))):
        raise FormulaError(
            f"{reference.__name__}() gives shape {band.shape} for {len(measured)} values",
            file=source_of(reference).file,
            line=source_of(reference).line,
        )
