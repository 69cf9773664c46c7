"""Judging numbers by the band that a reference formula gives them: formula, sweep and value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Band, Rules
from shaderlab.bands.allowed import contains
from shaderlab.errors import FormulaError
from shaderlab.frame import Array
from shaderlab.judging.chunks import PLACE, chunks, quad_rows
from shaderlab.judging.distance import Placed
from shaderlab.judging.figures import plain, ulp_distance
from shaderlab.judging.formats import FLOAT_FORMATS, as_result, in_format, stored
from shaderlab.judging.informative import MAX_UNDECIDED, MIN_INFORMATIVE, Plausible
from shaderlab.judging.inputs import Inputs, Reference, evaluate, name_of, source_of, wanted
from shaderlab.records import Row, SourceText, Worst

MAX_VACUOUS = 0.01
# Rows whose reference in float64 tells how much a formula varies over a frame.
SAMPLED = 1024
# Rows for which a band is evaluated at a time: a formula of fifty operations keeps a few dozen
# arrays, some 16 MB a component, instead of gigabytes for a large frame.
CHUNK = 16384


@dataclass(frozen=True, kw_only=True)
class Exact:
    """What a reference gives in float64, evaluated for the rows that are asked for: most checks
    show only the worst value.

    `shape` is that of the measured values, `format` their attachment's; `asked` is what `wanted`
    returns for the reference.
    """

    reference: Reference
    inputs: Inputs
    shape: tuple[int, int]
    format: str
    asked: Mapping[str, list[str]]

    def part(self, start: int, count: int = 1) -> Array:
        """Some rows, (count, components). Raises FormulaError."""
        stop = min(start + count, self.shape[0])
        rows = quad_rows(self.inputs, self.asked, start, stop)
        return self._values(rows)[start - rows.start : stop - rows.start]

    def _values(self, rows: slice | Array) -> Array:
        part = self.inputs.part(rows)
        found = evaluate(self.reference, part, rules=None, decimal=False, asked=self.asked)
        values = np.asarray(found).astype(np.float64, copy=False)
        if isinstance(rows, slice):
            shape = len(range(*rows.indices(self.shape[0]))), self.shape[1]
        else:
            shape = len(rows), self.shape[1]
        _check_shape(self.reference, values.shape, shape)
        return in_format(np.broadcast_to(values, shape), self.format)

    def sample(self, count: int, row: int) -> tuple[Array, Array]:
        """At least `count` rows from all over, or all if there are fewer; and one row,
        (1, components), if there is any. Raises FormulaError."""
        step = max(self.shape[0] // count, 1)
        if step == 1:
            values = self._values(slice(0, self.shape[0]))
            return values, values[row : row + 1]
        # An odd step meets all columns of a frame whose width is a power of two.
        step -= 1 - step % 2
        if PLACE in self.asked:  # it may see a pixel's neighbours
            starts = range(0, self.shape[0], self.shape[0] // 8)
            rows = np.concatenate([self.part(start, count // 8) for start in starts])
            return rows, self.part(row)
        values = self._values(np.append(np.arange(0, self.shape[0], step), row))
        return values[:-1], values[-1:]

    def whole(self) -> Array:
        """All rows, (count, components), a chunk at a time. Raises FormulaError."""
        rows = chunks(self.inputs, self.asked, self.shape[0], CHUNK)
        pieces = [self.part(some.start, some.stop - some.start) for some in rows]
        return np.concatenate(pieces) if pieces else np.empty(self.shape)


@dataclass(frozen=True, kw_only=True)
class Banded(Placed):
    """Measured values beside their reference and band; all arrays are (count, components).

    `low` and `high` are in the measured values' units, and float32 where the attachment's format
    is. `vacuous_share` is the share of values whose band allows anything, `undecided_share` that
    of values that took both sides of a branch.
    """

    exact: Exact
    vacuous_share: float
    undecided_share: float
    source: SourceText
    names: tuple[str, ...]

    @property
    def inputs(self) -> Inputs:
        """What the reference was given."""
        return self.exact.inputs

    @cached_property
    def reference(self) -> Array:
        """What the formula gives in float64, as the attachment would hold it, unrounded."""
        return self.exact.whole()

    @cached_property
    def outside(self) -> int:
        """How many values lie outside their band."""
        return self.inside.size - int(np.count_nonzero(self.inside))

    @cached_property
    def informative_share(self) -> float:
        """The share of values whose band excludes something plausible (see `informative`)."""
        plausible = Plausible.of(self._sample[0], self.exact.format)
        return plausible.informative_share(self.low, self.high)

    @cached_property
    def _furthest(self) -> tuple[int, int]:
        return self.furthest()

    @cached_property
    def _sample(self) -> tuple[Array, Array]:
        """What the formula gives in float64 in rows from all over, and in the worst value's."""
        return self.exact.sample(SAMPLED, self._furthest[0] if self.measured.size else 0)

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
            inputs=self.inputs.at(i, self.names),
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
                f"rules (at most {MAX_VACUOUS:.0%} may): this check could hardly fail"
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
    shape = measured.shape
    chosen = rules or Rules()
    if measured.dtype.kind in "iu" and format in FLOAT_FORMATS:
        format = "r32i" if measured.dtype.kind == "i" else "r32ui"
    asked = wanted(reference, inputs)
    exact = Exact(reference=reference, inputs=inputs, shape=shape, format=format, asked=asked)
    bounds = np.float32 if format in FLOAT_FORMATS else np.float64
    low, high, inside = np.empty(shape, bounds), np.empty(shape, bounds), np.empty(shape, np.bool_)
    unit, vacuous, undecided = None, 0, 0
    for rows in chunks(inputs, asked, len(measured), CHUNK):
        some = measured[rows]
        try:
            band = evaluate(reference, inputs.part(rows), rules=chosen, decimal=False, asked=asked)
        except FormulaError:
            exact.part(0, CHUNK)  # an error of plain numbers is easier to read
            raise
        band = as_result(band, format, chosen)
        _check_shape(reference, band.shape, some.shape)
        allowed = stored(band, format, shape[1])
        unit = None if isinstance(allowed, Band) else float(allowed.unit) or None
        low[rows], high[rows] = allowed.lo, allowed.hi
        inside[rows] = contains(low[rows], high[rows], allowed.nan, some)
        vacuous += _count(allowed.vacuous, some)
        undecided += _count(allowed.undecided, some)
    return Banded(
        measured=measured,
        low=low,
        high=high,
        inside=inside,
        unit=unit,
        exact=exact,
        vacuous_share=vacuous / max(measured.size, 1),
        undecided_share=undecided / max(measured.size, 1),
        source=source_of(reference),
        names=tuple(n for names in asked.values() for n in names),
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


def _check_shape(reference: Reference, given: tuple[int, ...], measured: tuple[int, ...]) -> None:
    rows, components = measured
    got = given[-1] if given else 1
    if got not in (1, components):
        message = f"gives {got} components, the shader's output has {components}"
    elif len(given) > 2 or (len(given) == 2 and given[0] not in (1, rows)):
        message = f"gives shape {given} for {rows} values"
    else:
        return
    place = source_of(reference)
    raise FormulaError(
        f"{name_of(reference)}() {message}",
        file=place.file,
        line=place.line,
        remedy="v.x is one component of a vector, vec4(v, 0.0, 1.0) adds the missing ones",
    )


def _count(flags: npt.NDArray[np.bool_], values: Array) -> int:
    """How many of the values are marked; flags of fewer components are those of all."""
    return int(np.count_nonzero(flags)) * (values.size // max(flags.size, 1))


def _pixel(covered: Array, index: int) -> tuple[int, int]:
    """x and y of covered pixel number `index`, counted along rows."""
    y, x = divmod(int(np.flatnonzero(covered)[index]), covered.shape[1])
    return x, y
