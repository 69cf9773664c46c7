"""A house and a mountain, flat shapes of one colour and one depth each, in windows of 256
pixels: which pixels they cover follows from their corners alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import Draw, Mesh
from shaderlab.glslmath import Value, swizzle, vec4

from .draws import drawn

SIDE = 256
SKY = (0.80, 0.88, 0.94, 1.0)
HOUSE = (((-58, -70), (6, -70), (6, -10), (-26, 24), (-58, -10)),)
MOUNTAIN = (((-120, -70), (60, -70), (-20, 100)), ((-10, -70), (122, -70), (62, 48)))
WHOLE = (((-128, -128), (128, -128), (128, 128), (-128, 128)),)
"""Shapes: the corners of their convex parts, counter-clockwise, in pixels from the middle."""
COLORS = {
    HOUSE: (0.76, 0.25, 0.16, 1.0),
    MOUNTAIN: (0.27, 0.42, 0.50, 1.0),
    WHOLE: SKY,
}
DEPTHS = {HOUSE: -0.5, MOUNTAIN: 0.5, WHOLE: 1.0}
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

    >>> int(covered(HOUSE).sum())
    4928
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

    >>> layers(SKY[:1], (HOUSE, 0.25)).shape
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
