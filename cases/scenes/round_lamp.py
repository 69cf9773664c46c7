"""Four balls above a floor, under a round lamp: what is seen of it, by three ways, in float64.

Sources: R. Fernando, "Percentage-Closer Soft Shadows", SIGGRAPH sketch, 2005; W. Donnelly, A.
Lauritzen, "Variance Shadow Maps", I3D, 2006, equation 5.

Places of the map are 0…1 over the floor from −2 to 2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.glslmath import Value, distance, max, swizzle, vec2, where

Array = npt.NDArray[Any]

BALLS = np.array(
    [
        (-1.05, 0.30, 0.55, 0.30),
        (-0.30, 0.50, -0.35, 0.28),
        (0.42, 0.78, 0.42, 0.26),
        (1.10, 1.05, -0.40, 0.24),
    ]
)
LAMP = 0.075
"""The lamp's radius, as seen from the floor, in the map's coordinates."""
SIDE = 256
"""Texels of a map."""
_TURN = math.pi * (3.0 - math.sqrt(5.0)) * np.arange(32)
_AWAY = np.sqrt((np.arange(32) + 0.5) / 32.0)
POINTS = _AWAY[:, None] * np.column_stack([np.cos(_TURN), np.sin(_TURN)])
"""Points spread evenly in a circle of radius 1."""


def moments(place: Value, balls: Sequence[Value]) -> Value:
    """The height of what the lamp sees straight below, and its square.

    >>> moments(np.array([1.1, -0.4]), BALLS).round(6).tolist()
    [1.05, 1.1025]
    """
    height: Value = 0.0
    for ball in balls:
        under = distance(place, swizzle(ball, "xz")) < swizzle(ball, "w")
        height = max(height, where(under, swizzle(ball, "y"), 0.0))
    return vec2(height, height * height)


def places(size: int) -> Array:
    """The middles of a map's texels, or of a target's pixels, (size², 2).

    >>> places(2)[1].tolist()
    [0.75, 0.25]
    """
    steps = (np.arange(size) + 0.5) / size
    return np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)


def from_means(map: Array, means: Array) -> float:
    """How far a blurred map is from the means of 13 × 13 texels.

    >>> from_means(np.ones((2, 2, 1)), np.full((2, 2, 1), 0.75))
    0.25
    """
    padded = np.pad(map, ((6, 6), (6, 6), (0, 0)), mode="edge")
    for axis in (0, 1):
        padded = np.lib.stride_tricks.sliding_window_view(padded, 13, axis=axis).mean(axis=-1)
    return float(np.abs(padded - means).max())


def rays(at: Array) -> Array:
    """The share of the lamp that is seen from places of the map, (n, 2), by 1500 rays; (n,).

    >>> rays(np.array([[0.01, 0.01]])).tolist()
    [1.0]
    """
    k = np.arange(1500)
    turn, away = k * math.pi * (3.0 - math.sqrt(5.0)), np.sqrt((k + 0.5) / 1500.0)
    lean = 4.0 * LAMP * away[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    hidden = np.zeros((len(at), 1500), bool)
    for x, y, z, radius in BALLS:
        off = (4.0 * at - 2.0 - np.array([x, z]))[:, None] + y * lean
        hidden |= (off**2).sum(axis=-1) < radius**2
    return np.asarray(1.0 - hidden.mean(axis=1))


def by_closer(map: Array, at: Array) -> Array:
    """The share that percentage-closer soft shadows find at places of a map, (n, 1).

    >>> by_closer(np.zeros((SIDE, SIDE, 2)), np.array([[0.5, 0.5]])).tolist()
    [[1.0]]
    """

    def texel(where: Array) -> Array:
        i = np.clip(np.floor(where * len(map)).astype(int), 0, len(map) - 1)
        return np.asarray(map[i[..., 1], i[..., 0], 0])

    found = texel(at[:, None] + LAMP * 1.1 * POINTS)
    count = (found > 0.0).sum(axis=1)
    size = LAMP * found.sum(axis=1) / np.maximum(count, 1)
    free = texel(at[:, None] + size[:, None, None] * POINTS) == 0.0
    return np.asarray(np.where(count, free.mean(axis=1), 1.0))[:, None]


def by_variance(means: Array, at: Array) -> Array:
    """Chebyshev's bound, of means that are filtered linearly, (n, 1).

    >>> by_variance(np.full((SIDE, SIDE, 2), 0.5), np.array([[0.5, 0.5]])).tolist()
    [[0.5]]
    """
    place = np.clip(at * SIDE - 0.5, 0.0, SIDE - 1.001)
    i, j = np.floor(place).astype(int).T
    x, y = (place - np.floor(place)).T[..., None]
    rows = [means[j + k, i] * (1.0 - x) + means[j + k, i + 1] * x for k in (0, 1)]
    mean, square = (rows[0] * (1.0 - y) + rows[1] * y).T
    return np.asarray(np.where(square > 0.0, 1.0 - mean**2 / np.maximum(square, 1e-30), 1.0))[
        :, None
    ]
