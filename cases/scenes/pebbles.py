"""Pebbles in a tray, seen from straight above: colours, and heights in the fourth channel."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

SIDE = 192
_HUES = (
    (0.80, 0.74, 0.66),
    (0.34, 0.36, 0.40),
    (0.62, 0.30, 0.20),
    (0.72, 0.60, 0.36),
    (0.30, 0.42, 0.40),
    (0.88, 0.86, 0.82),
)


@functools.cache
def pebbles() -> Array:
    """The tray, a unit wide and deep, (192, 192, 4); the larger pebbles are placed first.

    >>> pebbles().shape
    (192, 192, 4)
    """
    random = np.random.default_rng(2)
    y, x = (np.mgrid[0:SIDE, 0:SIDE] + 0.5) / SIDE
    height = np.where(np.maximum(abs(x - 0.5), abs(y - 0.5)) > 0.465, 0.07, 0.0)
    color = np.where(height[..., None] > 0.0, (0.55, 0.33, 0.17), (0.62, 0.55, 0.44))
    placed = np.full((1, 3), -1.0)  # middles and radii
    for size in np.geomspace(0.095, 0.02, 1500):
        at = random.uniform(0.04 + size, 0.96 - size, 2)
        if (np.hypot(*(placed[:, :2] - at).T) < 0.93 * (size + placed[:, 2])).any():
            continue
        placed = np.vstack([placed, (*at, size)])
        dome = 0.75 * np.sqrt(np.maximum(size**2 - (x - at[0]) ** 2 - (y - at[1]) ** 2, 0.0))
        hue = np.array(_HUES[len(placed) % len(_HUES)]) * random.uniform(0.9, 1.1)
        color = np.where((dome > height)[..., None], hue, color)
        height = np.maximum(dome, height)
    return np.concatenate([color, height[..., None]], axis=-1).astype(np.float32)


def pebble_at(at: Array) -> Array:
    """The tray at places, (n, 2), 0…1: filtered linearly in float64, the border repeated, (n, 4).

    >>> pebble_at(np.array([[0.0, 0.5]])).round(2).tolist()
    [[0.55, 0.33, 0.17, 0.07]]
    """
    tray, place = pebbles(), np.clip(at * SIDE - 0.5, 0.0, SIDE - 1.0)
    low = np.minimum(place.astype(int), SIDE - 2)
    i, j = low.T
    x, y = (place - low)[:, :1], (place - low)[:, 1:]
    rows = [tray[j + k, i] * (1.0 - x) + tray[j + k, i + 1] * x for k in (0, 1)]
    return np.asarray(rows[0] * (1.0 - y) + rows[1] * y)


def height_at(at: Array) -> Array:
    """The height there, (n, 1).

    >>> height_at(np.array([[0.0, 0.5]])).round(2).tolist()
    [[0.07]]
    """
    return pebble_at(at)[:, 3:]
