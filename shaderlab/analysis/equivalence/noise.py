"""float64 with a little noise: how far two ways to compute the same may lie apart."""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from shaderlab.model.frame import Array

from ..interpreter import Numbers
from ..interpreter.memory import Flags

_OPERATION = 2.0**-52
_INPUT = 2.0**-24  # a float32 is within half of an ULP of what it stands for, at most
_POOL = 1 << 17
_BEYOND = (1 << 29) - 1  # the bits of a float64 that a float32 has not
_DOUBLE = struct.Struct("<d")

# Functions that round nothing.
_EXACT = frozenset(
    {"negate", "abs", "sign", "floor", "ceil", "trunc", "round", "roundEven", "min", "max",
     "clamp", "step", "transpose"}
)  # fmt: skip


@dataclass(frozen=True)
class Noisy(Numbers):
    """float64 in which every rounding errs by its full size, this way or that.

    All runs are one: the invocations come 1 + `copies` times, one block of `count` after the other.
    The first block is float64 without noise, and each of the others errs in its own way.

    Operations err by 2^-52; numbers that the shader got or whose author wrote more digits than a
    float32 has, by half of a float32 ULP. What needs no rounding has no error: results of as
    many bits as a float32 has, inputs all of whose numbers have few bits.

    GLSL's undefined results are NaN in all blocks: pow of a negative base, what is read before it
    is written.
    """

    dtype: Any = np.float64
    count: int = 1
    copies: int = 0

    def exact(self, values: Any) -> Array:
        found: Array = np.asarray(values, np.float32).astype(np.float64)
        rounded = (found.astype(np.float16) != found).any(axis=-1, keepdims=True)
        return self._shaken(found, np.broadcast_to(rounded, found.shape), _INPUT, "input")

    def literal(self, value: float) -> Array:
        found: Array = super().literal(value)
        return self._shaken(found, found != np.float32(value), _INPUT, f"literal {value!r}")

    def undefined(self) -> Array:
        return np.full((1, 1), np.nan)

    def call(self, function: str, *values: Any) -> Any:
        found = Numbers.call(self, function, *values)
        if function == "pow":
            x, y = values
            found = np.where((x < 0.0) | ((x == 0.0) & (y <= 0.0)), np.nan, found)
        return found if function in _EXACT else self._computed(found, function)

    def rounded(self, value: Any) -> Any:
        return self._computed(super().rounded(value), "rounded")

    def _computed(self, value: Any, salt: str) -> Any:
        if not self.copies or type(value) is not np.ndarray:
            return value
        if len(value) == 1:
            return self._shaken(value, _needs_rounding(value), _OPERATION, salt)
        found, noisy = value.copy(), value[self.count :]
        factors = _factors(noisy.shape, _OPERATION, _place(salt, value.item(0)))
        np.multiply(noisy, factors, out=found[self.count :], where=_needs_rounding(noisy))
        return found

    def _shaken(self, value: Array, rounded: Array, size: float, salt: str) -> Array:
        """The value with an error in each block but the first where it was rounded, from -1 to -.5
        or from .5 to 1 times `size`: none is lucky enough to be right. Errors follow from the
        numbers, so that the same expression of two shaders errs alike. A value with one row gets
        one for each invocation."""
        if not self.copies or not np.logical_or.reduce(rounded, axis=None):
            return value
        block = self.count
        if len(value) == 1:
            block = 1
            value, rounded = (np.repeat(x, 1 + self.copies, axis=0) for x in (value, rounded))
        exact = value[block:]
        factors = _factors(exact.shape, size, _place(salt, value.item(0)))
        found = value.copy()
        np.multiply(exact, factors, out=found[block:], where=rounded[block:])
        return found if block == self.count else np.repeat(found, self.count, axis=0)


def _needs_rounding(values: Array) -> Flags:
    """Where numbers have more bits than a float32."""
    found: Flags = (values.view(np.int64) & _BEYOND) != 0
    return found


def _place(salt: str, number: float) -> int:
    """Where in the pool an operation's errors begin."""
    return zlib.crc32(_DOUBLE.pack(number), _seed(salt)) % _POOL


@cache
def _seed(salt: str) -> int:
    return zlib.crc32(salt.encode())


def _factors(shape: tuple[int, ...], size: float, start: int) -> Array:
    pool, count = _pool(size), math.prod(shape)
    if count > _POOL:
        return np.resize(pool[start:], count).reshape(shape)
    return pool[start : start + count].reshape(shape)


@cache
def _pool(size: float) -> Array:
    generator = np.random.default_rng(20)
    errors = generator.uniform(0.5, 1.0, 2 * _POOL)
    found: Array = 1.0 + size * np.where(generator.random(2 * _POOL) < 0.5, -errors, errors)
    return found
