"""Seven vertices in six colours around a white one: 84 bytes of positions, 84 of colours.

Source: The OpenGL Graphics System: A Specification (version 4.5 core profile), M. Segal and
K. Akeley, 2017, §8.3.8 and §17.3.7 for colours that are linear in light; the square root stands
for the display's curve, a gamma of 2.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab import Mesh
from shaderlab.glslmath import Value, sqrt, vec4

RIM = ((1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), (1, 0, 1))


def rosette(**memory: Any) -> Mesh:
    """A hexagon of six triangles around its centre, in device coordinates.

    Args:
        memory: how it lies in memory: `layout`, `usage` and `upload` of a Mesh.

    >>> rosette(layout="batched").placements()["aColor"].offset
    84
    """
    # Close to a regular hexagon; in a window of 128 pixels all corners lie between pixels.
    half = np.array([(52, 30, 0), (0, 60, 0), (-52, 30, 0)])
    rim = np.vstack([half, -half])
    corners = np.arange(6)
    fan = np.column_stack([np.zeros(6, int), corners + 1, (corners + 1) % 6 + 1])
    return Mesh(
        attributes={
            "aPos": np.vstack([np.zeros(3), rim / 64.0]),
            "aColor": np.vstack([np.ones(3), np.array(RIM, float)]),
        },
        indices=fan.ravel(),
        **memory,
    )


def as_it_is(aPos: Value) -> Value:
    """A vertex in device coordinates as clip coordinates.

    >>> as_it_is((0.5, 0.25, 0.0)).tolist()
    [0.5, 0.25, 0.0, 1.0]
    """
    return vec4(aPos, 1.0)


def color_of(aColor: Value) -> Value:
    """A vertex's colour, handed on.

    >>> color_of(0.5)
    0.5
    """
    return aColor


def encoded(ourColor: Value) -> Value:
    """Interpolated light, (…, 3) in 0…1, as the display's numbers, (…, 4).

    >>> encoded((0.25, 1.0, 0.0)).tolist()
    [0.5, 1.0, 0.0, 1.0]
    """
    return vec4(sqrt(ourColor), 1.0)
