"""Arithmetics that a program is interpreted in: floats as NumPy arrays of one width, or as bands.

Integers are `shaderlab.bands.Integer` and conditions `shaderlab.bands.TriBool` in all of them.
Floats are shaped (count, components), or (1, components) where all invocations have the same value,
and (count or 1, rows, columns) for matrices.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab import glslmath
from shaderlab.bands import Band, Integer, Rules
from shaderlab.bands.arithmetic import scale
from shaderlab.bands.rounding import is_power_of_two

Floats = Any
"""Values of an arithmetic: it takes + - * / and comparisons, and has a shape."""


EXACT = frozenset(
    {"negate", "abs", "sign", "floor", "ceil", "trunc", "round", "roundEven", "min", "max",
     "clamp", "step", "transpose"}
)  # fmt: skip
"""Functions that round nothing."""


@dataclass(frozen=True)
class Numbers:
    """An `Arithmetic` of NumPy's float16, float32 or float64."""

    dtype: Any
    rules: None = None

    def exact(self, values: Any) -> Floats:
        """The float32 numbers that the shader gets, as this arithmetic has them."""
        return np.asarray(values, np.float32).astype(self.dtype)

    def literal(self, value: float) -> Floats:
        """A number that the author wrote, (1, 1)."""
        return np.full((1, 1), value, self.dtype)

    def undefined(self) -> Floats:
        """A float that nothing was stored to, (1, 1)."""
        return np.zeros((1, 1), self.dtype)

    def call(self, function: str, *values: Any) -> Any:
        """One of GLSL's functions by its name in `shaderlab.glslmath`, or one of `negate`, `add`,
        `subtract`, `multiply`, `divide`, `remainder`; integers as they are."""
        own = _FUNCTIONS.get(function)
        if own is not None and type(values[0]) is not Integer:  # nor are then the others
            found = own(*values)
            if type(found) is np.ndarray and found.dtype.type is self.dtype:
                return found
            return np.asarray(found).astype(self.dtype, copy=False)
        return self.rounded(getattr(glslmath, function)(*values))

    def rounded(self, value: Any) -> Any:
        """What `glslmath` and `sampling` give (float64 arrays or bands), as this arithmetic's."""
        if isinstance(value, tuple):
            return tuple(map(self.rounded, value))
        if isinstance(value, Integer):
            # What is undefined has bounds; a device has one number.
            return Integer(value.lo, unsigned=value.unsigned)
        with np.errstate(all="ignore"):
            return np.asarray(value).astype(self.dtype, copy=False)

    def take_given(self, values: Sequence[Any]) -> Sequence[Any]:
        """What a comparison of these values decides by."""
        return values


FLOAT16 = Numbers(np.float16)
FLOAT32 = Numbers(np.float32)
FLOAT64 = Numbers(np.float64)


def _dot(a: Floats, b: Floats) -> Floats:
    total = a[..., 0:1] * b[..., 0:1]
    for i in range(1, a.shape[-1]):
        total = total + a[..., i : i + 1] * b[..., i : i + 1]
    return total


def _length(v: Floats) -> Floats:
    return np.sqrt(_dot(v, v))


def _smoothstep(edge0: Floats, edge1: Floats, x: Floats) -> Floats:
    t = np.clip((x - edge0) / (edge1 - edge0), x.dtype.type(0), x.dtype.type(1))
    return t * t * (3 - 2 * t)


def _cross(a: Floats, b: Floats) -> Floats:
    yzx, zxy = [1, 2, 0], [2, 0, 1]
    return a[..., yzx] * b[..., zxy] - a[..., zxy] * b[..., yzx]


def _refract(incident: Floats, n: Floats, eta: Floats) -> Floats:
    cos = _dot(n, incident)
    k = 1 - eta * eta * (1 - cos * cos)
    through = eta * incident - (eta * cos + np.sqrt(np.maximum(k, 0))) * n
    return np.where(k < 0, 0, through)


def _mul(m: Floats, v: Floats) -> Floats:
    total = m[..., 0] * v[..., 0:1]
    for j in range(1, m.shape[-1]):
        total = total + m[..., j] * v[..., j : j + 1]
    return total


def _matmul(a: Floats, b: Floats) -> Floats:
    columns = [_mul(a, b[..., j]) for j in range(b.shape[-1])]
    return np.stack(np.broadcast_arrays(*columns), axis=-1)


def _pow(x: Floats, y: Floats) -> Floats:
    # At 16 bits as hardware has it, which shows what mediump loses.
    return np.exp2(y * np.log2(x)) if x.dtype == np.float16 else np.power(x, y)


_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "add": np.add, "subtract": np.subtract, "multiply": np.multiply, "divide": np.divide,
    "negate": np.negative, "remainder": np.fmod, "min": np.minimum, "max": np.maximum,
    "fract": lambda x: x - np.floor(x), "mod": lambda x, y: x - y * np.floor(x / y),
    "mix": lambda x, y, a: x * (1 - a) + y * a, "smoothstep": _smoothstep,
    "fma": lambda a, b, c: a * b + c, "pow": _pow, "inversesqrt": lambda x: 1 / np.sqrt(x),
    "dot": _dot, "length": _length, "distance": lambda a, b: _length(a - b),
    "normalize": lambda v: v / _length(v), "cross": _cross,
    "reflect": lambda i, n: i - 2 * _dot(n, i) * n, "refract": _refract,
    "mul": _mul, "matmul": _matmul,
}  # fmt: skip
"""The instructions that `shaderlab.glslmath` lacks, and functions of several operations, each of
which rounds; other functions are those of `glslmath`, in float64, rounded once."""


@dataclass(frozen=True)
class Bands:
    """The `Arithmetic` of `shaderlab.bands`, under some precision rules."""

    rules: Rules = field(default_factory=Rules)

    def exact(self, values: Any) -> Floats:
        return Band.exact(values, self.rules)

    def literal(self, value: float) -> Floats:
        """The hull of the decimal number's neighbours, as in a reference."""
        return Band.literal(np.full((1, 1), value), self.rules)

    def undefined(self) -> Floats:
        return Band.exact(np.full((1, 1), np.nan), self.rules)

    def call(self, function: str, *values: Any) -> Any:
        own = _OPERATORS.get(function)
        return getattr(glslmath, function)(*values) if own is None else own(*values)

    def rounded(self, value: Any) -> Any:
        return value


Arithmetic = Numbers | Bands
"""A way to compute with floats. Its methods are those of `Numbers`."""


def _add(a: Any, b: Any) -> Any:
    """a + b. Nothing is added to the zero that a loop's sum begins with."""
    if len(a.lo) == 1 and a.terms is None and b.shape[-1] == a.shape[-1]:
        return a + b if a.lo.any() or a.hi.any() else b
    return a + b


def _multiply(a: Any, b: Any) -> Any:
    """a · b. Times 0 or a power of two, as `step` gives them, nothing is rounded."""
    for factor, other in ((a, b), (b, a)):
        exact = factor.lo is factor.hi and factor.terms is None and factor.lo.size
        # The first value of most inputs shows already that they are no powers of two.
        if exact and is_power_of_two(factor.lo.flat[0]) and is_power_of_two(factor.lo):
            return scale(other, factor)
    return a * b


_OPERATORS: Mapping[str, Callable[..., Any]] = {
    "add": _add, "subtract": operator.sub, "multiply": _multiply, "divide": operator.truediv,
    "negate": operator.neg, "remainder": lambda a, b: a - b * glslmath.trunc(a / b),
}  # fmt: skip
