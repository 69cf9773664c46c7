"""Painted props for scenes that show a transform: axes, a letter, an aircraft, a floor, a track.

Vertices have a colour, `aColor`, as all solids of `painted_solids` have.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.assets.meshes import Geometry, joined, moved, sphere, torus
from shaderlab.reference.euler import gimbal_axes
from shaderlab.reference.transforms import rotate, translate

from .cameras import turned
from .painted_solids import (
    BLUE,
    GOLD,
    GREEN,
    INK,
    ORANGE,
    PAPER,
    RED,
    STONE,
    TEAL,
    Color,
    arrow,
    box,
    lathe,
    painted,
    rod,
    wire,
)
from .remembered import remembered

Vector = npt.NDArray[Any]


@remembered
def tripod(size: float = 1.0, thickness: float = 0.03) -> Geometry:
    """The axes: x red, y green, z blue, from the origin."""
    hub = painted(box((-thickness,) * 3, (thickness,) * 3), INK)
    axes = [arrow(size * np.eye(3)[k], color=c, thickness=thickness)
            for k, c in enumerate((RED, GREEN, BLUE))]  # fmt: skip
    return joined(hub, *axes)


@remembered
def letter_f(front: Color = ORANGE, side: Color = TEAL) -> Geometry:
    """A thick letter F, one unit high, its lower left corner near the origin, its front at +z.

    No turn makes it its own mirror image: front and sides differ in colour.
    """
    depth = 0.12
    bars = (
        box((0.0, 0.0, -depth), (0.22, 1.0, depth)),
        box((0.22, 0.78, -depth), (0.70, 1.0, depth)),
        box((0.22, 0.40, -depth), (0.56, 0.60, depth)),
    )
    whole = painted(joined(*bars), side)
    faces_us = whole["attributes"]["aNormal"][:, 2] > 0.5
    whole["attributes"]["aColor"][faces_us] = front
    return whole


@remembered
def aircraft(body: Color = PAPER, wings: Color = ORANGE) -> Geometry:
    """A small aircraft around the origin: its nose at −z, its fin up +y, its span along x."""
    quarter = np.linspace(0.0, 1.0, 9)
    outline = [(float(0.13 * np.sin(np.pi * s) ** 0.6), float(2.0 * s - 1.0)) for s in quarter]
    outline[0], outline[-1] = (0.0, -1.0), (0.0, 1.0)
    nose_first = np.eye(4)
    nose_first[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    fuselage = moved(lathe(outline, segments=24), nose_first)
    wing = box((-0.95, -0.03, -0.28), (0.95, 0.02, 0.16))
    tail = box((-0.36, 0.0, 0.66), (0.36, 0.04, 0.92))
    fin = box((-0.025, 0.03, 0.60), (0.025, 0.44, 0.92))
    port = box((-0.98, -0.05, -0.30), (-0.86, 0.04, 0.18))
    starboard = box((0.86, -0.05, -0.30), (0.98, 0.04, 0.18))
    return joined(
        painted(fuselage, body), painted(wing, wings), painted(tail, wings), painted(fin, wings),
        painted(port, RED), painted(starboard, GREEN),
    )  # fmt: skip


@remembered
def tile(half: float = 2.0, step: float = 0.5, thickness: float = 0.06) -> Geometry:
    """A square slab of floor whose top is y = 0, inlaid with a grid `step` apart.

    The line under the x axis is red, the one under the z axis blue, as maps have their meridians.
    """
    slab = painted(box((-half, -thickness, -half), (half, 0.0, half)), PAPER)
    parts = [slab]
    count = round(half / step)
    for k in range(-count, count + 1):
        at, main = k * step, k == 0
        width = 0.018 if main else 0.009
        top = 0.004 if main else 0.002
        along_x = box((-half, 0.0, at - width), (half, top, at + width))
        along_z = box((at - width, 0.0, -half), (at + width, top, half))
        parts.append(painted(along_x, RED if main else (0.55, 0.56, 0.56)))
        parts.append(painted(along_z, BLUE if main else (0.55, 0.56, 0.56)))
    return joined(*parts)


def railway(length: float = 30.0) -> Geometry:
    """A straight track that runs from z = 0 towards −z, with posts of one height beside it.

    The rails lie at x = ±0.7, the posts stand three units apart at x = ±1.9 and are 1.8 high.
    """
    ground = painted(box((-3.2, -0.3, -length), (3.2, -0.06, 0.0)), (0.42, 0.47, 0.36))
    parts = [ground]
    for x in (-0.7, 0.7):
        parts.append(painted(box((x - 0.06, 0.02, -length), (x + 0.06, 0.14, 0.0)), STONE))
    for k in range(int(length)):
        z = -0.5 - k
        parts.append(
            painted(box((-1.1, -0.06, z - 0.14), (1.1, 0.02, z + 0.14)), (0.30, 0.17, 0.09))
        )
    for k in range(int(length / 3.0)):
        z = -1.5 - 3.0 * k
        for x, color in ((-1.9, RED), (1.9, BLUE)):
            parts.append(
                painted(box((x - 0.13, -0.06, z - 0.13), (x + 0.13, 1.8, z + 0.13)), PAPER)
            )
            parts.append(painted(box((x - 0.17, 1.8, z - 0.17), (x + 0.17, 2.05, z + 0.17)), color))
    return joined(*parts)


@remembered
def letter_among_solids() -> Geometry:
    """The letter F on a tile, with a ball, a ring and a box around it: no two sides look alike."""
    ball = painted(sphere(0.32, 32, 16), GOLD)
    ring = painted(torus(0.3, 0.1, 40, 16), BLUE)
    cube = painted(box((-0.2, 0.0, -0.2), (0.2, 0.4, 0.2)), RED)
    return joined(
        tile(1.5, 0.5),
        moved(letter_f(), translate((-0.35, 0.0, 0.0))),
        moved(ball, translate((0.85, 0.32, -0.5))),
        moved(ring, translate((0.7, 0.1, 0.75))),
        moved(cube, translate((-0.9, 0.0, -0.7)) @ turned(30.0)),
    )


def dice() -> Geometry:
    """Four dice in a row along −z, gold the nearest, then orange, teal and ink."""
    return joined(
        *(
            painted(box((0.46, 0.0, z - 0.13), (0.72, 0.26, z + 0.13)), color)
            for k, color in enumerate((GOLD, ORANGE, TEAL, INK))
            for z in [-0.42 * (k + 1)]
        )
    )


def gimbal(yaw: float, pitch: float) -> Geometry:
    """Three rings that carry each other, each around the axis that its angle turns around: green
    for yaw, red for pitch, blue for roll; the angles are in radians."""
    outer = rotate(yaw, (0, 1, 0))
    inner = outer @ rotate(pitch, (1, 0, 0))
    turns = (outer, outer @ rotate(-pi / 2, (0, 0, 1)), inner @ rotate(pi / 2, (1, 0, 0)))
    rings, pins = [], []
    sizes = ((1.42, GREEN), (1.30, RED), (1.18, BLUE))
    for (radius, color), turn, axis in zip(sizes, turns, gimbal_axes(yaw, pitch), strict=True):
        rings.append(moved(painted(torus(radius, 0.022, segments=72, sides=10), color), turn))
        pins.append(rod(-1.62 * axis, 1.62 * axis, color, 0.016))
    return joined(*rings, *pins)


def way(places: Sequence[Vector], colors: Sequence[Color]) -> Geometry:
    """Rods from place to place, each with a knot at its end; a step that leads nowhere has its knot
    alone.

    Args:
        places: one more than there are steps.
        colors: of the steps.
    """
    parts = []
    for (here, there), color in zip(pairwise(places), colors, strict=True):
        if np.linalg.norm(there - here) > 0.0:
            parts.append(rod(here, there, color, 0.05))
        parts.append(painted(box(there - 0.10, there + 0.10), color))
    return joined(*parts)


def frustum(clip: npt.NDArray[Any], color: Color, thickness: float = 0.012) -> Geometry:
    """The edges of what a camera sees: the box from −1 to 1, before the matrix `clip`.

    >>> frustum(np.eye(4), INK)["attributes"]["aPos"].max().round(1).item()
    1.0
    """
    corners = [(x, y, z, 1.0) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    seen = (np.linalg.inv(clip) @ np.array(corners).T).T
    return wire(seen[:, :3] / seen[:, 3:], color, thickness)
