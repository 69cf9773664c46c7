"""What a render target's format makes of a band: the values that reading it back may give."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from shaderlab.errors import FormulaError, nearest

from .rounding import Flags, Floats, ulp

if TYPE_CHECKING:
    from .band import Band

_HALF_LARGEST = 65504.0
_HALF_SMALLEST_NORMAL = 2.0**-14

Bounds = tuple[Floats, Floats]


def srgb_encode(linear: Floats) -> Floats:
    """The sRGB curve (IEC 61966-2-1; OpenGL 4.6, 17.3.7) of values in [0, 1].

    >>> round(float(srgb_encode(np.array(0.5))), 6)
    0.735357
    """
    curved = 1.055 * np.power(np.maximum(linear, 0.0031308), 1.0 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, curved)


def _codes(lo: Floats, hi: Floats, largest: float, tolerance: float) -> Bounds:
    """The integer codes within `tolerance` of a value in [0, 1]."""
    # A device multiplies by `largest` in float32, which rounds too.
    give = tolerance + largest * 2.0**-24
    low = np.ceil(lo * largest - give)
    high = np.floor(hi * largest + give)
    return np.clip(low, 0.0, largest), np.clip(high, 0.0, largest)


def _unorm8(lo: Floats, hi: Floats, tolerance: float) -> Bounds:
    return _codes(lo, hi, 255.0, tolerance)


def _srgb8(lo: Floats, hi: Floats, tolerance: float) -> Bounds:
    return _codes(srgb_encode(lo), srgb_encode(hi), 255.0, tolerance)


def _depth(lo: Floats, hi: Floats, tolerance: float, largest: float) -> Bounds:
    low, high = _codes(lo, hi, largest, tolerance)
    # Read back as float32, codes are rounded by the division.
    low, high = low / largest * (1.0 - 2.0**-24), high / largest * (1.0 + 2.0**-24)
    return np.maximum(low, 0.0), np.minimum(high, 1.0)


def _half(lo: Floats, hi: Floats, tolerance: float) -> Bounds:
    """The halves next to a value, on either side; beyond 65504 that or infinity."""
    low, high = lo.astype(np.float16), hi.astype(np.float16)
    low = np.where(low > lo, np.nextafter(low, np.float16(-np.inf)), low).astype(np.float64)
    high = np.where(high < hi, np.nextafter(high, np.float16(np.inf)), high).astype(np.float64)
    low = np.where((low > 0.0) & (low < _HALF_SMALLEST_NORMAL), 0.0, low)
    high = np.where((high < 0.0) & (high > -_HALF_SMALLEST_NORMAL), 0.0, high)
    # A shader's own infinity may be stored as the largest half, as anything else too large may.
    return np.minimum(low, _HALF_LARGEST), np.maximum(high, -_HALF_LARGEST)


def _float32(lo: Floats, hi: Floats, tolerance: float) -> Bounds:
    return lo, hi


# Per format: its rule, whether it clamps to [0, 1], its tolerance and code size as read back.
_FORMATS: dict[str, tuple[Callable[[Floats, Floats, float], Bounds], bool, float, float]] = {
    "rgba8": (_unorm8, True, 0.5, 1.0),
    "unorm8": (_unorm8, True, 0.5, 1.0),
    "srgb8": (_srgb8, True, 0.7, 1.0),
    "rgba16f": (_half, False, 0.0, 0.0),
    "rgba32f": (_float32, False, 0.0, 0.0),
    "depth16": (partial(_depth, largest=65535.0), True, 1.0, 1.0 / 65535.0),
    "depth24": (partial(_depth, largest=16777215.0), True, 1.0, 1.0 / 16777215.0),
    "depth32f": (_float32, True, 0.0, 0.0),
}


@np.errstate(all="ignore")
def quantise(band: Band, fmt: str, tolerance: float | None = None) -> Allowed:
    """The interval of values that reading `band` back from a target of format `fmt` may give.

    Args:
        band: what the fragment shader put out.
        fmt: and the units that come back:

            - `"rgba8"`, `"unorm8"`: codes 0…255, of the value clamped to [0, 1], rounded to
              nearest, a tie either way (OpenGL 4.6, 2.3.5.2);
            - `"srgb8"`: codes 0…255 of the sRGB-encoded value;
            - `"rgba16f"`: halves as floats, rounded either way, denormals maybe flushed;
            - `"rgba32f"`: the band itself;
            - `"depth16"`, `"depth24"`: the code over its largest, in [0, 1]; `"depth32f"`:
              clamped to [0, 1].
        tolerance: how many codes a stored code may be away from the value; the default is the
            format's own: 0.5 for `rgba8`; 0.7 for `srgb8` (OpenGL states no bound; the Direct3D
            11.3 functional specification asks for 0.6; Mesa's llvmpipe is off by up to 0.634);
            1 for `depth16` and `depth24`, which may truncate.

    Raises:
        FormulaError: the format is unknown.
    """
    if fmt not in _FORMATS:
        raise FormulaError(
            f"no rule for reading back the format {fmt!r}", remedy=nearest(fmt, _FORMATS)
        )
    rule, clamps, own_tolerance, unit = _FORMATS[fmt]
    lo, hi = band.lo, band.hi
    nan = band.nan
    if clamps:
        # A NaN is stored as any code; it never comes back.
        lo = np.where(nan, 0.0, np.clip(lo, 0.0, 1.0))
        hi = np.where(nan, 1.0, np.clip(hi, 0.0, 1.0))
        nan = np.zeros_like(nan)
    lo, hi = rule(lo, hi, own_tolerance if tolerance is None else tolerance)
    return Allowed(lo, hi, nan, band.vacuous, band.undecided, unit)


# Float64 values that fit into a second-level cache with their bounds.
BLOCK = 16384


class Interval:
    """What bands and what their storage allows have in common: values between two bounds."""

    __slots__ = ()
    lo: Floats
    hi: Floats

    @property
    def shape(self) -> tuple[int, ...]:
        return self.lo.shape

    @property
    def ndim(self) -> int:
        return self.lo.ndim

    def contains(self: Any, measured: ArrayLike) -> Flags:
        """Whether each measured float32 is legal: NaN only where it may be, Inf only at an end."""
        return contains(self.lo, self.hi, self.nan, measured)

    def widths(self: Any, measured: ArrayLike) -> Floats:
        """How far each measured value is from the middle, in half widths: at most 1 inside.

        Where both bounds are equal, half an ULP (or half a code of the format) is the half width
        outside, and the distance inside is 0. A band without an end has no middle: 0 inside,
        1 + the distance in ULP beyond its other end. NaN is 0 where it is legal, else inf.
        """
        return widths(self.lo, self.hi, self.nan, measured, getattr(self, "unit", 0.0))


@dataclass(frozen=True, eq=False)
class Allowed(Interval):
    """The values that reading a format back may give: lo ≤ measured ≤ hi, in the format's units.

    Attributes:
        lo, hi: float64 bounds, both legal.
        nan: where NaN is legal too.
        vacuous: where the rules allowed anything before the format clamped it.
        undecided: where a branch went both ways.
        unit: the size of one code; 0 for float formats.
    """

    lo: Floats
    hi: Floats
    nan: Flags
    vacuous: Flags
    undecided: Flags
    unit: float = 0.0


@np.errstate(invalid="ignore")  # a signalling NaN, read back, is converted like any other
def contains(lo: Any, hi: Any, nan: Any, measured: ArrayLike) -> Flags:
    """Where lo ≤ measured ≤ hi, or measured is NaN and may be.

    Goes through equal shapes in blocks that stay in the processor's cache; only the result has
    full size. Bounds are float64, or float32 where the measured values are.
    """
    values = np.asarray(measured)
    shape = np.broadcast_shapes(lo.shape, hi.shape, values.shape, np.shape(nan))
    inside = np.empty(shape, np.bool_)
    flat = inside.reshape(-1)
    rows = [_flat(array, shape) for array in (values, lo, hi)]
    legal = _flat(np.asarray(nan), shape) if np.any(nan) else None
    size = min(BLOCK, flat.size)
    alike = values.dtype == lo.dtype == hi.dtype
    number, below = np.empty(size), np.empty(size, np.bool_)
    for start in range(0, flat.size, BLOCK):
        block = slice(start, start + BLOCK)
        got, found = rows[0][block], flat[block]
        if not alike:
            got = number[: found.size]
            np.copyto(got, rows[0][block])
        np.greater_equal(got, rows[1][block], out=found)
        found &= np.less_equal(got, rows[2][block], out=below[: got.size])
        if legal is not None:
            found |= np.isnan(got) & legal[block]
    return inside


def _flat(array: Any, shape: tuple[int, ...]) -> Any:
    """The array broadcast to `shape`, as one row; copied only where necessary."""
    return np.broadcast_to(array, shape).reshape(-1)


@np.errstate(all="ignore")
def widths(lo: Floats, hi: Floats, nan: Any, measured: ArrayLike, unit: float = 0.0) -> Floats:
    """How far measured values are from the middle, in half widths (1 = on a bound)."""
    value = np.asarray(measured, dtype=np.float64)
    half = np.asarray((hi - lo) * 0.5)
    result: Floats = np.abs(value - (lo + half)) / half
    odd = ~((half > 0.0) & np.isfinite(half) & ~np.isnan(value))
    if odd.any():
        at = [np.broadcast_to(array, result.shape)[odd] for array in (lo, hi, nan, value)]
        result[odd] = _odd_widths(at[0], at[1], at[2], at[3], unit)
    return result


def _odd_widths(lo: Floats, hi: Floats, nan: Flags, value: Floats, unit: float) -> Floats:
    """`widths` of bands without width or without an end, and of NaN."""
    bounded = np.isfinite(lo) & np.isfinite(hi)
    # A band without width has the last bit (or one code) as its unit outside, and 0 inside.
    smallest = unit or ulp(np.where(bounded, lo, 1.0))
    half = (hi - lo) / 2.0
    scaled = np.where(
        half > 0.0, np.abs(value - (lo + half)) / half, np.abs(value - lo) / smallest * 2.0
    )
    # A band without an end has no middle: 0 inside, beyond the other end 1 + ULP past it.
    overshoot = np.maximum(
        np.where(value < lo, (lo - value) / ulp(np.nan_to_num(lo)), 0.0),
        np.where(value > hi, (value - hi) / ulp(np.nan_to_num(hi)), 0.0),
    )
    unbounded = np.where(overshoot > 0.0, 1.0 + overshoot, 0.0)
    result: Floats = np.where(bounded, scaled, unbounded)
    return np.where(np.isnan(value), np.where(nan, 0.0, np.inf), result)
