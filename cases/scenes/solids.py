"""Distances to solids, as lib/solids.glsl has them, and how far a ray goes by them.

Sources: J. C. Hart, "Sphere Tracing", The Visual Computer 12(10), 1996 (distances bound steps); I.
Quilez, "Distance functions" and "Smooth minimum", iquilezles.org, 2008 and 2013.

Places are (…, 3), distances (…, 1).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.glslmath import Value, abs, length, max, min, swizzle, vec2


def to_sphere(place: Value, radius: float) -> Value:
    """To a ball about the origin.

    >>> to_sphere(np.array([0.0, 3.0, 4.0]), 1.0).tolist()
    [4.0]
    """
    return length(place) - radius


def to_torus(place: Value, radius: float, tube: float) -> Value:
    """To a ring about y.

    >>> to_torus(np.array([3.0, 1.0, 0.0]), 3.0, 0.25).tolist()
    [0.75]
    """
    aside = length(swizzle(place, "xz")) - radius
    return length(vec2(aside, swizzle(place, "y"))) - tube


def to_box(place: Value, halves: Any, rounding: float) -> Value:
    """To a box about the origin with round edges.

    >>> to_box(np.array([3.0, 0.0, 0.0]), (1.0, 1.0, 1.0), 0.1).round(6).tolist()
    [2.0]
    """
    off = abs(place) - np.asarray(halves) + rounding
    x, y, z = (swizzle(off, axis) for axis in "xyz")
    return length(max(off, 0.0)) + min(max(x, max(y, z)), 0.0) - rounding


def melted(one: Value, other: Value, width: float) -> Value:
    """The smaller of two distances, blended where they are about the same.

    >>> melted(1.0, 1.0, 0.5).item()
    0.875
    """
    near = max(width - abs(one - other), 0.0) / width
    return min(one, other) - 0.25 * width * (near * near)


def to_scene(place: Value) -> Value:
    """To a floor with a drop above a ring, a ball and a block.

    >>> to_scene(np.array([0.0, 1.74, 0.0])).round(6).tolist()
    [0.5]
    """
    ring = to_torus(place - np.array([0.0, 0.24, 0.0]), 0.85, 0.24)
    drop = melted(ring, to_sphere(place - np.array([0.0, 0.72, 0.0]), 0.52), 0.5)
    ball = to_sphere(place - np.array([-1.75, 0.5, 0.3]), 0.5)
    block = to_box(place - np.array([1.75, 0.55, -0.1]), (0.45, 0.55, 0.45), 0.12)
    return min(swizzle(place, "y"), min(drop, min(ball, block)))
