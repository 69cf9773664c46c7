"""Normals made visible: a thin rod on the surface for each of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.assets.meshes import Geometry, cube

Array = npt.NDArray[Any]


def rods(
    model: Array,
    direction: Callable[[Array], Array],
    *,
    length: float = 0.4,
    rows: int = 7,
    columns: int = 16,
    thickness: float = 0.02,
) -> Geometry:
    """Rods on the image of the unit ball under `model`, one for each of a net of its normals.

    Args:
        model: 4 × 4, takes the ball's points to where the rods begin.
        direction: takes a normal of the ball, (3,), to where its rod points, of any length.
        length, thickness: of each rod.
        rows, columns: rods from pole to pole, and around.

    >>> len(rods(np.eye(4), lambda normal: normal, rows=2, columns=4)["indices"]) // 36
    8
    """
    latitude = (np.arange(rows) + 0.5) / rows * np.pi - np.pi / 2.0
    longitude = (np.arange(columns) + 0.5) / columns * 2.0 * np.pi
    flat, around = np.cos(latitude)[:, None], longitude[None, :]
    height = np.broadcast_to(np.sin(latitude)[:, None], (rows, columns))
    ball = np.stack([flat * np.sin(around), height, flat * np.cos(around)], -1).reshape(-1, 3)
    model = np.asarray(model, float)
    feet = ball @ model[:3, :3].T + model[:3, 3]
    up = np.array([direction(normal) for normal in ball], float)
    return _rods(feet, up / np.linalg.norm(up, axis=1, keepdims=True), length, thickness)


def _rods(feet: Array, up: Array, length: float, thickness: float) -> Geometry:
    """Square bars that stand on `feet` and point `up`, both (n, 3)."""
    helper = np.eye(3)[np.argmin(np.abs(up), axis=1)]
    side = np.cross(up, helper)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    frames = np.stack([side, up, np.cross(side, up)], axis=-1)
    bar = cube()
    corners = bar["attributes"]["aPos"] * np.array([thickness, length, thickness])
    corners[:, 1] += 0.5 * length
    count = len(corners)

    def turned(vectors: Array) -> Array:
        return np.asarray(np.einsum("nij,kj->nki", frames, vectors.astype(float)))

    indices = bar["indices"][None, :] + count * np.arange(len(feet))[:, None]
    return {
        "attributes": {
            "aPos": (turned(corners) + feet[:, None]).reshape(-1, 3).astype(np.float32),
            "aNormal": turned(bar["attributes"]["aNormal"]).reshape(-1, 3).astype(np.float32),
            "aTexCoords": np.tile(bar["attributes"]["aTexCoords"], (len(feet), 1)),
        },
        "indices": indices.ravel().astype(np.uint32),
    }
