"""A turned vase: its outline is a smooth curve, so its normals are smooth."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.assets.meshes import Geometry

Array = npt.NDArray[Any]

# Radius at evenly spaced places along the outline, from the middle of the foot to the lip.
_RADII = (0.0, 0.34, 0.36, 0.50, 0.64, 0.66, 0.54, 0.34, 0.21, 0.19, 0.24, 0.36)
_HEIGHTS = (0.0, 0.0, 0.06, 0.25, 0.50, 0.78, 1.08, 1.32, 1.50, 1.66, 1.78, 1.86)


def vase(segments: int = 96, rings: int = 64) -> Geometry:
    """A vase around +y, its foot on y = 0, about 1.9 high; open at the top.

    Texture s runs around it, t from the foot to the lip.

    >>> print(f"{vase()['attributes']['aPos'][:, 1].max():.2f}")
    1.86
    """
    knots = np.arange(len(_RADII))
    t = np.linspace(0.0, knots[-1], rings + 1)
    radius, height = _smooth(np.array(_RADII), t), _smooth(np.array(_HEIGHTS), t)
    out, rise = np.gradient(height, t), -np.gradient(radius, t)
    turn = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    around = np.column_stack([np.sin(turn), np.zeros_like(turn), np.cos(turn)])
    upward = np.array([0.0, 1.0, 0.0])
    positions = radius[:, None, None] * around + height[:, None, None] * upward
    normals = out[:, None, None] * around + rise[:, None, None] * upward
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-9)
    row, column = np.mgrid[0:rings, 0:segments]
    a = (row * (segments + 1) + column).ravel()
    b, c, d = a + 1, a + segments + 2, a + segments + 1
    s, level = np.broadcast_arrays(turn / (2.0 * np.pi), (t / t[-1])[:, None])
    return {
        "attributes": {
            "aPos": positions.reshape(-1, 3).astype(np.float32),
            "aNormal": normals.reshape(-1, 3).astype(np.float32),
            "aTexCoords": np.stack([s, level], -1).reshape(-1, 2).astype(np.float32),
        },
        "indices": np.stack([a, b, c, a, c, d], -1).ravel().astype(np.uint32),
    }


def _smooth(values: Array, t: Array) -> Array:
    """A curve through evenly spaced values (E. Catmull, R. Rom, 1974)."""
    padded = np.concatenate([values[:1], values, values[-1:]])
    k = np.minimum(t.astype(int), len(values) - 2)
    f = t - k
    p0, p1, p2, p3 = (padded[k + offset] for offset in range(4))
    curve = 2.0 * p1 + (p2 - p0) * f + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * f**2
    return np.asarray(np.maximum(0.0, 0.5 * (curve + (3.0 * p1 - p0 - 3.0 * p2 + p3) * f**3)))
