"""Bands that are kept while many variations of one shader are judged.

A shader that is changed and judged again by the same formula, on the same inputs, has the same
band; evaluating it is most of what judging costs.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Allowed, Band, Rules
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array, Texels

from .chunks import PLACE, chunks, quad_rows
from .formats import (
    FLOAT_FORMATS,
    INTEGER_FORMATS,
    as_result,
    in_format,
    name_of,
    source_of,
    stored,
)
from .inputs import Inputs, Reference, evaluate, wanted


class RememberedBands:
    """Bands by reference and the content of its inputs. The first ones stay; when the limit is
    reached, further ones are not kept.

    Args:
        limit: bytes of bounds that may be kept.
    """

    def __init__(self, limit: int = 1 << 28) -> None:
        self._room = limit
        self._known: dict[tuple[Any, ...], ReferenceBand] = {}

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """Remember bands for a while."""
        token = _REMEMBERED.set(self)
        try:
            yield
        finally:
            _REMEMBERED.reset(token)

    def get(self, key: tuple[Any, ...]) -> ReferenceBand | None:
        return self._known.get(key)

    def keep(self, key: tuple[Any, ...], band: ReferenceBand) -> None:
        size = band.low.nbytes + band.high.nbytes
        if size <= self._room:
            self._room -= size
            self._known[key] = band


_REMEMBERED: ContextVar[RememberedBands | None] = ContextVar("remembered", default=None)


def remembered_bands() -> RememberedBands | None:
    """The bands that are in use now, if any are."""
    return _REMEMBERED.get()


def digest(inputs: Inputs, asked: Mapping[str, list[str]]) -> bytes:
    """Tells inputs apart by the content of all that a formula asks for."""
    found = hashlib.blake2b(digest_size=16)
    for parameter, names in asked.items():
        found.update(repr((parameter, names, [n in inputs.arrays for n in names])).encode())
        for name in names:
            texels = inputs.textures.get(name)
            arrays: tuple[Array, ...]
            if texels is None:
                arrays = (inputs.exact[name],)
            else:
                arrays = (texels.values, *texels.smaller)
                found.update(repr(_sampling(texels)).encode())
            for array in arrays:
                found.update(f"{array.dtype} {array.shape} {name in inputs.each}".encode())
                found.update(np.ascontiguousarray(array).data)
    return found.digest()


def _sampling(texels: Texels) -> dict[str, Any]:
    """How a texture is sampled: all of it but its levels."""
    return {n: v for n, v in vars(texels).items() if n not in ("values", "smaller")}


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


MIN_INFORMATIVE = 0.99
"""The least share of an expectation's values that must be informative."""
MAX_UNDECIDED = 0.05
"""The largest share of values that may have taken both sides of a branch: the shipped cases, which
put none of their inputs onto a branch but by accident, have 0.013 at most."""
# A reference that varies by less than this part of its magnitude counts as a constant.
HARDLY = 1e-3
# Below this, a reference of floats counts as 0, whose scale is 1: what is left of a cancellation
# in float64 is no magnitude.
NOTHING = 1e-7
BLOCK = 16384


@dataclass(frozen=True)
class Plausible:
    """For each component what its band must leave something out of: from `low` to `high` where
    the reference `varies`, or else any range as wide as that."""

    low: Array
    high: Array
    varies: Array

    @classmethod
    @np.errstate(all="ignore")
    def of(cls, reference: Array, format: str) -> Plausible:
        """Read it from some values of a reference.

        Args:
            reference: in float64, (count, components), in the attachment's units.
            format: the attachment's format.
        """
        finite = np.isfinite(reference)
        low = np.where(finite, reference, np.inf).min(axis=0, initial=np.inf)
        high = np.where(finite, reference, -np.inf).max(axis=0, initial=-np.inf)
        none = low > high
        low, high = np.where(none, 0.0, low), np.where(none, 0.0, high)
        span, size = high - low, np.maximum(np.abs(low), np.abs(high))
        if format in INTEGER_FORMATS:
            varies, whole = span > 0.0, np.maximum(size, 1.0)
        elif format in FLOAT_FORMATS or format.endswith("16f"):
            varies = (span > HARDLY * size) & (size >= NOTHING)
            largest = float(size.max(initial=0.0))
            whole = np.full_like(size, largest if largest >= NOTHING else 1.0)
        else:
            limit = 1.0 if format.startswith("depth") else 255.0
            varies, whole = span > limit / 16.0, np.full_like(size, limit)
        return cls(np.where(varies, low, 0.0), np.where(varies, high, whole), varies)

    @np.errstate(all="ignore")
    def informative_share(self, low: Array, high: Array) -> float:
        """The share of values, (count, components), whose bands are informative."""
        if not low.size:
            return 1.0
        least, greatest = self.low.astype(low.dtype), self.high.astype(low.dtype)
        return informative(low, high, least, greatest, self.varies) / low.size


def informative(low: Array, high: Array, least: Array, greatest: Array, varies: Array) -> int:
    """How many bands leave out some of what lies between `least` and `greatest` where the
    component `varies`, and elsewhere are narrower than `greatest`; all with two ends."""
    count = 0
    for start in range(0, len(low), BLOCK):
        one, other = low[start : start + BLOCK], high[start : start + BLOCK]
        width = other - one
        leaves_out = (one > least) | (other < greatest)
        narrow = np.where(varies, leaves_out, width < greatest)
        count += int(np.count_nonzero(narrow & (width < np.inf)))
    return count
