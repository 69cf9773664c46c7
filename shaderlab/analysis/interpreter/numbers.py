"""Floats as NumPy arrays of one width: every operation rounds to the nearest number of it.

Functions that GLSL defines by others (`mix`, `normalize`, `smoothstep`, …) are computed by their
expansions, so that each step rounds. What has no expansion here (`inverse`, `determinant`, packing)
is computed in float64 and rounded once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab import glslmath
from shaderlab.bands import Integer
from shaderlab.bands.rounding import shortest

from .arithmetic import Floats


@dataclass(frozen=True)
class Numbers:
    """An `Arithmetic` of NumPy's float16, float32 or float64."""

    dtype: Any
    rules: None = None

    @property
    def name(self) -> str:
        name: str = np.dtype(self.dtype).name
        return name

    def exact(self, values: Any) -> Floats:
        return np.asarray(values, np.float32).astype(self.dtype)

    def literal(self, value: float) -> Floats:
        # The shortest decimal number with this float32 is the one that was written.
        return np.full((1, 1), float(shortest(value)), self.dtype)

    def undefined(self) -> Floats:
        return np.zeros((1, 1), self.dtype)

    def call(self, function: str, *values: Any) -> Any:
        own = _FUNCTIONS.get(function)
        if own is not None and type(values[0]) is not Integer:  # nor are then the others
            found = own(*values)
            if type(found) is np.ndarray and found.dtype.type is self.dtype:
                return found
            return np.asarray(found).astype(self.dtype, copy=False)
        wide = (v.astype(np.float64) if isinstance(v, np.ndarray) else v for v in values)
        return self.rounded(getattr(glslmath, function)(*wide))

    def rounded(self, value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(self.rounded(part) for part in value)
        if isinstance(value, Integer):
            # What is undefined has bounds; a device has one number.
            return Integer(value.lo, unsigned=value.unsigned)
        with np.errstate(all="ignore"):
            return np.asarray(value).astype(self.dtype, copy=False)


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


def _clamp(x: Floats, low: Floats, high: Floats) -> Floats:
    return np.minimum(np.maximum(x, low), high)


def _smoothstep(edge0: Floats, edge1: Floats, x: Floats) -> Floats:
    t = _clamp((x - edge0) / (edge1 - edge0), x.dtype.type(0), x.dtype.type(1))
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
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": np.divide,
    "negate": np.negative,
    "remainder": np.fmod,
    "abs": np.abs,
    "sign": np.sign,
    "floor": np.floor,
    "ceil": np.ceil,
    "trunc": np.trunc,
    "round": np.rint,
    "roundEven": np.rint,
    "fract": lambda x: x - np.floor(x),
    "mod": lambda x, y: x - y * np.floor(x / y),
    "min": np.minimum,
    "max": np.maximum,
    "clamp": _clamp,
    "mix": lambda x, y, a: x * (1 - a) + y * a,
    "step": lambda edge, x: np.where(x < edge, 0, 1),
    "smoothstep": _smoothstep,
    "fma": lambda a, b, c: a * b + c,
    "radians": lambda x: x * x.dtype.type(np.pi / 180),
    "degrees": lambda x: x * x.dtype.type(180 / np.pi),
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": lambda y, x=None: np.arctan(y) if x is None else np.arctan2(y, x),
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "asinh": np.arcsinh,
    "acosh": np.arccosh,
    "atanh": np.arctanh,
    "pow": _pow,
    "exp": np.exp,
    "log": np.log,
    "exp2": np.exp2,
    "log2": np.log2,
    "sqrt": np.sqrt,
    "inversesqrt": lambda x: 1 / np.sqrt(x),
    "dot": _dot,
    "length": _length,
    "distance": lambda a, b: _length(a - b),
    "normalize": lambda v: v / _length(v),
    "cross": _cross,
    "faceforward": lambda n, i, reference: np.where(_dot(reference, i) < 0, n, -n),
    "reflect": lambda i, n: i - 2 * _dot(n, i) * n,
    "refract": _refract,
    "mul": _mul,
    "matmul": _matmul,
    "transpose": lambda m: np.swapaxes(m, -1, -2),
    "outerProduct": lambda column, row: column[..., :, None] * row[..., None, :],
}
