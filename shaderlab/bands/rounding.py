"""Rounding outward to the float32 grid, ULPs, and the rules of precision.

IEEE 754 (§4.3.2) has rounding directions. NumPy has no switch for them, but its loops follow the
processor's, which C's `fesetround` sets for a thread: so a lower bound is computed rounding down,
an upper one rounding up.
"""

from __future__ import annotations

import ctypes
import platform
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

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

# Times this, what is positive lies beyond all that a float32 may be widened to.
_FAR = 2.0**1000

# C's FE_DOWNWARD and FE_UPWARD; FE_TONEAREST is 0 on both.
_DIRECTIONS = {"aarch64": (0x80_0000, 0x40_0000), "x86_64": (0x400, 0x800)}
_DOWNWARD, _UPWARD = _DIRECTIONS.get(platform.machine(), _DIRECTIONS["x86_64"])
_NEAREST = 0
# The lock of threads is kept: releasing it takes longer than the call.
_set_rounding = ctypes.PyDLL(None).fesetround


def add_outward(a: Ends, b: Ends) -> Ends:
    """The sums of lower and of upper bounds, each rounded outward to float64."""
    try:
        _set_rounding(_DOWNWARD)
        low = a[0] + b[0]
        _set_rounding(_UPWARD)
        high = a[1] + b[1]
        low += 0.0  # a sum of zero is -0 rounding down
    finally:
        _set_rounding(_NEAREST)
    return low, high


def _require_directions() -> None:
    one, little = np.ones(8), np.full(8, 2.0**-80)
    low, high = add_outward((one, one), (-little, little))
    if not (low < one).all() or not (high > one).all():
        raise ImportError("shaderlab.bands cannot set this processor's rounding direction")


_require_directions()


def ulp(x: Float64Array) -> Float64Array:
    """The float32 ULP at `x`; at a power of two the smaller neighbour's.

    >>> [float(u * 2**24) for u in ulp(np.array([1.0, 1.5, 2.0, 3.0]))]
    [1.0, 2.0, 2.0, 4.0]
    """
    return _ulp_of(np.minimum(np.abs(x), LARGEST))


def _ulp_of(size: Float64Array) -> Float64Array:
    """`ulp` of absolute values up to LARGEST."""
    size = np.asarray(np.maximum(size, SMALLEST_DENORMAL))
    # One less than a power of two's bits lies in the octave below: no special case is left.
    bits = size.view(np.int64)
    bits -= 1
    bits &= _EXPONENT_BITS
    size *= 2.0**-23
    step: Float64Array = np.maximum(size, SMALLEST_DENORMAL, out=size)
    return step


@np.errstate(all="ignore")
def round_outward(lo: Float64Array, hi: Float64Array, flush: bool) -> Ends:
    """The largest float32 not above `lo`, the smallest not below `hi`; the same array twice where
    all are float32 themselves and one array was given. With `flush`, bounds that touch denormals
    include zero."""
    try:
        _set_rounding(_DOWNWARD)
        low = lo.astype(np.float32)
        wide = low.astype(np.float64)
        high, exact = low, lo is hi and bool((wide == lo).all())
        if not exact:
            _set_rounding(_UPWARD)
            high = hi.astype(np.float32)
    finally:
        _set_rounding(_NEAREST)
    least = np.minimum.reduce(low, axis=None) if flush and low.size else SMALLEST_NORMAL
    if not least >= SMALLEST_NORMAL:  # NaN too
        denormal = _find_denormals(low, 0)
        if denormal is not None:
            wide, exact = np.where(denormal, 0.0, wide), False
        denormal = None if least >= 0.0 else _find_denormals(high, _SIGN)
        if denormal is not None:
            high, exact = np.where(denormal, np.float32(0.0), high), False
    return wide, wide if exact else high.astype(np.float64)


_SIGN = 0x8000_0000
_DENORMALS = 0x007F_FFFF


def _find_denormals(x: Float32Array, sign: int) -> Flags | None:
    """Where `x` is a denormal of this sign, None for nowhere: its bits count those from 1 on."""
    order = x.view(np.uint32) - np.uint32(sign + 1)
    return order < _DENORMALS if np.minimum.reduce(order, axis=None) < _DENORMALS else None


def _to_single(x: Float64Array, direction: int) -> Float32Array:
    try:
        _set_rounding(direction)
        return x.astype(np.float32)
    finally:
        _set_rounding(_NEAREST)


