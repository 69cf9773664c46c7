"""The band: per value, the interval that a conforming device's float32 result may lie in."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from shaderlab.bands.allowed import Allowed, Interval
from shaderlab.bands.compiled import use_bands
from shaderlab.bands.operators import Operators
from shaderlab.bands.rounding import (
    LARGEST,
    Flags,
    Floats,
    enclosed,
    ordinary,
    outward,
)
from shaderlab.bands.swizzles import Swizzled
from shaderlab.bands.terms import Terms
from shaderlab.bands.truth import Truth
from shaderlab.errors import FormulaError

from . import allowed as formats
from .rounding import Rules

_DEFAULT = Rules()
_FLOAT32 = np.dtype(np.float32)
_NO = np.zeros((), dtype=np.bool_)
_NOWHERE = (_NO, _NO, _NO)

Flagged = tuple[Any, Any, Any]
"""Where a value may be NaN, where it may be anything, where it is undecided; 0-d for nowhere."""


class Band(Interval, Operators, Swizzled):
    """An interval for every value of an array, on the float32 grid, rounded outward.

    The last axis is the vector's components, always: a per-pixel float is (N, 1), a uniform
    float (1,), a uniform vec3 (3,), a mat4 (4, 4) with m[row, column]; `v.xyz` are components by
    GLSL's names. Arithmetic with plain
    numbers and arrays takes those as literals of the shader (see `literal`). GLSL's functions are
    in `shaderlab.glslmath`; NumPy's raise `FormulaError`, as do `if band` and `float(band)`.

    Attributes:
        lo, hi: float64 arrays; -inf and inf where the value may be infinite.
        rules: the precision rules. Two bands of different rules don't mix.
        flags: where a value may be NaN, where it may be anything, where a branch that led to it
            took both sides; each is 0-d if it is so nowhere.
        direction: the cached result of `glslmath.normalize`, or None; formulas normalise the same
            few vectors repeatedly.

    >>> x = Band.exact([0.1])
    >>> float((x * 0.5).lo[0]) == float((x * 0.5).hi[0]) == float(np.float32(0.1)) / 2
    True
    >>> third = Band.exact([1.0]) / 3.0
    >>> third.contains(np.float32(1 / 3)), third.contains(np.float32(0.3334))
    (array([ True]), array([False]))
    """

    __slots__ = ("_size", "direction", "flags", "hi", "lo", "rules", "terms")

    def __init__(
        self,
        lo: Floats,
        hi: Floats,
        rules: Rules,
        flags: Flagged = _NOWHERE,
        terms: Terms | None = None,
    ) -> None:
        # `lo is hi` marks exact values, and halves the arithmetic's work.
        self.lo = lo
        self.hi = hi
        self.rules = rules
        self.flags = flags
        self.terms = terms
        self.direction: Band | None = None
        self._size: Floats | None = None

    @classmethod
    def exact(cls, values: ArrayLike, rules: Rules = _DEFAULT) -> Band:
        """The float32 values that the shader got: `values`, rounded to float32 once.

        A denormal includes zero where the rules let it flush; for NaN anything is legal.
        """
        got: Any = values
        if type(got) is not np.ndarray or got.dtype is not _FLOAT32 or not got.ndim:
            with np.errstate(all="ignore"):
                got = np.atleast_1d(np.asarray(values, dtype=np.float32))
        plain = ordinary(got)
        if plain is not None:
            return cls(plain, plain, rules)
        with np.errstate(all="ignore"):
            wide = got.astype(np.float64)
        return cls._leaf(wide, wide, rules)

    @classmethod
    def between(cls, lo: ArrayLike, hi: ArrayLike, rules: Rules = _DEFAULT) -> Band:
        """Any float32 from `lo` to `hi`, both rounded outward.

        Raises:
            FormulaError: where lo > hi.
        """
        low, high = (np.atleast_1d(np.asarray(bound, dtype=np.float64)) for bound in (lo, hi))
        if low.shape != high.shape:
            low, high = np.broadcast_arrays(low, high)
        with np.errstate(all="ignore"):
            inside = enclosed(low, high, rules.flush)
            if inside is not None:
                return cls(*inside, rules)
            if (low > high).any():
                raise FormulaError("a band's lower bound lies above its upper bound")
            return cls._leaf(*outward(low, high, rules.flush), rules)

    @classmethod
    def literal(cls, value: ArrayLike, rules: Rules = _DEFAULT) -> Band:
        """A constant of the shader's source: exact if it is a float32, else both neighbours.

        A Python number that needs more than nine digits, such as 1.0 / 2.2, was computed; the
        shader computes it in float32, so it has 3 ULP on either side.
        """
        plain: Any = value
        if type(plain) is float:
            low, high, unknown = _number(plain, rules.flush)
        else:
            given = np.atleast_1d(np.asarray(value, dtype=np.float64))
            if given.size > 16:
                with np.errstate(all="ignore"):
                    return cls._leaf(*outward(given, given, False), rules)
            first, last, unknown = _literal(given.tobytes(), rules.flush)
            low = first.reshape(given.shape)
            high = low if first is last else last.reshape(given.shape)
        return cls(low, high, rules) if not unknown else cls._leaf(low, high, rules)

    @classmethod
    def _leaf(cls, lo: Floats, hi: Floats, rules: Rules) -> Band:
        unknown = np.isnan(lo) if lo is hi else np.isnan(lo) | np.isnan(hi)
        flags = _NOWHERE
        if unknown.any():
            lo, hi = np.where(unknown, -np.inf, lo), np.where(unknown, np.inf, hi)
            flags = (unknown, unknown, _NO)
        if rules.flush:
            lo, hi = outward(lo, hi, True)
        return cls(lo, hi, rules, flags)

    def made(
        self,
        lo: Floats,
        hi: Floats,
        *others: Band,
        nan: Any = None,
        anything: Any = None,
        terms: Terms | None = None,
    ) -> Band:
        """A result of this band (and others) with real bounds lo, hi: rounded outward, flagged.

        For functions that compute with bands, not for formulas.
        """
        rounded_lo, rounded_hi = outward(lo, hi, self.rules.flush)
        flags = self._flags_with(others)
        if nan is not None and nan.any():
            flags = flags[0] | nan, flags[1], flags[2]
            rounded_lo = np.where(np.isnan(rounded_lo), -np.inf, rounded_lo)
            rounded_hi = np.where(np.isnan(rounded_hi), np.inf, rounded_hi)
        if anything is not None and anything.any():
            flags = flags[0] | anything, flags[1] | anything, flags[2]
            rounded_lo = np.where(anything, -np.inf, rounded_lo)
            rounded_hi = np.where(anything, np.inf, rounded_hi)
        return Band(rounded_lo, rounded_hi, self.rules, flags, terms)

    def kept(self, lo: Floats, hi: Floats, *others: Band, terms: Terms | None = None) -> Band:
        """`made` from bounds that are on the float32 grid: nothing is left to round or flush."""
        return Band(lo, hi, self.rules, self._flags_with(others), terms)

    def _flags_with(self, others: tuple[Band, ...]) -> Flagged:
        """The flags of this band or of others."""
        flags = self.flags
        for other in others:
            a, b = flags, other.flags
            if b is not _NOWHERE and not all(flag is _NO for flag in b):
                flags = a[0] | b[0], a[1] | b[1], a[2] | b[2]
        return flags

    def flags_over_last(self) -> Band:
        """A band that only carries this one's flags, each joined over the last axis."""
        nothing = self.lo[..., 0:1]
        return Band(
            nothing, nothing, self.rules, self._moved_flags(lambda a: a.any(-1, keepdims=True))
        )

    def _moved_flags(self, function: Callable[[Any], Any]) -> Flagged:
        if self.flags is _NOWHERE:
            return _NOWHERE
        nan, anything, undecided = (
            flag if flag.ndim == 0 else function(np.broadcast_to(flag, self.shape))
            for flag in self.flags
        )
        return nan, anything, undecided

    def settled(self) -> tuple[Floats, Floats]:
        """The bounds once a pending slack is paid (see `arithmetic`)."""
        slack = None if self.terms is None else self.terms.slack
        if slack is None:
            return self.lo, self.hi
        return self.lo - slack, self.hi + slack

    def again(self) -> Band:
        """An equal but independent value: the product of the two is no square."""
        return Band(self.lo, self.hi, self.rules, self.flags, self.terms)

    def opaque(self) -> Band:
        """The same values without their terms: nothing distributes over them."""
        return Band(self.lo, self.hi, self.rules, self.flags)

    @property
    def is_plain(self) -> bool:
        """Whether this is no sum, so that there is nothing to rearrange."""
        return self.terms is None

    @property
    def count(self) -> int:
        """How many terms this value may be the sum of, once all is distributed."""
        return 1 if self.terms is None else self.terms.count

    @property
    def mag(self) -> Floats:
        """The sum of the absolute values of the terms that this value is made of."""
        if self.terms is not None:
            return self.terms.mag
        if self._size is None:
            size = np.abs(self.lo)
            if self.lo is not self.hi:
                size = np.maximum(size, np.abs(self.hi))
            self._size = np.minimum(size, LARGEST)
        return self._size

    @property
    def nan(self) -> Flags:
        """Where the value may be NaN."""
        return np.broadcast_to(self.flags[0], self.shape)

    @property
    def may_be_nan(self) -> Flags:
        """`nan`, 0-d for nowhere."""
        found: Flags = self.flags[0]
        return found

    @property
    def undecided(self) -> Flags:
        """Where a branch that led here took both sides."""
        return np.broadcast_to(self.flags[2], self.shape)

    @property
    def vacuous(self) -> Flags:
        """Where anything is legal, here or in something that this value was computed from."""
        everything: Flags = self.flags[1] | ((self.lo == -np.inf) & (self.hi == np.inf))
        return np.broadcast_to(everything, self.shape)

    def __getitem__(self, index: Any) -> Band:
        return self.mapped(lambda array: np.asarray(array[index]))

    def mapped(self, function: Callable[[Any], Any]) -> Band:
        """The same values rearranged by `function`, such as indexing or a transposition."""

        def moved(array: Any) -> Any:
            same = array.shape == shape
            return function(array if same else np.broadcast_to(array, shape))

        shape = self.shape
        lo = moved(self.lo)
        hi = lo if self.lo is self.hi else moved(self.hi)
        terms = None if self.terms is None else self.terms.mapped(moved)
        return Band(lo, hi, self.rules, self._moved_flags(function), terms)

    def quantise(self, fmt: str, *, tolerance: float | None = None) -> Allowed:
        """What reading these values back from a render target of this format may give.

        See `formats.quantise` for the formats, their units and their tolerances.
        """
        return formats.quantise(self, fmt, tolerance)

    def __repr__(self) -> str:
        if self.lo.size <= 4:
            return f"Band({self.lo.tolist()} … {self.hi.tolist()})"
        return f"Band(shape={self.shape})"

    def lift(self, other: Any) -> Band:
        """`other` as a band of this one's rules."""
        if type(other) is Band or isinstance(other, Band):
            if other.rules is not self.rules and other.rules != self.rules:
                raise FormulaError(
                    f"bands of different rules in one formula: {self.rules} and {other.rules}"
                )
            return other
        if isinstance(other, Truth):
            raise FormulaError(
                "a condition is not a number", remedy="choose with glslmath.where(condition, a, b)"
            )
        # Literals and integers know how.
        as_band: Callable[[Rules], Band] | None = getattr(other, "as_band", None)
        return Band.literal(other, self.rules) if as_band is None else as_band(self.rules)


use_bands(Band, Terms, Rules, _NOWHERE)


@lru_cache(maxsize=512)
def _number(value: float, flush: bool) -> tuple[Floats, Floats, bool]:
    """`_literal` of one number."""
    return _literal(np.float64(value).tobytes(), flush)


@lru_cache(maxsize=512)
@np.errstate(all="ignore")
def _literal(data: bytes, flush: bool) -> tuple[Floats, Floats, bool]:
    """The bounds of a few constants, and whether one is NaN; a formula has the same ones for
    every block of pixels, and its shader mostly as well."""
    given = np.frombuffer(data, np.float64)
    low, high = outward(given, given, False)
    if low is not high:
        computed = [float(f"{x:.9g}") != x for x in given.flat]
        if any(computed):
            wide = np.where(np.array(computed) & (low != high), 2.0 * (high - low), 0.0)
            low, high = low - wide, high + wide
    low, high = outward(low, high, flush)
    low.flags.writeable = high.flags.writeable = False
    return low, high, bool(np.isnan(given).any())
