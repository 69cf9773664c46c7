"""The band of a reference formula over judged values, as an attachment's format holds it.

A formula is evaluated a few thousand rows at a time. Bands can be kept while many variations of one
shader are judged by the same formula on the same inputs (`BandCache`): evaluating them is most of
what judging costs.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Allowed, Band, Integer, Rules
from shaderlab.bands.formats import srgb_encode
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array

from .references import Inputs, Reference, evaluate, make_error, match_parameters, name_of

Flags = npt.NDArray[np.bool_]

FLOAT_FORMATS = ("r32f", "rg32f", "rgba32f")
_UNORM_FORMATS = ("r8", "rg8", "rgb8", "rgba8")
INTEGER_FORMATS = tuple(f"{c}32{kind}" for c in ("r", "rg", "rgba") for kind in ("i", "ui"))

PLACE = "frag_coord"
"""The parameter by which a formula may compare a pixel with its neighbours."""
CHUNK = 16384
"""Rows for which a formula is evaluated at a time: one of fifty operations keeps a few dozen
arrays, some 16 MB a component, instead of gigabytes for a large frame."""
SAMPLED = 1024
"""Rows whose reference in float64 tells how much a formula varies over a frame."""
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


@dataclass(frozen=True, kw_only=True)
class ReferenceBand:
    """The band of a reference on some inputs, as an attachment's format holds it.

    Attributes:
        reference, inputs: the formula, and what it was given.
        parameters: what `match_parameters` returns for them.
        low, high: (count, components), float32 where the format is one of floats.
        nan: where NaN is legal, (count, components); False where it is nowhere.
        unit: the size of one code for fixed-point formats, None for floats.
        vacuous: how many values have a band that allows anything.
        undecided: how many took both sides of a branch.
    """

    reference: Reference
    inputs: Inputs
    parameters: Mapping[str, list[str]]
    format: str
    low: Array
    high: Array
    nan: Flags | np.bool_ = np.False_
    unit: float | None = None
    vacuous: int = 0
    undecided: int = 0

    @cached_property
    def values(self) -> Array:
        """What the formula gives in float64, as the attachment would hold it, unrounded."""
        values = np.empty(self.low.shape)
        if len(values):
            for rows in chunks(self.inputs, self.parameters, len(values)):
                self.evaluate_exact(rows, values[rows])
        return values

    def values_at(self, rows: Array) -> Array:
        """As `values`, of some rows; where no row depends on another, these alone are evaluated."""
        if PLACE in self.parameters or "values" in self.__dict__:
            return self.values[rows]
        found = np.empty((len(rows), self.low.shape[1]))
        self.evaluate_exact(rows, found)
        return found

    def evaluate_exact(self, rows: slice | Array, into: Array) -> None:
        """Evaluate the formula in float64 for some rows. Raises FormulaError."""
        part = self.inputs.part(rows)
        found = evaluate(
            self.reference, part, rules=None, decimal=False, parameters=self.parameters
        )
        values = np.asarray(found).astype(np.float64, copy=False)
        _require_shape(self.reference, values.shape, into.shape)
        into[:] = to_format(np.broadcast_to(values, into.shape), self.format)

    @cached_property
    def sample(self) -> Array:
        """Some of `values`, at least `SAMPLED` of them from all over, or all if there are fewer."""
        count = len(self.low)
        step = max(count // SAMPLED, 1)
        if step > 1 and PLACE in self.parameters:
            starts = range(0, count, count // 8)
            return np.concatenate([self.values[n : n + SAMPLED // 8] for n in starts])
        if step == 1:
            return self.values
        # An odd step meets all columns of a frame whose width is a power of two.
        return self.values_at(np.arange(0, count, step - (1 - step % 2)))

    @cached_property
    def informative_share(self) -> float:
        """The share of values whose band excludes something plausible (see `Plausible`)."""
        return Plausible.of(self.sample, self.format).informative_share(self.low, self.high)


def reference_band(
    reference: Reference, inputs: Inputs, *, shape: tuple[int, int], rules: Rules, format: str
) -> ReferenceBand:
    """Return the band of a formula, evaluated unless the cache in use has it; `shape` is the count
    and the components of the measured values. For the rest see `judge_band`. Raises FormulaError:
    the formula fails or gives another number of components."""
    parameters = match_parameters(reference, inputs)
    cache = _CACHE.get()
    if cache is None:
        return _evaluate_band(reference, inputs, parameters, shape, rules, format)
    # A band keeps its reference, so that no other object gets its number.
    key = id(reference), rules, format, shape, _digest_inputs(inputs, parameters)
    band = cache.get(key)
    if band is None:
        band = _evaluate_band(reference, inputs, parameters, shape, rules, format)
        cache.keep(key, band)
    return band


def _evaluate_band(
    reference: Reference,
    inputs: Inputs,
    parameters: Mapping[str, list[str]],
    shape: tuple[int, int],
    rules: Rules,
    format: str,
) -> ReferenceBand:
    bounds = np.float32 if format in FLOAT_FORMATS else np.float64
    found = ReferenceBand(
        reference=reference,
        inputs=inputs,
        parameters=parameters,
        format=format,
        low=np.empty(shape, bounds),
        high=np.empty(shape, bounds),
    )
    nan: Flags | np.bool_ = np.False_
    unit, vacuous, undecided = None, 0, 0
    for rows in chunks(inputs, parameters, shape[0]):
        part = found.low[rows].shape
        try:
            band = evaluate(
                reference, inputs.part(rows), rules=rules, decimal=False, parameters=parameters
            )
        except FormulaError:
            found.evaluate_exact(rows, np.empty(part))  # its error is easier to read
            raise
        band = to_result(band, format, rules)
        _require_shape(reference, band.shape, part)
        allowed = store_band(band, format, shape[1])
        unit = None if isinstance(allowed, Band) else float(allowed.unit) or None
        found.low[rows], found.high[rows] = allowed.lo, allowed.hi
        may_be_nan, anything, both = _flags(allowed)
        if np.any(may_be_nan):
            nan = np.zeros(shape, np.bool_) if nan.ndim == 0 else nan
            nan[rows] = may_be_nan  # type: ignore[index]
        vacuous += _count(anything, part)
        undecided += _count(both, part)
    return replace(found, nan=nan, unit=unit, vacuous=vacuous, undecided=undecided)


def chunks(inputs: Inputs, parameters: Collection[str], count: int) -> Iterator[slice]:
    """Slices of `CHUNK` rows; one at least. A formula that takes `frag_coord` may compare a
    pixel with its neighbours: then a slice ends where a row of 2 × 2 pixels does."""
    ends = None
    if PLACE in parameters and PLACE in inputs.each:
        pair = np.floor(inputs.each[PLACE][:, 1] / 2.0)
        ends = np.append(np.flatnonzero(np.diff(pair)) + 1, len(pair))
    start = 0
    while start < max(count, 1):
        stop = start + CHUNK
        if ends is not None and stop < count:
            before = ends[(ends > start) & (ends <= stop)]
            stop = int(before[-1] if before.size else ends[ends > start][0])
        yield slice(start, min(stop, max(count, 1)))
        start = stop


def _require_shape(reference: Reference, given: tuple[int, ...], measured: tuple[int, ...]) -> None:
    rows, components = measured
    got = given[-1] if given else 1
    if got not in (1, components):
        message = f"gives {got} components, the shader's output has {components}"
    elif len(given) > 2 or (len(given) == 2 and given[0] not in (1, rows)):
        message = f"gives shape {given} for {rows} values"
    else:
        return
    remedy = "v.x is one component of a vector, vec4(v, 0.0, 1.0) adds the missing ones"
    raise make_error(reference, f"{name_of(reference)}() {message}", remedy)


def _flags(allowed: Band | Allowed) -> tuple[Flags, Flags, Flags]:
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


def to_result(value: Any, format: str, rules: Rules) -> Band | Integer:
    """What a formula gives, as an attachment of this format takes it: GLSL converts integers to
    floats by itself, and not back."""
    if format in INTEGER_FORMATS:
        whole = Integer(0, unsigned=format.endswith("ui"), rules=rules).lift(value)
        if whole is not None:
            return whole
    return Band.exact(0.0, rules).lift(value)


def store_band(band: Band | Integer, format: str, components: int) -> Band | Allowed:
    """What may come back from an attachment of this format. Raises FormulaError: a formula of
    floats for integers, or the other way round."""
    if format in INTEGER_FORMATS:
        return _store_integers(band, format)
    assert isinstance(band, Band)
    if format in FLOAT_FORMATS:
        return band
    if format.startswith("depth"):
        return band.quantise(format.removesuffix("_stencil8"))
    if format.endswith("16f"):
        return band.quantise("rgba16f")
    if format in _UNORM_FORMATS:
        return band.quantise("rgba8")
    if format != "srgb8_alpha8":
        raise FormulaError(f"no formula can be judged over a {format} attachment")
    color, alpha = band.quantise("srgb8"), band.quantise("rgba8")
    # Alpha is not encoded (OpenGL 4.5, §17.3.7): the last component keeps its own rule.
    is_alpha = np.arange(components) == 3
    names = ("lo", "hi", "nan", "vacuous", "undecided")
    picked = {n: np.where(is_alpha, getattr(alpha, n), getattr(color, n)) for n in names}
    return Allowed(**picked, unit=1.0)


def _store_integers(whole: Band | Integer, format: str) -> Allowed:
    unsigned = format.endswith("ui")
    if not isinstance(whole, Integer) or whole.unsigned != unsigned:
        number, vector = ("uint", "uvec2") if unsigned else ("int", "ivec2")
        raise FormulaError(
            f"gives {whole!r}, the attachment holds {format}",
            remedy=f"use glslmath.{number}(…), or {vector}(…) and its like",
        )
    nowhere = np.zeros(whole.shape, np.bool_)
    anything = np.broadcast_to(whole.anything, whole.shape)
    low, high = whole.lo.astype(np.float64), whole.hi.astype(np.float64)
    return Allowed(low, high, nowhere, anything, nowhere, unit=1.0)


def to_format(values: Array, format: str) -> Array:
    """A float64 reference as it would be read back from `format`, unrounded."""
    if format in _UNORM_FORMATS:
        return np.clip(values, 0.0, 1.0) * 255.0
    if format.startswith("depth"):
        return np.clip(values, 0.0, 1.0)
    if format == "srgb8_alpha8":
        linear = np.clip(values, 0.0, 1.0)
        encoded = srgb_encode(linear)
        encoded[..., 3:] = linear[..., 3:]
        return encoded * 255.0
    return values


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
        """Read it from some values of a reference, (count, components) in float64, in the units of
        the attachment's format."""
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
        """The share of values, (count, components), whose bands are informative: they leave out
        some of what lies between `low` and `high` where the component varies, and elsewhere are
        narrower than `high`; all with two ends."""
        if not low.size:
            return 1.0
        least, greatest = self.low.astype(low.dtype), self.high.astype(low.dtype)
        count = 0
        for start in range(0, len(low), CHUNK):
            lower, upper = low[start : start + CHUNK], high[start : start + CHUNK]
            width = upper - lower
            leaves_out = (lower > least) | (upper < greatest)
            narrow = np.where(self.varies, leaves_out, width < greatest)
            count += int(np.count_nonzero(narrow & (width < np.inf)))
        return count / low.size


