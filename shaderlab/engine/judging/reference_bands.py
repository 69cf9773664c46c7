"""What a reference formula gives on some inputs: in float64, and as a band."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Allowed, Band, Rules
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array

from .chunks import PLACE, chunks, quad_rows
from .formats import FLOAT_FORMATS, as_result, in_format, stored
from .inputs import Inputs, Reference, evaluate, wanted
from .remembered import digest, remembered_bands
from .written import name_of, source_of

Flags = npt.NDArray[np.bool_]

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
        return self._parts([(start, count)])[0]

    def at(self, rows: Array) -> Array:
        """Some rows by their ascending numbers. Raises FormulaError."""
        if PLACE not in self.asked:
            return self._values(rows)
        first, last = (int(rows[end]) for end in (0, -1)) if rows.size else (0, -1)
        found: Array = self.part(first, last - first + 1)[rows - first]
        return found

    def _parts(self, parts: Sequence[tuple[int, int]]) -> list[Array]:
        """As `part`, of several (start, count), which are evaluated together."""
        wanted = [slice(start, min(start + count, self.shape[0])) for start, count in parts]
        whole = quad_rows(self.inputs, self.asked, wanted)
        if len(whole) == 1:
            found = [self._values(whole[0])]
        else:
            values = self._values(np.concatenate([np.arange(w.start, w.stop) for w in whole]))
            found = np.split(values, np.cumsum([w.stop - w.start for w in whole])[:-1])
        return [
            values[some.start - rows.start : some.stop - rows.start]
            for values, some, rows in zip(found, wanted, whole, strict=True)
        ]

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
            found = self._parts([*((start, count // 8) for start in starts), (row, 1)])
            return np.concatenate(found[:-1]), found[-1]
        values = self._values(np.append(np.arange(0, self.shape[0], step), row))
        return values[:-1], values[-1:]

    def whole(self) -> Array:
        """All rows, (count, components), a chunk at a time. Raises FormulaError."""
        rows = chunks(self.inputs, self.asked, self.shape[0], CHUNK)
        pieces = [self.part(some.start, some.stop - some.start) for some in rows]
        return np.concatenate(pieces) if pieces else np.empty(self.shape)


@dataclass(frozen=True, kw_only=True)
class ReferenceBand:
    """The band of a reference on some inputs, as an attachment's format holds it.

    Attributes:
        exact: the same formula in float64.
        low, high: (count, components), float32 where the format is one of floats.
        nan: where NaN is legal, (count, components); False where it is nowhere.
        unit: the size of one code for fixed-point formats, None for floats.
        vacuous: how many values have a band that allows anything.
        undecided: how many took both sides of a branch.
        names: the GLSL names that the reference reads.
    """

    exact: Exact
    low: Array
    high: Array
    nan: Flags | np.bool_
    unit: float | None
    vacuous: int
    undecided: int
    names: tuple[str, ...]

    @cached_property
    def values(self) -> Array:
        """What the formula gives in float64, as the attachment would hold it, unrounded."""
        return self.exact.whole()

    def at(self, rows: Array | slice) -> Array:
        """As `values`, of some rows, ascending; few of them are evaluated alone."""
        if isinstance(rows, slice) or len(rows) > CHUNK or "values" in self.__dict__:
            return self.values[rows]
        return self.exact.at(rows)

    def sample(self, row: int) -> tuple[Array, Array]:
        """What the formula gives in float64 in rows from all over, and in one row."""
        if self._sampled:
            return self._sampled[0], self.exact.part(row)
        found = self.exact.sample(SAMPLED, row)
        self._sampled.append(found[0])
        return found

    @cached_property
    def _sampled(self) -> list[Array]:
        return []


def reference_band(
    reference: Reference, inputs: Inputs, *, shape: tuple[int, int], rules: Rules, format: str
) -> ReferenceBand:
    """The band of a formula, evaluated unless it is remembered.

    Args:
        reference: the formula.
        inputs: what the shader got.
        shape: count and components of the measured values.
        rules: precision rules.
        format: the attachment's format; the band is rounded as storing to it rounds.

    Raises:
        FormulaError: the formula fails or gives another number of components.
    """
    asked = wanted(reference, inputs)
    remembered = remembered_bands()
    if remembered is None:
        return _evaluated(reference, inputs, asked, shape, rules, format)
    # A band keeps its reference, so that no other object gets its number.
    key = id(reference), rules, format, shape, digest(inputs, asked)
    band = remembered.get(key)
    if band is None:
        band = _evaluated(reference, inputs, asked, shape, rules, format)
        remembered.keep(key, band)
    return band


def _evaluated(
    reference: Reference,
    inputs: Inputs,
    asked: Mapping[str, list[str]],
    shape: tuple[int, int],
    rules: Rules,
    format: str,
) -> ReferenceBand:
    exact = Exact(reference=reference, inputs=inputs, shape=shape, format=format, asked=asked)
    bounds = np.float32 if format in FLOAT_FORMATS else np.float64
    low, high = np.empty(shape, bounds), np.empty(shape, bounds)
    nan: Flags | np.bool_ = np.False_
    unit, vacuous, undecided = None, 0, 0
    for rows in chunks(inputs, asked, shape[0], CHUNK):
        try:
            band = evaluate(reference, inputs.part(rows), rules=rules, decimal=False, asked=asked)
        except FormulaError:
            exact.part(0, CHUNK)  # an error of plain numbers is easier to read
            raise
        band = as_result(band, format, rules)
        part = low[rows].shape
        _check_shape(reference, band.shape, part)
        allowed = stored(band, format, shape[1])
        unit = None if isinstance(allowed, Band) else float(allowed.unit) or None
        low[rows], high[rows] = allowed.lo, allowed.hi
        may_be_nan, anything, both = _marks(allowed)
        if np.any(may_be_nan):
            nan = np.zeros(shape, np.bool_) if nan.ndim == 0 else nan
            nan[rows] = may_be_nan  # type: ignore[index]
        vacuous += _count(anything, part)
        undecided += _count(both, part)
    return ReferenceBand(
        exact=exact,
        low=low,
        high=high,
        nan=nan,
        unit=unit,
        vacuous=vacuous,
        undecided=undecided,
        names=tuple(n for names in asked.values() for n in names),
    )


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


def _marks(allowed: Band | Allowed) -> tuple[Flags, Flags, Flags]:
    """Where NaN is legal, where anything is, and where a branch went both ways; 0-d for nowhere."""
    if isinstance(allowed, Allowed):
        return allowed.nan, allowed.vacuous, allowed.undecided
    nan, vacuous, undecided = allowed.flags
    if allowed.lo.size and not allowed.lo.min() > -np.inf:  # NaN too
        vacuous = allowed.vacuous
    return nan, vacuous, undecided


def _count(flags: Flags, shape: tuple[int, ...]) -> int:
    """How many of the values are marked; flags of fewer components are those of all."""
    return int(np.count_nonzero(flags)) * (math.prod(shape) // max(flags.size, 1))
