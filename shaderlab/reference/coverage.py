"""Coverage of a pixel by a shape: the area inside, or the samples inside.

Source: "The OpenGL Graphics System: A Specification", version 3.3 core, section 3.3.1 (a sample is
covered if its position lies in the primitive) and 3.6.1 (a point on an edge belongs to one side);
the area is that of the polygon left by I. E. Sutherland, G. W. Hodgman, "Reentrant Polygon
Clipping", Communications of the ACM 17 (1974), the box filter of antialiasing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from shaderlab.glslmath import Value, swizzle, where

Corner = tuple[float, float]


def on_inner_side(place: Value, start: Corner, stop: Corner) -> Value:
    """1 where a place lies to the left of the line from `start` to `stop`, 0 to its right.

    Args:
        place: (…, 2), in pixels.
        start, stop: two points of the line.

    >>> on_inner_side(np.array([[0.25, 0.5], [0.75, 0.5]]), (0.5, 0.0), (0.5, 1.0)).ravel().tolist()
    [1.0, 0.0]
    """
    dx, dy = stop[0] - start[0], stop[1] - start[1]
    side = dx * (swizzle(place, "y") - start[1]) - dy * (swizzle(place, "x") - start[0])
    return where(side > 0.0, 1.0, 0.0)


def area_in_pixel(corners: Sequence[Corner], x: int, y: int) -> float:
    """The area of a convex polygon inside the pixel whose lower left corner is (x, y): 0…1.

    The corners go counter-clockwise, in pixels.

    >>> area_in_pixel([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)], 0, 0)
    0.5
    """
    polygon = [np.asarray(corner, float) for corner in corners]
    for axis, bound, sign in ((0, x, 1.0), (0, x + 1, -1.0), (1, y, 1.0), (1, y + 1, -1.0)):
        clipped: list[npt.NDArray[np.float64]] = []
        for one, other in zip(polygon, [*polygon[1:], *polygon[:1]], strict=True):
            inside, next_inside = (sign * (p[axis] - bound) >= 0.0 for p in (one, other))
            if inside:
                clipped.append(one)
            if inside != next_inside:
                t = (bound - one[axis]) / (other[axis] - one[axis])
                clipped.append(one + t * (other - one))
        polygon = clipped
        if not polygon:
            return 0.0
    xs, ys = np.array(polygon).T
    return float(0.5 * np.abs(xs @ np.roll(ys, -1) - ys @ np.roll(xs, -1)))


def area_coverage(
    shapes: Sequence[Sequence[Corner]], size: tuple[int, int]
) -> npt.NDArray[np.float64]:
    """The covered area of each pixel, for shapes that do not overlap: (height, width).

    >>> area_coverage([[(0.0, 0.0), (1.5, 0.0), (1.5, 1.0), (0.0, 1.0)]], (2, 1)).tolist()
    [[1.0, 0.5]]
    """
    width, height = size
    found = np.zeros((height, width))
    for corners in shapes:
        (left, low), (right, high) = np.min(corners, axis=0), np.max(corners, axis=0)
        for y in range(max(int(low), 0), min(int(np.ceil(high)), height)):
            for x in range(max(int(left), 0), min(int(np.ceil(right)), width)):
                found[y, x] += area_in_pixel(corners, x, y)
    return found
