"""Where arguments are searched: what is sampled, and what counts as simpler."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands.rounding import shortest
from shaderlab.errors import CallError
from shaderlab.model.frame import Array

_NUMBER = re.compile(r"(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_TINY = float(np.finfo(np.float32).tiny)


class Domain(ABC):
    """The values that one argument may have."""

    @abstractmethod
    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        """Random values and special ones; `hints` are numbers that the function is made of.

        Args:
            rng: the only source of chance.
            shape: of the values: the first axis counts samples, the others are those of the type.
            hints: numbers, (n,).
        """

    @abstractmethod
    def simpler(self, value: Any) -> list[Any]:
        """Values of the domain that are simpler than one, the simplest first; for one number, or
        for a whole vector where its numbers depend on each other."""

    by_component = True
    """Whether each number of a vector is a value by itself."""


@dataclass(frozen=True)
class Floats(Domain):
    """float32 values from `low` to `high`, both included; of vectors and matrices, each
    component's."""

    low: float
    high: float

    def __post_init__(self) -> None:
        if not -np.inf < self.low < self.high < np.inf:
            raise CallError(f"floats({self.low}, {self.high}): give two numbers, the lower first")

    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        count = math.prod(shape)
        low, high = np.float32(self.low), np.float32(self.high)
        # One in each of so many equal pieces, so that no piece of a hundredth is left out.
        even = low + (high - low) * (rng.permutation(count) + rng.random(count)) / count
        near = rng.choice(np.array([low, high, 0.0]), count) + rng.choice([-1.0, 1.0], count) * (
            (high - low) * 10.0 ** rng.uniform(-9.0, 0.0, count)
        )
        special = rng.choice(self._special(hints), count)
        kind = rng.random(count)
        found = np.where(kind < 0.5, even, np.where(kind < 0.75, near, special))
        found = np.where((found >= low) & (found <= high), found, even)
        found = np.clip(found.astype(np.float32), low, high).reshape(shape)
        return _with_corners(found, self.low, self.high)

    def _special(self, hints: Array) -> Array:
        plain = np.array([0.0, -0.0, 1.0, 0.5, 2.0, 0.25, 0.1, _TINY, 1e-6, 1e-3, 10.0, 100.0])
        whole = np.arange(math.ceil(max(self.low, -64)), math.floor(min(self.high, 64)) + 1)
        points = np.concatenate([plain, -plain, whole, hints, -hints]).astype(np.float32)
        points = np.concatenate([points, np.array([self.low, self.high], np.float32)])
        around = [np.nextafter(points, np.float32(end)) for end in (-np.inf, np.inf)]
        points = np.concatenate([points, *around])
        inside = (points >= np.float32(self.low)) & (points <= np.float32(self.high))
        special: Array = points[inside & ((points == 0.0) | (np.abs(points) >= _TINY))]
        return special

    def simpler(self, value: Any) -> list[Any]:
        x = float(value)
        found = [0.0, 1.0, -1.0, 0.5, 2.0, self.low, self.high, float(round(x)), float(int(x))]
        found += [float(f"{x:.{digits}g}") for digits in range(1, 9)]
        found += [round(x, digits) for digits in range(1, 7)]
        found += [x / 2.0, x - math.copysign(1.0, x)]
        low, high = float(np.float32(self.low)), float(np.float32(self.high))
        inside = {float(np.float32(v)) for v in found if low <= float(np.float32(v)) <= high}
        return sorted((v for v in inside if weight(v) < weight(x)), key=weight)


@dataclass(frozen=True)
class Ints(Domain):
    """Whole numbers from `low` to `high`, both included."""

    low: int
    high: int

    def __post_init__(self) -> None:
        if self.low > self.high:
            raise CallError(f"ints({self.low}, {self.high}): give two numbers, the lower first")

    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        even = rng.integers(self.low, self.high, shape, endpoint=True)
        points = np.concatenate([[self.low, self.high, 0, 1, -1, 2], np.rint(hints)])
        points = points[(points >= self.low) & (points <= self.high)]
        special = rng.choice(points, shape).astype(np.int64)
        found = np.where(rng.random(shape) < 0.25, special, even)
        return _with_corners(found, self.low, self.high)

    def simpler(self, value: Any) -> list[Any]:
        n = int(value)
        found = {0, 1, -1, 2, self.low, self.high, n // 2, n - 1, n + 1, -n}
        inside = (v for v in found if self.low <= v <= self.high)
        return sorted((v for v in inside if weight(v) < weight(n)), key=weight)


@dataclass(frozen=True)
class OneOf(Domain):
    """Some values, the simplest first."""

    values: Sequence[Any]
    by_component = False

    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        values: Array = np.asarray(self.values)
        return values[rng.integers(0, len(values), shape[0])]

    def simpler(self, value: Any) -> list[Any]:
        values = [np.asarray(v) for v in self.values]
        place = next(n for n, v in enumerate(values) if np.array_equal(v, value))
        return list(values[:place])


@dataclass(frozen=True)
class Directions(Domain):
    """Vectors of length 1."""

    by_component = False

    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        vectors = rng.normal(size=shape)
        axes = np.concatenate([np.eye(shape[-1]), -np.eye(shape[-1])])
        some = rng.random(shape[:-1]) < 0.1
        vectors[some] = axes[rng.integers(0, len(axes), int(some.sum()))]
        length = np.linalg.norm(vectors, axis=-1, keepdims=True)
        return np.asarray(vectors / np.maximum(length, _TINY), np.float32)

    def simpler(self, value: Any) -> list[Any]:
        size = len(value)
        axes = [sign * axis for axis in np.eye(size) for sign in (1.0, -1.0)]
        rounded = [np.round(value, digits) for digits in (0, 1, 2)]
        units = [v / np.linalg.norm(v) for v in rounded if np.linalg.norm(v) > 0.0]
        found = [np.asarray(v, np.float32) for v in (*axes, *units)]
        return [v for v in found if weights(v) < weights(value)]


def _with_corners(values: Array, low: float, high: float) -> Array:
    """The samples, of which the first few are the same simple number in all their components: all
    arguments together, where each has some."""
    corners = np.clip(np.array([0, low, high, 1, -1]), low, high)
    for n in range(min(len(corners), len(values))):
        values[n] = corners[n]
    return values


floats, ints, directions = Floats, Ints, Directions


def bools() -> Domain:
    """False and True."""
    return OneOf([False, True])


def one_of(*values: Any) -> Domain:
    """One of these values, numbers or arrays; the simplest first."""
    return OneOf(values)


def hints_of(code: str) -> Array:
    """The numbers that stand in a piece of GLSL: branches change there."""
    return np.unique(np.array([float(n) for n in _NUMBER.findall(code)], np.float64))


def weight(value: float) -> float:
    """How far a number is from a simple one: 0 for 0, little for few digits."""
    if value == 0:
        return 0.0 if math.copysign(1.0, value) > 0.0 else 0.25
    if not math.isfinite(value):
        return 50.0
    digits, _, exponent = f"{np.float32(value):.9g}".partition("e")
    written = shortest(value).partition("e")[0]
    figures = len(written.strip("-0.").replace(".", ""))
    power = abs(int(exponent)) if exponent else max(len(digits.split(".")[0].strip("-")) - 2, 0)
    return figures + 0.5 * (value < 0) + power + (0.0 if value == 1 else 0.5) + abs(value) * 1e-9


def weights(values: Any) -> float:
    """The weight of all numbers of a value together."""
    return float(sum(weight(float(v)) for v in np.ravel(values)))
