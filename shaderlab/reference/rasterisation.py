"""Where pixels lie in a triangle: the shares of its corners.

Source: The OpenGL Graphics System: A Specification (version 4.5 core profile), M. Segal and
K. Akeley, 2017, §14.6.1, "Basic polygon rasterization" (barycentric coordinates as ratios of
areas).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def barycentric(points: Array, corners: Array) -> Array:
    """Each corner's share in points of the plane: the area of the triangle opposite to it, divided
    by the whole. Inside all are between 0 and 1; their sum is 1.

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


def _cross(u: Array, v: Array) -> Array:
    area: Array = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return area
