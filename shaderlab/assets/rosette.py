"""Seven vertices in six colours around a white one: 84 bytes of positions, 84 of colours."""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.model import Mesh

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
