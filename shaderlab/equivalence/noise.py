"""float64 with a little noise: how far two ways to compute the same may lie apart."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from shaderlab.bands import Integer
from shaderlab.frame import Array
from shaderlab.interpreter import Numbers

_OPERATION = 2.0**-52
_INPUT = 2.0**-24  # a float32 is within half of an ULP of what it stands for, at most
_POOL = 1 << 16

# Functions that round nothing.
_EXACT = frozenset(
    {"negate", "abs", "sign", "floor", "ceil", "trunc", "round", "roundEven", "min", "max",
     "clamp", "step", "transpose"}
)  # fmt: skip


@dataclass(frozen=True)
class Noisy(Numbers):
    """float64 in which every rounding errs by its full size, this way or that, by `seed`.

    Operations err by 2^-52; numbers that the shader got or whose author wrote more digits than a
    float32 has, by half of a float32 ULP. What needs no rounding has no error: results that fit
    into a float32, inputs all of whose numbers have few bits. Seed 0 is float64 without noise.

    GLSL's undefined results are NaN in all of them: pow of a negative base, what is read before
    it is written.
    """

    dtype: Any = np.float64
    seed: int = 0

    def exact(self, values: Any) -> Array:
        found: Array = np.asarray(values, np.float32).astype(np.float64)
        if self.seed:
            with np.errstate(all="ignore"):
                rounded = (found.astype(np.float16) != found).any(axis=-1, keepdims=True)
            found = np.where(rounded, found * (1.0 + _INPUT * self._signs(found, "input")), found)
        return found

    def literal(self, value: float) -> Array:
        found: Array = super().literal(value)
        if self.seed and found[0, 0] != np.float32(value):
            found = found * (1.0 + _INPUT * self._signs(found, f"literal {value!r}"))
        return found

    def undefined(self) -> Array:
        return np.full((1, 1), np.nan)

    def call(self, function: str, *values: Any) -> Any:
        found = super().call(function, *values)
        if function == "pow":
            x, y = values
            found = np.where((x < 0.0) | ((x == 0.0) & (y <= 0.0)), np.nan, found)
        return found if function in _EXACT else self._shaken(found, function)

    def rounded(self, value: Any) -> Any:
        return self._shaken(super().rounded(value), "rounded")

    def _shaken(self, value: Any, salt: str) -> Any:
        if not self.seed or isinstance(value, Integer | tuple):
            return value
        with np.errstate(all="ignore"):
            short = value.astype(np.float32) == value
            return np.where(short, value, value * (1.0 + _OPERATION * self._signs(value, salt)))

    def _signs(self, like: Array, salt: str) -> Array:
        """An error for each number, from -1 to -.5 or from .5 to 1: none is lucky enough to be
        right. They follow from the seed and the numbers, so that the same expression of two
        shaders errs alike."""
        start = zlib.crc32(f"{salt} {self.seed} {float(like.flat[0])!r}".encode()) % _POOL
        pool = _pool()[start:]
        return (pool[: like.size] if like.size <= _POOL else np.resize(pool, like.size)).reshape(
            like.shape
        )


@cache
def _pool() -> Array:
    generator = np.random.default_rng(20)
    size = generator.uniform(0.5, 1.0, 2 * _POOL)
    found: Array = np.where(generator.random(2 * _POOL) < 0.5, -size, size)
    return found
