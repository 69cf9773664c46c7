"""Two walls close to each other, an orange one right behind a teal one: which of them is seen?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from shaderlab import Cell, Draw, Mesh

from .draws import tested

FAR, MIDDLE, SLANT = 100.0, 10.0, 1.0
ORANGE, TEAL = (0.95, 0.55, 0.12), (0.10, 0.45, 0.50)


def two_walls(
    near: float,
    gaps: Sequence[float],
    edges: Sequence[float],
    offset: tuple[float, float] | None = None,
    rise: float = 0.0,
    half: float = 1.0,
    cell: Cell | None = None,
) -> Iterator[Draw]:
    """The wall behind, number 2, then the wall in front, number 1, which lacks what lies between
    the first two edges.

    Both are cut at the same places, so that their corners differ in depth alone.

    Args:
        near: the near plane.
        gaps: the distances of the walls, in strips one above the other.
        edges: where the walls are cut, from left to right, in device coordinates.
        offset: polygon offset of the wall in front.
        rise: how much the walls slant upward.
        half: how far they reach to above and below.
        cell: the part of the target to draw into.

    >>> [draw.uniforms["number"] for draw in two_walls(0.1, [0.5], (-1.0, -0.9, 1.0))]
    [2.0, 1.0]
    """
    walls = (
        (strips(gaps, edges, half), ORANGE, 2.0, None),
        (strips([0.0] * len(gaps), edges[1:], half), TEAL, 1.0, offset),
    )
    place = {"near": near, "far": FAR, "middle": MIDDLE, "slant": SLANT, "rise": rise}
    for mesh, color, number, moved in walls:
        uniforms = {**place, "color": color, "number": number}
        yield tested("ch06_tests/z_fighting", mesh, uniforms, polygon_offset=moved, cell=cell)


def strips(gaps: Sequence[float], edges: Sequence[float], half: float) -> Mesh:
    """One strip above the other for each gap, side by side between the edges, from −half to half.

    >>> strips([0.0, 1.0], (-1.0, 0.0, 1.0), 1.0).vertices
    16
    """
    rows = np.linspace(-half, half, len(gaps) + 1)
    corners, distances = [], []
    for k, gap in enumerate(gaps):
        for left, right in pairwise(edges):
            low, high = rows[k], rows[k + 1]
            corners += [(left, low), (right, low), (right, high), (left, high)]
            distances += [gap] * 4
    quads = 4 * np.arange(len(corners) // 4)[:, None] + [0, 1, 2, 0, 2, 3]
    attributes = {"aPos": np.array(corners), "aGap": np.array(distances)[:, None]}
    return Mesh(attributes=attributes, indices=quads.ravel())