def round_down(x: Float64Array) -> Float64Array:
    """The largest float32 not above `x`."""
    return _to_single(x, _DOWNWARD).astype(np.float64)


def round_up(x: Float64Array) -> Float64Array:
    """The smallest float32 not below `x`."""
    return _to_single(x, _UPWARD).astype(np.float64)


def is_finite(lo: Float64Array, hi: Float64Array) -> bool:
    """Whether bounds lo ≤ hi are all finite numbers."""
    if not lo.size:
        return True
    # The methods min and max take twice as long for few values.
    least, greatest = np.minimum.reduce(lo, axis=None), np.maximum.reduce(hi, axis=None)
    return bool(least > -np.inf and greatest < np.inf)


def is_power_of_two(x: Float64Array) -> bool:
    """Whether each of `x` is zero or ±2^k, so that multiplying by it rounds nothing."""
    return not (x.view(np.int64) & _FRACTION_BITS).any()


@np.errstate(all="ignore")
def widen_by_ulps(
    lo: Float64Array, hi: Float64Array, ulps_lo: Float64Array | float, ulps_hi: Float64Array | float
) -> Ends:
    """Bounds moved out by some ULP; a bound does not move past zero, and zero stays zero."""
    same = lo is hi and ulps_lo is ulps_hi
    more_lo = out_lo = _error_at(lo, ulps_lo)
    more_hi = out_hi = out_lo if same else _error_at(hi, ulps_hi)
    if lo.size and np.minimum.reduce(lo, axis=None) >= SMALLEST_DENORMAL:
        # All of the below, where everything is far above zero compared with its own error.
        if not same:
            more_lo = out_lo + out_lo
            np.minimum(more_lo, np.maximum(out_lo, out_hi), out=more_lo)
        low, high = lo - more_lo, hi + out_hi
        return np.maximum(low, 0.0, out=low), high
    if not same:
        # An ULP doubles past a power of two: a value above `lo`, just past one, may err further
        # below than `lo` itself.
        most = np.maximum(out_lo, out_hi)
        more_lo = np.minimum(most, out_lo + np.minimum(out_lo, np.maximum(lo, 0.0) * _FAR))
        more_hi = np.minimum(most, out_hi + np.minimum(out_hi, np.minimum(hi, 0.0) * -_FAR))
    # A limit for what may not pass zero, and none for the rest.
    limit_lo, limit_hi = np.minimum(lo, 0.0) * _FAR, np.maximum(hi, 0.0) * _FAR
    return np.maximum(lo - more_lo, limit_lo), np.minimum(hi + more_hi, limit_hi)


def _error_at(x: Float64Array, ulps: Float64Array | float) -> Float64Array:
    size = np.abs(x)
    np.minimum(size, LARGEST, out=size)
    step = _ulp_of(size)
    step *= ulps
    size *= FLOAT64_ERROR
    size += step
    return size


def shortest(value: Any) -> str:
    """The fewest digits that give this float32 back. NumPy's own text of a number depends on a
    setting of the process, which other packages change as they are imported.

    >>> shortest(1.0 / 2.2)
    '0.45454547'
    """
    with np.printoptions(legacy=False):
        return str(np.float32(value))


@dataclass(frozen=True, slots=True)
class Rules:
    """What a conforming device may do to a 32-bit formula: the table of the Vulkan specification,
    "Precision and Operation of SPIR-V Instructions", which agrees with the OpenGL Shading Language
    4.60, section 4.7.1, wherever that one states a bound.

    Args:
        rearrange: the compiler may reassociate, factor and distribute; `False` is GLSL's
            `precise`: the operations as written.
        trig_outside: sine and cosine have no stated bound outside [-π, π]: `"vacuous"` takes
            anything, which is counted, `"scaled"` allows |x|·2^-12 as the Vulkan conformance suite
            does.
        flush: denormals may be flushed to zero.
        ranges: bounds enclose the results of many inputs: what holds at their ends need not hold
            at each of those.

    A fused a·b+c needs no rule: its one rounding lies between the bounds of the two.

    Raises:
        FormulaError: `trig_outside` is unknown.
    """

    rearrange: bool = True
    trig_outside: Literal["vacuous", "scaled"] = "vacuous"
    flush: bool = True
    ranges: bool = False

    def __post_init__(self) -> None:
        choices = ("vacuous", "scaled")
        if self.trig_outside not in choices:
            raise FormulaError(
                f"there are no rules with trig_outside={self.trig_outside!r}",
                remedy=suggest(str(self.trig_outside), choices),
            )
