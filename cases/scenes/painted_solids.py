"""Painted solids: every vertex has a colour instead of texture coordinates.

All are right-handed with y up and wind counter-clockwise seen from outside, as in `meshes`.
Attributes are `aPos` (n, 3), `aNormal` (n, 3) of length 1 and `aColor` (n, 3), linear light in
0…1; all float32. `Mesh(**painted(cube(), RED))` draws one.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.assets.meshes import Geometry, cube, joined, make_geometry, moved

Array = npt.NDArray[Any]
Color = Sequence[float]
Vector = Sequence[float] | Array

RED, GREEN, BLUE = (0.72, 0.09, 0.07), (0.10, 0.45, 0.12), (0.06, 0.20, 0.68)
ORANGE, TEAL, GOLD = (0.88, 0.30, 0.05), (0.03, 0.34, 0.40), (0.86, 0.55, 0.08)
INK, PAPER, STONE = (0.05, 0.06, 0.08), (0.86, 0.84, 0.79), (0.50, 0.50, 0.50)


def painted(geometry: Geometry, color: Color) -> Geometry:
    """A mesh in one colour, which replaces its texture coordinates.

    >>> painted(cube(), RED)["attributes"]["aColor"].shape
    (24, 3)
    """
    attributes = {k: geometry["attributes"][k] for k in ("aPos", "aNormal")}
    count = len(attributes["aPos"])
    colors = np.tile(np.asarray(color, np.float32), (count, 1))
    return {"attributes": {**attributes, "aColor": colors}, "indices": geometry["indices"]}


def repainted(solid: Geometry, color: Color, amount: float = 1.0) -> Geometry:
    """A painted solid with its colours blended towards one colour; 1 replaces them."""
    colors = solid["attributes"]["aColor"].astype(float)
    mixed = (1.0 - amount) * colors + amount * np.asarray(color, float)
    return {
        "attributes": {**solid["attributes"], "aColor": mixed.astype(np.float32)},
        "indices": solid["indices"],
    }


def box(low: Vector, high: Vector) -> Geometry:
    """An axis-aligned box between two corners, with texture coordinates.

    >>> box((0, 0, 0), (1, 2, 3))["attributes"]["aPos"].max(axis=0).tolist()
    [1.0, 2.0, 3.0]
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    matrix = np.diag([*(high - low), 1.0])
    matrix[:3, 3] = (low + high) / 2.0
    return moved(cube(), matrix)


def lathe(profile: Sequence[tuple[float, float]], segments: int = 32) -> Geometry:
    """A solid of revolution around y from (radius, height) pairs, from its lowest to its highest.

    Each pair of consecutive points makes a band with a sharp edge to the next one.

    >>> len(lathe([(1.0, 0.0), (1.0, 2.0)], segments=8)["indices"])
    48
    """
    turn = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    sine, cosine = np.sin(turn), np.cos(turn)
    bands = []
    for (r0, y0), (r1, y1) in pairwise(profile):
        slope = np.hypot(r1 - r0, y1 - y0)
        out, rise = (y1 - y0) / slope, (r0 - r1) / slope
        ring = [np.column_stack([r * sine, np.full_like(turn, y), r * cosine])
                for r, y in ((r0, y0), (r1, y1))]  # fmt: skip
        normal = np.column_stack([out * sine, np.full_like(turn, rise), out * cosine])
        k = np.arange(segments)
        a, b, c, d = k, k + 1, k + segments + 2, k + segments + 1
        # At a tip one of a field's two triangles has no area.
        triangles = [(a, b, c if r1 > 0.0 else d)] if r0 > 0.0 else []
        triangles += [(a, c, d)] if r1 > 0.0 else []
        indices = np.concatenate([np.stack(t, -1) for t in triangles]).ravel()
        # Rounded before `make_geometry` normalises them: pictures depend on the last bit.
        normals = np.tile(normal, (2, 1)).astype(np.float32)
        empty = np.zeros((len(normals), 2))
        bands.append(make_geometry(np.concatenate(ring), normals, indices, aTexCoords=empty))
    return joined(*bands)


def arrow(
    direction: Vector, *, color: Color, start: Vector = (0.0, 0.0, 0.0), thickness: float = 0.03
) -> Geometry:
    """An arrow from `start` that is as long as `direction`; `thickness` is the shaft's radius.

    >>> float(arrow((0, 2, 0), color=RED)["attributes"]["aPos"][:, 1].max())
    2.0
    """
    length = float(np.linalg.norm(direction))
    tip = min(7.0 * thickness, 0.5 * length)
    profile = [(0.0, 0.0), (thickness, 0.0), (thickness, length - tip),
               (2.6 * thickness, length - tip), (0.0, length)]  # fmt: skip
    return painted(_along(direction, start, lathe(profile, segments=20)), color)


def wire(corners: Any, color: Color, thickness: float = 0.012) -> Geometry:
    """The twelve edges between a box's eight corners (x fastest, then y, then z), as bars.

    >>> corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    >>> len(wire(corners, INK)["indices"]) // len(rod((0, 0, 0), (1, 0, 0), INK)["indices"])
    12
    """
    corners = np.asarray(corners, float)
    edges = [(k, k | bit) for k in range(8) for bit in (1, 2, 4) if not k & bit]
    return joined(*(rod(corners[a], corners[b], color, thickness) for a, b in edges))


def rod(start: Vector, end: Vector, color: Color, thickness: float = 0.012) -> Geometry:
    """A round bar between two points."""
    direction = np.subtract(end, start).astype(float)
    length = float(np.linalg.norm(direction))
    profile = [(0.0, 0.0), (thickness, 0.0), (thickness, length), (0.0, length)]
    return painted(_along(direction, start, lathe(profile, segments=10)), color)


def _along(direction: Vector, start: Vector, solid: Geometry) -> Geometry:
    """A solid around y, turned so that +y points along `direction`, and moved to `start`."""
    unit = np.asarray(direction, float) / np.linalg.norm(direction)
    helper = np.array([0.0, 0.0, 1.0]) if abs(unit[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    side = np.cross(unit, helper)
    side /= np.linalg.norm(side)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([side, unit, np.cross(side, unit)])
    matrix[:3, 3] = start
    return moved(solid, matrix)
