"""A tiled plaza with nine posts, each with a ball on top: somewhere to put lamps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from shaderlab import Draw, Pass
from shaderlab.assets.meshes import Geometry, joined, moved, plane, sphere
from shaderlab.reference.transforms import scale

from . import lit
from .cameras import camera, turned
from .painted_solids import lathe, painted
from .remembered import remembered

EYE = (4.4, 5.2, 8.6)
CAMERA = camera(EYE, (0.0, 0.5, 0.0), 40.5, far=60.0)
# Not quite evenly scaled, so that the normals have something to get wrong.
MODEL = turned(8.0) @ scale((1.0, 1.1, 1.0))
STEP = 2.2
_TILES = ((0.42, 0.41, 0.40), (0.30, 0.30, 0.31))
_POST = (0.36, 0.34, 0.33)
_BALLS = ((0.85, 0.28, 0.16), (0.86, 0.60, 0.14), (0.20, 0.50, 0.62))


@remembered
def plaza(tiles: int = 12, segments: int = 40) -> Geometry:
    """The plaza around the origin, its floor at y = 0; vertices have a colour, `aColor`.

    Args:
        tiles: how many along each side, of half a step each; even.
        segments: of each ball and post, around.

    >>> sorted(plaza(tiles=2, segments=8)["attributes"])
    ['aColor', 'aNormal', 'aPos']
    """
    parts = []
    side = STEP / 2.0
    for i in range(tiles):
        for j in range(tiles):
            corner = np.eye(4)
            corner[[0, 2], 3] = side * (np.array([i, j]) + 0.5 - tiles / 2.0)
            parts.append(moved(painted(plane(side), _TILES[(i + j) % 2]), corner))
    # A hair above the tiles, so that nowhere both are equally near.
    profile = [(0.30, 0.001), (0.30, 0.10), (0.20, 0.16), (0.16, 0.62), (0.26, 0.68), (0.0, 0.68)]
    for i in range(3):
        for j in range(3):
            at = np.eye(4)
            at[[0, 2], 3] = STEP * (i - 1), STEP * (j - 1)
            parts.append(moved(painted(lathe(profile, segments), _POST), at))
            above = at.copy()
            above[1, 3] = 1.06
            ball = sphere(0.40, segments, segments // 2)
            parts.append(moved(painted(ball, _BALLS[(i + j) % 3]), above))
    return joined(*parts)


def in_light(fragment: str, light: Mapping[str, Any], *, small: bool = False, **state: Any) -> Draw:
    """The plaza under the lamps that these uniforms describe, for the checks as a coarser mesh."""
    geometry = plaza(tiles=6, segments=16) if small else plaza()
    surface = {"viewPos": EYE, "specular": (0.35, 0.33, 0.30), "shininess": 32.0}
    uniforms = {**surface, **light}
    return lit.thing(fragment, geometry, MODEL, CAMERA, uniforms, vertex=lit.PAINTED, **state)


def photographed(
    fragment: str, light: Mapping[str, Any], *, clear: lit.Color, bulbs: Sequence[Draw] = ()
) -> tuple[Pass, ...]:
    """The passes of `lit.photographed` for the plaza under these lamps, after the bulbs."""
    large, small = ((*bulbs, in_light(fragment, light, small=small)) for small in (False, True))
    return lit.photographed(large, small, clear=clear)
