"""Rasterisation: barycentric coordinates, and the number of samples that pass the depth test.

Source: The OpenGL Graphics System: A Specification (version 4.5 core profile), M. Segal and
K. Akeley, 2017, §14.6.1, "Basic polygon rasterization" (barycentric coordinates as ratios of
areas; a fragment for each pixel whose centre lies inside), §14.6 (SUBPIXEL_BITS ≥ 4) and §17.3.4
(depth test, here LESS).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def barycentric(points: Array, corners: Array) -> Array:
    """Barycentric coordinates of points in the plane: for each corner the area of the triangle
    opposite to it, divided by the whole. Inside all lie between 0 and 1; their sum is 1.

    Args:
        points: (…, 2).
        corners: (3, 2), in the same units.

    Returns:
        (…, 3).

    >>> corners = np.array([(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)])
    >>> barycentric(np.array([1.0, 1.0]), corners).tolist()
    [0.5, 0.25, 0.25]
    """
    a, b, c = np.asarray(corners, float)
    whole = _cross(b - a, c - a)
    return np.stack(
        [
            _cross(c - b, points - b) / whole,
            _cross(a - c, points - c) / whole,
            _cross(b - a, points - a) / whole,
        ],
        axis=-1,
    )


# Corners are rounded to sixteenths of a pixel or finer: an edge moves by at most 0.045 pixels.
# One of these steps away from a pixel's centre moves farther across an edge of any direction.
_NUDGES = np.array([(2.0, 1.0), (-1.0, 2.0), (-2.0, -1.0), (1.0, -2.0)]) / 32.0


def samples_passed(draws: Sequence[Array], size: tuple[int, int]) -> tuple[tuple[int, int], ...]:
    """The number of samples of each draw that pass the depth test LESS, in drawing order.

    Triangles are rasterised one by one: a pixel where two of a draw's triangles pass in turn counts
    twice. Drivers round the corners, so a pixel whose centre lies on an edge may pass or not; hence
    a least and a greatest number.

    Args:
        draws: (triangles, 3 corners, 4), clip coordinates, all before the eye.
        size: of the target, width and height in pixels.

    Returns:
        For each draw the least and the greatest number.

    >>> square = np.array([(-0.5, -0.5, 0, 1), (0.5, -0.5, 0, 1), (0.5, 0.5, 0, 1)])
    >>> samples_passed([square[None]], (16, 16))
    ((28, 36),)
    """
    width, height = size
    depth = np.ones((len(_NUDGES), height, width))
    counts = []
    for triangles in draws:
        passed = np.zeros(depth.shape, int)
        for corners in np.asarray(triangles, float):
            device = corners[:, :3] / corners[:, 3:]
            window = (0.5 + 0.5 * device[:, :2]) * size
            low = np.clip(np.floor(window.min(axis=0) - 0.5).astype(int), 0, size)
            high = np.clip(np.ceil(window.max(axis=0) + 0.5).astype(int), 0, size)
            here = (slice(None), slice(low[1], high[1]), slice(low[0], high[0]))
            _draw_triangle(window, 0.5 + 0.5 * device[:, 2], low, depth[here], passed[here])
        counts.append((int(passed.min(axis=0).sum()), int(passed.max(axis=0).sum())))
    return tuple(counts)


def _draw_triangle(window: Array, z: Array, low: Array, depth: Array, passed: Array) -> None:
    """Draw into the parts of `depth` and `passed` that begin at pixel `low`."""
    if not depth.size or not _cross(window[1] - window[0], window[2] - window[0]):
        return
    _, height, width = depth.shape
    y, x = np.mgrid[0:height, 0:width] + 0.5
    points = np.stack([x, y], axis=-1) + low + _NUDGES[:, None, None, :]
    shares = barycentric(points, window)
    new = shares @ z
    passes = (shares >= 0.0).all(axis=-1) & (new < depth)
    depth[passes] = new[passes]
    passed[passes] += 1


def _cross(u: Array, v: Array) -> Array:
    area: Array = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return area
