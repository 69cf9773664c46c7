"""Rounding outward to the float32 grid, ULPs, and the rules of precision.

IEEE 754 (§4.3.2) has rounding directions, which NumPy has no switch for: a bound is the nearest
number or, where that lies past the true one, its neighbour.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from shaderlab.bands.compiled import use_kernel
from shaderlab.errors import FormulaError, suggest

Float64Array = NDArray[np.float64]
Float32Array = NDArray[np.float32]
Flags = NDArray[np.bool_]
Ends = tuple[Float64Array, Float64Array]
"""The lower and the upper bound of each value."""

SMALLEST_NORMAL = 2.0**-126
SMALLEST_DENORMAL = 2.0**-149
LARGEST = (2.0 - 2.0**-23) * 2.0**127

# The largest relative error of one rounding, in either direction. The added 2^-20 of it pays for
# the float64 rounding of the bound itself.
RELATIVE_STEP = 2.0**-23 * (1.0 + 2.0**-20)

# More than float64's own relative error in a quotient, a root or an elementary function.
FLOAT64_ERROR = 2.0**-50

_EXPONENT_BITS = np.int64(0x7FF0_0000_0000_0000)
_FRACTION_BITS = np.int64(0x000F_FFFF_FFFF_FFFF)

# Beyond all that a float32 may be widened to, and a finite float64.
_FAR = 2.0**600


def add_below(a: Float64Array, b: Float64Array) -> Float64Array:
    """The largest float64 not above a + b."""
    total, lost = _two_sum(a, b)
    return np.where(lost < 0.0, np.nextafter(total, -np.inf), total) + 0.0


def add_above(a: Float64Array, b: Float64Array) -> Float64Array:
    """The smallest float64 not below a + b."""
    total, lost = _two_sum(a, b)
    return np.where(lost > 0.0, np.nextafter(total, np.inf), total)


def _two_sum(a: Float64Array, b: Float64Array) -> Ends:
    """a + b rounded to float64, and what the rounding lost (Knuth, TAOCP 2, 4.2.2 theorem B).

    The loss is NaN where the sum or a step towards it overflows.
    """
    total = a + b
    b_part = total - a
    return total, (a - (total - b_part)) + (b - b_part)


def ulp(x: Float64Array) -> Float64Array:
    """The float32 ULP at `x`; at a power of two the smaller neighbour's.

    >>> [float(u * 2**24) for u in ulp(np.array([1.0, 1.5, 2.0, 3.0]))]
    [1.0, 2.0, 2.0, 4.0]
    """
    size = np.asarray(np.abs(x))
    np.maximum(size, SMALLEST_DENORMAL, out=size)
    np.minimum(size, LARGEST, out=size)
    # One less than a power of two's bits lies in the octave below: no special case is left.
    bits = size.view(np.int64)
    bits -= 1
    bits &= _EXPONENT_BITS
    size *= 2.0**-23
    step: Float64Array = np.maximum(size, SMALLEST_DENORMAL, out=size)
    return step


@use_kernel
@np.errstate(all="ignore")
def round_outward(lo: Float64Array, hi: Float64Array, flush: bool) -> Ends:
    """The largest float32 not above `lo`, the smallest not below `hi`; the same array twice where
    all are float32 themselves and one array was given. With `flush`, bounds that touch denormals
    include zero."""
    low = round_down(lo)
    high = low if lo is hi and (low == lo).all() else round_up(hi)
    if flush:
        low_denormal = (low > 0.0) & (low < SMALLEST_NORMAL)
        high_denormal = (high < 0.0) & (high > -SMALLEST_NORMAL)
        if low_denormal.any():
            low = np.where(low_denormal, 0.0, low)
        if high_denormal.any():
            high = np.where(high_denormal, 0.0, high)
    return low, high


def round_down(x: Float64Array) -> Float64Array:
    """The largest float32 not above `x`."""
    single = x.astype(np.float32)
    below = np.where(single > x, np.nextafter(single, np.float32(-np.inf)), single)
    return below.astype(np.float64)


def round_up(x: Float64Array) -> Float64Array:
    """The smallest float32 not below `x`."""
    single = x.astype(np.float32)
    above = np.where(single < x, np.nextafter(single, np.float32(np.inf)), single)
    return above.astype(np.float64)


def is_finite(lo: Float64Array, hi: Float64Array) -> bool:
    """Whether bounds lo ≤ hi are all finite numbers."""
    return not lo.size or bool(lo.min() > -np.inf and hi.max() < np.inf)


def is_power_of_two(x: Float64Array) -> bool:
    """Whether each of `x` is zero or ±2^k, so that multiplying by it rounds nothing."""
    return not (x.view(np.int64) & _FRACTION_BITS).any()


def widen_by_ulps(
    lo: Float64Array, hi: Float64Array, ulps_lo: Float64Array | float, ulps_hi: Float64Array | float
) -> Ends:
    """Bounds moved out by some ULP; a bound does not move past zero, and zero stays zero."""
    out_lo = ulps_lo * ulp(lo) + FLOAT64_ERROR * np.minimum(np.abs(lo), LARGEST)
    out_hi = ulps_hi * ulp(hi) + FLOAT64_ERROR * np.minimum(np.abs(hi), LARGEST)
    # An ULP doubles past a power of two: a value above `lo`, just past one, may err further
    # below than `lo` itself.
    more_lo = np.minimum(np.maximum(out_hi, out_lo), (1.0 + (lo > 0.0)) * out_lo)
    more_hi = np.minimum(np.maximum(out_lo, out_hi), (1.0 + (hi < 0.0)) * out_hi)
    new_lo, new_hi = lo - more_lo, hi + more_hi
    # A limit for what may not pass zero, and none for the rest.
    return np.maximum(new_lo, 0.0 - (lo < 0.0) * _FAR), np.minimum(new_hi, (hi > 0.0) * _FAR)


def shortest(value: Any) -> str:
    """The fewest digits that give this float32 back. NumPy's own text of a number depends on a
    setting of the process, which other packages change as they are imported.

    >>> shortest(1.0 / 2.2)
    '0.45454547'
    """
    with np.printoptions(legacy=False):
        return str(np.float32(value))


Spec = Literal["vulkan", "glsl"]
TrigOutside = Literal["vacuous", "scaled", "error"]


@dataclass(frozen=True, slots=True)
class Rules:
    """What a conforming device may do to a 32-bit formula.

    Args:
        spec: `"vulkan"` is the table of the Vulkan specification, "Precision and Operation of
            SPIR-V Instructions", which agrees with the OpenGL Shading Language 4.60, section
            4.7.1, wherever that one states a bound. `"glsl"` takes the latter alone, which leaves
            the precision of every trigonometric function undefined.
        rearrange: the compiler may reassociate, factor and distribute; `False` is GLSL's
            `precise`: the operations as written.
        trig_outside: sine and cosine have no stated bound outside [-π, π]: `"vacuous"` takes
            anything, which is counted, `"scaled"` allows |x|·2^-12 as the Vulkan conformance suite
            does, `"error"` raises `FormulaError`.
        flush: denormals may be flushed to zero.

    A fused a·b+c needs no rule: its one rounding lies between the bounds of the two.

    Raises:
        FormulaError: `spec` or `trig_outside` is unknown.
    """

    spec: Spec = "vulkan"
    rearrange: bool = True
    trig_outside: TrigOutside = "vacuous"
    flush: bool = True

    def __post_init__(self) -> None:
        for name, choices in (
            ("spec", ("vulkan", "glsl")),
            ("trig_outside", ("vacuous", "scaled", "error")),
        ):
            value = getattr(self, name)
            if value not in choices:
                raise FormulaError(
                    f"there are no rules with {name}={value!r}", remedy=suggest(str(value), choices)
                )