class BandCache:
    """Bands by reference and the content of its inputs. The first ones stay; beyond the
    `limit`, in bytes of bounds, further ones are not kept."""

    def __init__(self, limit: int = 1 << 28) -> None:
        self._left = limit
        self._bands: dict[tuple[Any, ...], ReferenceBand] = {}

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """Take bands from here, and keep them here."""
        token = _CACHE.set(self)
        try:
            yield
        finally:
            _CACHE.reset(token)

    def get(self, key: tuple[Any, ...]) -> ReferenceBand | None:
        return self._bands.get(key)

    def keep(self, key: tuple[Any, ...], band: ReferenceBand) -> None:
        size = band.low.nbytes + band.high.nbytes
        if size <= self._left:
            self._left -= size
            self._bands[key] = band


_CACHE: ContextVar[BandCache | None] = ContextVar("band cache", default=None)


def _digest_inputs(inputs: Inputs, parameters: Mapping[str, list[str]]) -> bytes:
    found = hashlib.blake2b(digest_size=16)
    for parameter, names in parameters.items():
        found.update(repr((parameter, names, [n in inputs.arrays for n in names])).encode())
        for name in names:
            texels = inputs.textures.get(name)
            arrays: tuple[Array, ...]
            if texels is None:
                arrays = (inputs.exact[name],)
            else:
                arrays = (texels.values, *texels.smaller)
                known = {n: v for n, v in vars(texels).items() if n not in ("values", "smaller")}
                found.update(repr(known).encode())
            for array in arrays:
                found.update(f"{array.dtype} {array.shape} {name in inputs.each}".encode())
                found.update(np.ascontiguousarray(array).data)
    return found.digest()
