"""GLSL's angle, exponential and common functions (GLSL 4.60, 8.1–8.3), component by component.

Each takes Python numbers, float64 arrays or bands, broadcasts them, and returns an array (a NumPy
number for Python numbers), or a band if any argument is one. On plain numbers the results are
IEEE 754's in float64, without warnings; the precision given is that of bands.
"""

from __future__ import annotations

import math

import numpy as np

from shaderlab.bands import Band, TriBool, arithmetic, exact, functions, integer

from .choice import where
from .dispatch import Value, apply, as_number, mark_undefined

__all__ = [
    "abs", "acos", "acosh", "asin", "asinh", "atan", "atanh", "ceil", "clamp", "cos", "cosh",
    "degrees", "exp", "exp2", "floor", "fma", "fract", "inversesqrt", "log", "log2", "max",
    "min", "mix", "mod", "pow", "radians", "round", "roundEven", "sign", "sin", "sinh",
    "smoothstep", "sqrt", "step", "tan", "tanh", "trunc",
]  # fmt: skip

_DEGREE = math.pi / 180.0


def radians(degrees: Value) -> Value:
    """π/180 · degrees: one multiplication.

    >>> float(radians(180.0))
    3.141592653589793
    """
    return as_number(degrees) * _DEGREE


def degrees(radians: Value) -> Value:
    """180/π · radians: one multiplication."""
    return as_number(radians) * (1.0 / _DEGREE)


def sin(angle: Value) -> Value:
    """The sine of radians; 2^-11 absolute within [-π, π], outside as `Rules.trig_outside` says."""
    return apply(np.sin, lambda a: functions.wave(a, np.sin, math.pi / 2), angle)


def cos(angle: Value) -> Value:
    """The cosine of radians; 2^-11 absolute within [-π, π], outside as `Rules.trig_outside`."""
    return apply(np.cos, lambda a: functions.wave(a, np.cos, 0.0), angle)


def tan(angle: Value) -> Value:
    """The tangent of radians: sin / cos, with the errors of both."""
    return apply(np.tan, lambda a: arithmetic.divide(sin(a), cos(a)), angle)


def asin(x: Value) -> Value:
    """The angle in [-π/2, π/2]; undefined for |x| > 1; 2^-11 absolute or 4096 ULP."""
    return apply(np.arcsin, functions.arcsine, x)


def acos(x: Value) -> Value:
    """The angle in [0, π]; undefined for |x| > 1; 2^-11 absolute or 4096 ULP."""
    return apply(np.arccos, functions.arccosine, x)


def atan(y: Value, x: Value = None) -> Value:
    """atan(y_over_x) in [-π/2, π/2], or atan(y, x) in [-π, π], undefined at (0, 0); 4096 ULP."""
    if x is None:
        return apply(np.arctan, functions.arctangent, y)
    return apply(np.arctan2, functions.arctangent2, y, x)


def pow(x: Value, y: Value) -> Value:
    """x to the y, as exp2(y · log2(x)); undefined for x < 0, and for x = 0 with y ≤ 0.

    >>> f"{pow(0.5, 1 / 2.2):.6f}"
    '0.729740'
    """
    return apply(np.power, functions.power, x, y)


def exp(x: Value) -> Value:
    """e to the x; (3 + 2·|x|) ULP."""
    return apply(np.exp, lambda a: functions.exponential(a, np.exp), x)


def exp2(x: Value) -> Value:
    """2 to the x; (3 + 2·|x|) ULP."""
    return apply(np.exp2, lambda a: functions.exponential(a, np.exp2), x)


def log(x: Value) -> Value:
    """The natural logarithm; 2^-21 absolute within [½, 2], 3 ULP outside; undefined for x ≤ 0."""
    return apply(np.log, lambda a: functions.logarithm(a, np.log), x)


def log2(x: Value) -> Value:
    """The logarithm to base 2; 2^-21 absolute within [½, 2], 3 ULP outside; undefined for x ≤ 0."""
    return apply(np.log2, lambda a: functions.logarithm(a, np.log2), x)


def sqrt(x: Value) -> Value:
    """The square root, as 1 / inversesqrt(x); undefined for x < 0."""
    return apply(np.sqrt, functions.sqrt, x)


def inversesqrt(x: Value) -> Value:
    """1 / √x; 2 ULP; undefined for x ≤ 0."""
    return apply(lambda a: 1.0 / np.sqrt(a), functions.inversesqrt, x)


def abs(x: Value) -> Value:
    """|x|; exact."""
    return apply(np.abs, exact.absolute_value, x, on_integers=integer.absolute_value)


def sign(x: Value) -> Value:
    """-1, 0 or 1; exact."""
    return apply(np.sign, lambda a: exact.apply_monotone(a, np.sign), x, on_integers=integer.sign)


def floor(x: Value) -> Value:
    """The integer at or below x; exact."""
    return apply(np.floor, lambda a: exact.apply_monotone(a, np.floor), x)


def ceil(x: Value) -> Value:
    """The integer at or above x; exact."""
    return apply(np.ceil, lambda a: exact.apply_monotone(a, np.ceil), x)


def trunc(x: Value) -> Value:
    """The integer next to x towards zero; exact."""
    return apply(np.trunc, lambda a: exact.apply_monotone(a, np.trunc), x)


def round(x: Value) -> Value:
    """The nearest integer; a half goes either way in a band, to the even one in float64."""
    return apply(np.rint, exact.round_either_way, x)


def roundEven(x: Value) -> Value:
    """The nearest integer, a half to the even one; exact."""
    return apply(np.rint, lambda a: exact.apply_monotone(a, np.rint), x)


