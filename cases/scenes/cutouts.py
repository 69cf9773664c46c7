"""A house before mountains, flat shapes of one colour and one depth each, in windows of 256 pixels:
which pixels they cover follows from their corners alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import Draw, Mesh
from shaderlab.glslmath import Value, swizzle, vec4

from .draws import drawn

SIDE = 256
SKY = (0.80, 0.88, 0.94, 1.0)
# Shapes: the corners of their convex parts, counter-clockwise, in pixels from the middle.
WALL = (((-58, -94), (6, -94), (6, -18), (-58, -18)),)
ROOF = (((-68, -20), (16, -20), (-26, 24)),)
DOOR = (((-34, -94), (-18, -94), (-18, -60), (-34, -60)),)
PANES = (
    ((-50, -58), (-40, -58), (-40, -44), (-50, -44)),
    ((-12, -58), (-2, -58), (-2, -44), (-12, -44)),
)
HOUSE = (*WALL, *ROOF)
FIRS = (
    ((50, -88), (88, -88), (69, -52)),
    ((55, -66), (83, -66), (69, -34)),
    ((88, -80), (116, -80), (102, -52)),
    ((92, -63), (112, -63), (102, -40)),
)
MEADOW = (((-128, -128), (128, -128), (128, -72), (0, -66), (-128, -72)),)
SNOW = (
    ((-34, 70), (-9, 70), (-20, 98)),
    ((-30, 56), (-22, 70), (-34, 70)),
    ((-13, 54), (-9, 70), (-22, 70)),
    ((54, 31), (69, 31), (62, 47)),
)
MOUNTAIN = (((-120, -90), (60, -90), (-20, 100)), ((-10, -90), (122, -90), (62, 48)))
SUN = (((104, 86), (104, 98), (95, 108), (81, 108), (72, 98), (72, 86), (81, 76), (95, 76)),)
WHOLE = (((-128, -128), (128, -128), (128, 128), (-128, 128)),)
LANDSCAPE = (MEADOW, SNOW, MOUNTAIN, SUN)
"""What stands behind the house, the nearest first."""
COLORS = {
    DOOR: (0.36, 0.22, 0.14, 1.0),
    PANES: (0.30, 0.48, 0.62, 1.0),
    ROOF: (0.76, 0.25, 0.16, 1.0),
    WALL: (0.95, 0.90, 0.78, 1.0),
    HOUSE: (0.76, 0.25, 0.16, 1.0),
    FIRS: (0.13, 0.36, 0.26, 1.0),
    MEADOW: (0.52, 0.68, 0.36, 1.0),
    SNOW: (0.97, 0.98, 1.00, 1.0),
    MOUNTAIN: (0.36, 0.50, 0.58, 1.0),
    SUN: (1.00, 0.82, 0.35, 1.0),
    WHOLE: SKY,
}
DEPTHS = {
    DOOR: -0.75, PANES: -0.75, ROOF: -0.625, WALL: -0.5, HOUSE: -0.5, FIRS: -0.25, MEADOW: 0.125,
    SNOW: 0.25, MOUNTAIN: 0.5, SUN: 0.75, WHOLE: 1.0,
}  # fmt: skip
"""In normalised device coordinates."""


def cutout(shape: Any, **state: Any) -> Draw:
    """A shape at its depth; `state` as `drawn` takes it.

    >>> cutout(HOUSE).uniforms["depth"]
    -0.5
    """
    places: list[tuple[int, int, int]] = []
    fans: list[tuple[int, int, int]] = []
    for part in shape:
        fans += [
            (len(places), len(places) + k, len(places) + k + 1) for k in range(1, len(part) - 1)
        ]
        places += [(x, y, 0) for x, y in part]
    mesh = Mesh(attributes={"aPos": np.array(places) / (SIDE / 4)}, indices=np.ravel(fans))
    uniforms = {"size": 0.5, "depth": DEPTHS[shape], "color": COLORS[shape]}
    return drawn("ch08_techniques/framebuffer_renderbuffer", mesh, uniforms, **state)


def covered(shape: Any) -> npt.NDArray[np.bool_]:
    """The pixels of a window whose centres lie in the shape, (SIDE, SIDE). None is on an edge.

    >>> int(covered(DOOR).sum())
    544
    """
    x, y = np.meshgrid(*[np.arange(SIDE) + 0.5 - SIDE / 2] * 2)
    found = np.zeros((SIDE, SIDE), bool)
    for part in shape:
        sides = np.array(
            [
                (c - a) * (y - b) - (d - b) * (x - a)
                for (a, b), (c, d) in zip(part, (*part[1:], part[0]), strict=True)
            ]
        )
        assert np.all(sides != 0.0)
        found |= np.all(sides > 0.0, axis=0)
    return found


def layers(ground: Any, *shapes: tuple[Any, Any]) -> npt.NDArray[np.float32]:
    """A window of one value, and shapes of other values over it in this order.

    >>> layers(SKY[:1], (SUN, 0.25)).shape
    (256, 256, 1)
    """
    found = np.tile(np.float32(ground), (SIDE, SIDE, 1))
    for shape, value in shapes:
        found[covered(shape)] = value
    return found


def placed(aPos: Value, size: Value, depth: Value) -> Value:
    """Scaled across, and put at a depth.

    >>> placed(np.array([2.0, 1.0, 0.0]), 0.5, 0.25).tolist()
    [1.0, 0.5, 0.25, 1.0]
    """
    return vec4(swizzle(aPos, "xy") * size, depth, 1.0)
