"""Rasterisation: barycentric coordinates, and the samples that pass the depth test.

Source: The OpenGL Graphics System: A Specification (version 4.5 core profile), M. Segal and
K. Akeley, 2017, §14.6.1, "Basic polygon rasterization" (barycentric coordinates as ratios of
areas; a fragment for each pixel whose centre lies inside), §14.6 (SUBPIXEL_BITS ≥ 4) and §17.3.4
(depth test, here LESS).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def barycentric(points: Array, corners: Array) -> Array:
    """Barycentric coordinates of points in the plane: for each corner the area of the triangle
    opposite to it, divided by the whole. Inside all lie between 0 and 1; their sum is 1.

    Takes points (…, 2) and corners (3, 2), in the same units; returns (…, 3).

    >>> corners = np.array([(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)])
    >>> barycentric(np.array([1.0, 1.0]), corners).tolist()
    [0.5, 0.25, 0.25]
    """
    a, b, c = np.asarray(corners, float)
    whole = _cross(b - a, c - a)
    parts = [_cross(c - b, points - b), _cross(a - c, points - c), _cross(b - a, points - a)]
    return np.stack(parts, axis=-1) / whole


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

    Returns for each draw the least and the greatest number.

    >>> square = np.array([(-0.5, -0.5, 0, 1), (0.5, -0.5, 0, 1), (0.5, 0.5, 0, 1)])
    >>> samples_passed([square[None]], (16, 16))
    ((28, 36),)
    """
    counts = [np.zeros((len(_NUDGES), *size[::-1]), int) for _ in draws]
    for number, here, passes in _passing(draws, size):
        counts[number][here] += passes
    return tuple(_least_and_greatest(count) for count in counts)


def samples_seen(draws: Sequence[Array], size: tuple[int, int]) -> tuple[tuple[int, int], ...]:
    """The number of samples of each draw that nothing hides in the end, under the depth test LESS.

    Args, and what is returned: as of `samples_passed`.

    >>> far = np.array([(-0.5, -0.5, 0.5, 1), (0.5, -0.5, 0.5, 1), (0.5, 0.5, 0.5, 1)])
    >>> samples_seen([far[None], far[None] - (0, 0, 0.1, 0)], (16, 16))
    ((0, 0), (28, 36))
    """
    owner = np.full((len(_NUDGES), *size[::-1]), -1)
    for number, here, passes in _passing(draws, size):
        owner[here][passes] = number
    return tuple(_least_and_greatest(owner == number) for number in range(len(draws)))


def _least_and_greatest(counts: Array) -> tuple[int, int]:
    return int(counts.min(axis=0).sum()), int(counts.max(axis=0).sum())


def _passing(
    draws: Sequence[Array], size: tuple[int, int]
) -> Iterator[tuple[int, tuple[slice, ...], Array]]:
    """The triangles in drawing order: of which draw, and which samples of what part, by nudge."""
    depth = np.ones((len(_NUDGES), *size[::-1]))
    right, up = (_NUDGES[:, axis, None] + np.arange(size[axis]) + 0.5 for axis in (0, 1))
    for number, triangles in enumerate(draws):
        corners = np.asarray(triangles, float).reshape(-1, 3, 4)
        device = corners[..., :3] / corners[..., 3:]
        windows, depths = (0.5 + 0.5 * device[..., :2]) * size, 0.5 + 0.5 * device[..., 2]
        areas = _cross(windows[:, 1] - windows[:, 0], windows[:, 2] - windows[:, 0])
        reach = 0.5 + np.abs(_NUDGES).max()
        lows = np.clip(np.ceil(windows.min(axis=1) - reach), 0, size).astype(int)
        highs = np.clip(np.floor(windows.max(axis=1) + reach), 0, size).astype(int)
        for index in np.flatnonzero((areas != 0.0) & (lows < highs).all(axis=1)):
            (left, low), (end, high) = lows[index].tolist(), highs[index].tolist()
            here = (slice(None), slice(low, high), slice(left, end))
            x, y = right[:, None, left:end], up[:, low:high, None]
            a, b, c = windows[index].tolist()
            # As `barycentric`, of points that share rows and columns.
            shares = [
                ((v[0] - u[0]) * (y - u[1]) - (v[1] - u[1]) * (x - u[0])) / areas[index]
                for u, v in ((b, c), (c, a), (a, b))
            ]
            first, second, third = shares
            of_a, of_b, of_c = depths[index].tolist()
            z = first * of_a + second * of_b + third * of_c
            passes = (first >= 0.0) & (second >= 0.0) & (third >= 0.0) & (z < depth[here])
            depth[here][passes] = z[passes]
            yield number, here, passes


def _cross(u: Array, v: Array) -> Array:
    area: Array = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return area
