"""What a render target's format makes of a band: the values that reading it back may give."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from shaderlab.errors import FormulaError, suggest

from .bounds import Allowed, Bounds
from .rounding import Ends, Float64Array

_HALF_LARGEST = 65504.0
_HALF_SMALLEST_NORMAL = 2.0**-14


def srgb_encode(linear: Float64Array) -> Float64Array:
    """The sRGB curve (IEC 61966-2-1; OpenGL 4.6, 17.3.7) of values in [0, 1].

    >>> round(float(srgb_encode(np.array(0.5))), 6)
    0.735357
    """
    curved = 1.055 * np.power(np.maximum(linear, 0.0031308), 1.0 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, curved)


def _codes(lo: Float64Array, hi: Float64Array, largest: float, tolerance: float) -> Ends:
    """The integer codes within `tolerance` of a value in [0, 1]."""
    # A device multiplies by `largest` in float32, which rounds too.
    give = tolerance + largest * 2.0**-24
    low = np.ceil(lo * largest - give)
    high = np.floor(hi * largest + give)
    return np.clip(low, 0.0, largest), np.clip(high, 0.0, largest)


def _unorm8(lo: Float64Array, hi: Float64Array, tolerance: float) -> Ends:
    return _codes(lo, hi, 255.0, tolerance)


def _srgb8(lo: Float64Array, hi: Float64Array, tolerance: float) -> Ends:
    return _codes(srgb_encode(lo), srgb_encode(hi), 255.0, tolerance)


def _depth(lo: Float64Array, hi: Float64Array, tolerance: float, largest: float) -> Ends:
    low, high = _codes(lo, hi, largest, tolerance)
    # Read back as float32, codes are rounded by the division.
    low, high = low / largest * (1.0 - 2.0**-24), high / largest * (1.0 + 2.0**-24)
    return np.maximum(low, 0.0), np.minimum(high, 1.0)


def _half(lo: Float64Array, hi: Float64Array, tolerance: float) -> Ends:
    """The halves next to a value, on either side; beyond 65504 that or infinity."""
    low, high = lo.astype(np.float16), hi.astype(np.float16)
    low = np.where(low > lo, np.nextafter(low, np.float16(-np.inf)), low).astype(np.float64)
    high = np.where(high < hi, np.nextafter(high, np.float16(np.inf)), high).astype(np.float64)
    low = np.where((low > 0.0) & (low < _HALF_SMALLEST_NORMAL), 0.0, low)
    high = np.where((high < 0.0) & (high > -_HALF_SMALLEST_NORMAL), 0.0, high)
    # A shader's own infinity may be stored as the largest half, as anything else too large may.
    return np.minimum(low, _HALF_LARGEST), np.maximum(high, -_HALF_LARGEST)


def _float32(lo: Float64Array, hi: Float64Array, tolerance: float) -> Ends:
    return lo, hi


# Per format: its rule, whether it clamps to [0, 1], its tolerance and code size as read back.
_FORMATS: dict[
    str, tuple[Callable[[Float64Array, Float64Array, float], Ends], bool, float, float]
] = {
    "rgba8": (_unorm8, True, 0.6, 1.0),
    "unorm8": (_unorm8, True, 0.6, 1.0),
    "srgb8": (_srgb8, True, 0.7, 1.0),
    "rgba16f": (_half, False, 0.0, 0.0),
    "rgba32f": (_float32, False, 0.0, 0.0),
    "depth16": (partial(_depth, largest=65535.0), True, 1.0, 1.0 / 65535.0),
    "depth24": (partial(_depth, largest=16777215.0), True, 1.0, 1.0 / 16777215.0),
    "depth32f": (_float32, True, 0.0, 0.0),
}


@np.errstate(all="ignore")
def quantise(band: Bounds, fmt: str, tolerance: float | None = None) -> Allowed:
    """The interval of values that reading `band` back from a target of format `fmt` may give.

    Args:
        band: what the fragment shader put out.
        fmt: and the units that come back:

            - `"rgba8"`, `"unorm8"`: codes 0…255, of the value clamped to [0, 1], rounded to
              either neighbour, rather to the nearest (OpenGL 4.6, 2.3.5.2);
            - `"srgb8"`: codes 0…255 of the sRGB-encoded value;
            - `"rgba16f"`: halves as floats, rounded either way, denormals maybe flushed;
            - `"rgba32f"`: the band itself;
            - `"depth16"`, `"depth24"`: the code over its largest, in [0, 1]; `"depth32f"`:
              clamped to [0, 1].
        tolerance: how many codes a stored code may be away from the value; the default is the
            format's own: 0.6 for `rgba8`, which Direct3D's data conversion rules permit (OpenGL
            states no bound; an NVIDIA H200 is off by up to 0.562); 0.7 for `srgb8` (Direct3D
            permits 0.6; Mesa's llvmpipe is off by up to 0.634);
            1 for `depth16` and `depth24`, which may truncate.

    Raises:
        FormulaError: the format is unknown.
    """
    if fmt not in _FORMATS:
        raise FormulaError(
            f"no rule for reading back the format {fmt!r}", remedy=suggest(fmt, _FORMATS)
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
