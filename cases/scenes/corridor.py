"""A corridor of bricks: high dynamic range needs something near and something far away."""

from __future__ import annotations

import numpy as np

from shaderlab import assets
from shaderlab.assets.meshes import Geometry
from shaderlab.reference.transforms import translate

from .cameras import turned


def corridor() -> Geometry:
    """A corridor along −z, two wide and two high, open towards the viewer.

    >>> corridor()["attributes"]["aPos"].min(axis=0).round(6).tolist()
    [-1.0, -1.0, -7.0]
    """
    walls = []
    for turn in (0.0, 90.0, 180.0, 270.0):
        wall = assets.moved(assets.plane(2.0), np.diag([1.0, 1.0, 7.0, 1.0]))
        wall["attributes"]["aTexCoords"] *= np.array([1, 7], np.float32)
        wall = assets.moved(wall, translate((0.0, -1.0, 0.0)))
        walls.append(assets.moved(wall, turned(turn, (0.0, 0.0, 1.0))))
    return assets.joined(*walls, assets.moved(assets.quad(2.0), translate((0.0, 0.0, -7.0))))
