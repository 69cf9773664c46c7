"""What a draw's vertices cover, and what is interpolated between them, in double precision: a check
of a driver's rasterisation against its own vertices.

Only what is beyond doubt is said: a pixel's centre within `EDGE` of an edge may be covered or not,
and a triangle that is clipped may cover anything. Source: OpenGL 4.5 core profile specification,
§14.6 (equations 14.9 and 14.10) and §13.6.1 (viewport).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shaderlab.drivers.programs.vertex_capture import corners
from shaderlab.model.frame import Array, Samples
from shaderlab.model.mesh import Mesh
from shaderlab.model.state import State

EDGE = 1 / 16
"""In pixels: drivers keep positions in steps, of 1/16 at most (`GL_SUBPIXEL_BITS`)."""
_TRIANGLES = ("triangles", "triangle_strip", "triangle_fan")


@dataclass(frozen=True, eq=False)
class Covered:
    """What a draw's triangles do at some pixels.

    Attributes:
        inside: beyond doubt inside of a triangle that faces the right way.
        possible: perhaps inside of one.
        triangle: the vertices (3) of the only triangle that a pixel can be of; −1 for none.
        weights: of each pixel, the barycentric coordinates in window space, (count, 3).
        height: the triangle's least height, in pixels.
    """

    inside: Array
    possible: Array
    triangle: Array
    weights: Array
    height: Array


def covered(
    mesh: Mesh, instances: int, given: Samples, state: State, size: tuple[int, int], pixels: Array
) -> Covered | None:
    """What the triangles of a draw cover of pixels (count, 2); None for points and lines.

    Args:
        mesh, instances: what is drawn.
        given: its vertices, as they were captured: each stored one, once an instance.
        state: its viewport, scissor, and which faces are dropped.
        size: (width, height) of the target.
        pixels: columns and rows.
    """
    if mesh.primitive not in _TRIANGLES:
        return None
    one = corners(mesh).astype(np.int64)
    which = np.concatenate([one + n * mesh.vertices for n in range(instances)])
    clip = given.outputs["gl_Position"].astype(np.float64)[which]  # (triangles, 3, 4)
    w = clip[..., 3]
    outside = np.zeros(len(clip), np.bool_)
    crossing = (w <= 0).any(axis=1)
    for axis in range(3):
        for sign in (1.0, -1.0):
            beyond = sign * clip[..., axis] > w
            outside |= beyond.all(axis=1)
            crossing |= beyond.any(axis=1) & (axis == 2)
    with np.errstate(all="ignore"):
        ndc = clip[..., :2] / w[..., None]
    left, bottom, width, height = _viewport(state, size)
    window = (ndc + 1.0) / 2.0 * (width, height) + (left, bottom)
    area = _cross(window[:, 1] - window[:, 0], window[:, 2] - window[:, 0])
    front = area > 0 if state.front_face == "ccw" else area < 0
    dropped = {
        None: np.zeros_like(front), "back": ~front, "front": front,
        "front_and_back": np.ones_like(front),
    }[state.cull]  # fmt: skip
    kept = ~outside & ~dropped | crossing
    distances, least = _distances(window, area, pixels + 0.5)
    certain = ~crossing[:, None] & np.isfinite(distances).all(axis=-1)
    is_inside = kept[:, None] & certain & (distances > EDGE).all(axis=-1)
    maybe = kept[:, None] & (~certain | (distances > -EDGE).all(axis=-1))
    in_view = _within(pixels, state, size, (left, bottom, width, height))
    only = (maybe.sum(axis=0) == 1) & is_inside.any(axis=0)
    of = np.where(only, maybe.argmax(axis=0), 0)
    rows = np.arange(len(pixels))
    with np.errstate(all="ignore"):
        heights = least[of]
        weights = distances[of, rows] * _lengths(window)[of] / np.abs(area[of])[:, None]
    return Covered(
        inside=is_inside.any(axis=0) & in_view,
        possible=maybe.any(axis=0) & in_view,
        triangle=np.where((only & in_view)[:, None], which[of], -1),
        weights=weights,
        height=heights,
    )


def interpolated(
    values: Array, positions: Array, found: Covered, row: int, how: str
) -> tuple[Array, Array]:
    """A vertex output at one pixel, and how far a driver's may be from it; (components).

    Args:
        values: of all vertices, (count, components).
        positions: their clip coordinates.
        found: what is covered there; its triangle is known.
        row: the pixel.
        how: "smooth", "noperspective" or "flat".
    """
    three = values[found.triangle[row]].astype(np.float64)
    if how == "flat":
        return three[2], np.zeros(three.shape[1])
    share = found.weights[row]
    if how == "smooth":
        share = share / positions[found.triangle[row], 3].astype(np.float64)
        share = share / share.sum()
    spread = three.max(axis=0) - three.min(axis=0)
    steepness = np.abs(share / np.maximum(found.weights[row], 1e-9)).max()
    give = spread * steepness * EDGE / max(float(found.height[row]), EDGE)
    return share @ three, give + 2.0**-12 * np.abs(three).max(axis=0)


def _viewport(state: State, size: tuple[int, int]) -> tuple[int, int, int, int]:
    if state.cell is not None:
        return state.cell.rectangle(size)
    return state.viewport or (0, 0, *size)


def _within(pixels: Array, state: State, size: tuple[int, int], view: Sequence[int]) -> Array:
    """Which pixels lie in the viewport, and in the scissor rectangle."""
    inside = np.ones(len(pixels), np.bool_)
    scissor = view if state.cell is not None else state.scissor
    for box in (view, scissor or (0, 0, *size)):
        x, y, width, height = box
        column, row = pixels[:, 0], pixels[:, 1]
        inside &= (column >= x) & (column < x + width) & (row >= y) & (row < y + height)
    return inside


def _distances(window: Array, area: Array, centres: Array) -> tuple[Array, Array]:
    """How far each centre lies inside each edge of each triangle, in pixels, (triangles, centres,
    3), the edge opposite of each corner; and each triangle's least height."""
    start, end = np.roll(window, -1, axis=1), np.roll(window, -2, axis=1)
    lengths = _lengths(window)
    with np.errstate(all="ignore"):
        sign = np.sign(area)[:, None, None]
        offset = centres[None, :, None, :] - start[:, None]
        distances = sign * _cross((end - start)[:, None], offset) / lengths[:, None]
        least = np.abs(area) / lengths.max(axis=1)
    return distances, least


def _lengths(window: Array) -> Array:
    """The length of the edge opposite of each corner."""
    edges = np.roll(window, -2, axis=1) - np.roll(window, -1, axis=1)
    found: Array = np.linalg.norm(edges, axis=-1)
    return found


def _cross(a: Array, b: Array) -> Array:
    found: Array = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return found