def fract(x: Value) -> Value:
    """x - floor(x), in [0, 1]."""

    def on_bands(a: Band) -> Band:
        return clamp(a - floor(a), 0.0, 1.0)  # type: ignore[no-any-return]

    return apply(lambda a: a - np.floor(a), on_bands, x)


def mod(x: Value, y: Value) -> Value:
    """x - y · floor(x / y); undefined where y may be 0.

    >>> float(mod(-1.0, 3.0))
    2.0
    """

    def on_bands(x: Band, y: Band) -> Band:
        result = x - y * floor(x / y)
        return mark_undefined(result, (y.lo <= 0.0) & (y.hi >= 0.0))

    return apply(lambda x, y: x - y * np.floor(x / y), on_bands, x, y)


def min(x: Value, y: Value) -> Value:
    """The smaller; exact. Where one may be NaN, either may come out."""
    return apply(np.minimum, exact.minimum_of, x, y, on_integers=integer.minimum_of)


def max(x: Value, y: Value) -> Value:
    """The larger; exact. Where one may be NaN, either may come out."""
    return apply(np.maximum, exact.maximum_of, x, y, on_integers=integer.maximum_of)


def clamp(x: Value, minimum: Value, maximum: Value) -> Value:
    """min(max(x, minimum), maximum); exact; undefined where minimum may exceed maximum.

    >>> float(clamp(1.5, 0.0, 1.0))
    1.0
    """

    def plain(x: Value, minimum: Value, maximum: Value) -> Value:
        return np.minimum(np.maximum(x, minimum), maximum)

    return apply(plain, exact.clamp, x, minimum, maximum, on_integers=integer.clamp)


def mix(x: Value, y: Value, a: Value) -> Value:
    """x·(1 - a) + y·a, or x + (y - x)·a: bands allow both; y where a boolean `a` holds.

    >>> float(mix(1.0, 3.0, 0.25))
    1.5
    """
    if isinstance(a, TriBool | bool | np.bool_) or getattr(a, "dtype", None) == np.bool_:
        return where(a, y, x)

    def on_bands(x: Band, y: Band, a: Band) -> Band:
        found = exact.union(x * (1.0 - a) + y * a, x + (y - x) * a)
        return functions.cut_to_ends(found, x, y, a)

    return apply(lambda x, y, a: x * (1.0 - a) + y * a, on_bands, x, y, a)


def step(edge: Value, x: Value) -> Value:
    """0 where x < edge, else 1; exact, but undecided where the bands overlap."""
    x, edge = as_number(x), as_number(edge)
    return where(x < edge, 0.0, 1.0)


def smoothstep(edge0: Value, edge1: Value, x: Value) -> Value:
    """t·t·(3 - 2·t) with t = clamp((x - edge0) / (edge1 - edge0), 0, 1); undefined where
    edge0 may not be less than edge1.

    >>> float(smoothstep(0.0, 2.0, 1.0))
    0.5
    """

    def share(edge0: Value, edge1: Value, x: Value) -> Value:
        return clamp((x - edge0) / (edge1 - edge0), 0.0, 1.0)

    def curve(t: Value) -> Value:
        return t * t * (3.0 - 2.0 * t)

    def on_bands(edge0: Band, edge1: Band, x: Band) -> Band:
        t = share(edge0, edge1, x)
        # Of exactly 0 and 1 all products and sums of the curve are exact, in any order.
        ends = (t.lo == t.hi) & ((t.lo == 0.0) | (t.lo == 1.0))
        risen = exact.select(TriBool(ends, ~ends, t.rules), t.without_terms(), curve(t))
        return mark_undefined(risen, edge0.hi >= edge1.lo)

    return apply(lambda *given: curve(share(*given)), on_bands, edge0, edge1, x)


def fma(a: Value, b: Value, c: Value) -> Value:
    """a·b + c, fused or not."""
    return as_number(a) * as_number(b) + as_number(c)


def sinh(x: Value) -> Value:
    """(exp(x) - exp(-x)) · 0.5.

    >>> f"{sinh(1.0):.6f}"
    '1.175201'
    """
    return apply(np.sinh, lambda x: (exp(x) - exp(-x)) * 0.5, x)


def cosh(x: Value) -> Value:
    """(exp(x) + exp(-x)) · 0.5.

    >>> f"{cosh(1.0):.6f}"
    '1.543081'
    """
    return apply(np.cosh, lambda x: (exp(x) + exp(-x)) * 0.5, x)


def tanh(x: Value) -> Value:
    """sinh(x) / cosh(x).

    >>> f"{tanh(1.0):.6f}"
    '0.761594'
    """
    return apply(np.tanh, lambda x: sinh(x) / cosh(x), x)


def asinh(x: Value) -> Value:
    """log(x + √(x·x + 1)); large errors are allowed where x is far below 0.

    >>> f"{asinh(1.0):.6f}"
    '0.881374'
    """
    return apply(np.arcsinh, lambda x: log(x + sqrt(x * x + 1.0)), x)


def acosh(x: Value) -> Value:
    """log(x + √(x·x - 1)); undefined for x < 1.

    >>> f"{acosh(2.0):.6f}"
    '1.316958'
    """

    def on_bands(x: Band) -> Band:
        return mark_undefined(log(x + sqrt(x * x - 1.0)), x.lo < 1.0)

    return apply(np.arccosh, on_bands, x)


def atanh(x: Value) -> Value:
    """log((1 + x) / (1 - x)) · 0.5; undefined for |x| ≥ 1.

    >>> f"{atanh(0.5):.6f}"
    '0.549306'
    """

    def on_bands(x: Band) -> Band:
        found = log((1.0 + x) / (1.0 - x)) * 0.5
        return mark_undefined(found, (x.lo <= -1.0) | (x.hi >= 1.0))

    return apply(np.arctanh, on_bands, x)
