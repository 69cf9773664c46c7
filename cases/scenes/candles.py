"""Seventy-two candles around the posts of a plaza, and their light in float64."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from .plaza import MODEL, STEP

Array = npt.NDArray[Any]

CONSTANT, LINEAR, QUADRATIC = 1.0, 4.0, 700.0
"""How their light fades."""
_HUES = np.array([(4.0, 1.9, 0.5), (3.7, 0.8, 1.4), (0.8, 2.0, 4.0)])


def _lamps() -> tuple[Array, Array]:
    """Where they hang, and their light: eight around each post."""
    turns = math.tau * (np.arange(8) + 0.3) / 8.0
    ring = np.column_stack([0.55 * np.cos(turns), 0.06 + 0.0 * turns, 0.55 * np.sin(turns)])
    posts = [(STEP * i, 0.0, STEP * j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    colors = [_HUES[(k + k // 3) % 3] for k in range(9) for _ in range(8)]
    places = np.concatenate([ring + post for post in posts])
    return np.column_stack([places, np.ones(72)]) @ MODEL.T[:, :3], np.array(colors)


PLACES, COLORS = _lamps()


def sum_of(place: Array, normal: Array, stone: Array, reach: float, count: int = 72) -> Array:
    """The light of the first candles on stones, as far as it reaches; all (…, 3).

    >>> up = np.array([0.0, 1.0, 0.0])
    >>> sum_of(PLACES[0] - 0.1 * up, up, np.ones(3), 1.0, 1).round(6).tolist()
    [0.47619, 0.22619, 0.059524]
    """
    total = np.zeros(3)
    for lamp, color in zip(PLACES[:count], COLORS[:count], strict=True):
        ray = lamp - place
        away = np.linalg.norm(ray, axis=-1, keepdims=True)
        left = 1.0 / (CONSTANT + LINEAR * away + QUADRATIC * away**2)
        cosine = np.maximum((normal * ray).sum(-1, keepdims=True) / away, 0.0)
        total = total + np.where(away < reach, color * left * cosine, 0.0)
    return total * stone
