"""Cameras as the uniforms that shaders read, and turns in degrees."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import Ramp
from shaderlab.reference.transforms import look_at, perspective, rotate

Matrix = npt.NDArray[Any]
Vector = Sequence[float]


def camera(
    eye: Vector,
    target: Vector,
    fovy: float,
    aspect: float = 1.0,
    *,
    near: float = 0.1,
    far: float = 20.0,
) -> dict[str, Matrix]:
    """The uniforms `view` and `projection` of a camera; `fovy` is in degrees.

    >>> sorted(camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), 30.0))
    ['projection', 'view']
    """
    projection = perspective(radians(fovy), aspect, near, far)
    return {"view": look_at(eye, target), "projection": projection}


def camera_rays(view: Matrix, projection: Matrix) -> Ramp:
    """The directions in which a camera's pixels look, over the whole target; of any length.

    >>> round(camera_rays(**camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), 90.0)).dx[0], 6)
    2.0
    """
    right, above, back = np.asarray(view)[:3, :3]
    return directions(right / projection[0, 0], above / projection[1, 1], -back)


def directions(right: Vector, above: Vector, forward: Vector) -> Ramp:
    """Directions over all of a panel.

    Args:
        forward: the one in the middle.
        right, above: from there to the middles of the right and the upper edge.

    >>> directions((1.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, -1.0)).origin
    (-1.0, -0.5, -1.0)
    """
    across, up, middle = (np.asarray(axis, float) for axis in (right, above, forward))
    corner = (middle - across - up).tolist()
    return Ramp(tuple(corner), tuple((2.0 * across).tolist()), tuple((2.0 * up).tolist()))


def turned(degrees: float, axis: Vector = (0.0, 1.0, 0.0)) -> Matrix:
    """A rotation by so many degrees, around y unless told otherwise.

    >>> (turned(90.0) @ (1, 0, 0, 1)).round(12).tolist()
    [0.0, 0.0, -1.0, 1.0]
    """
    return np.asarray(rotate(radians(degrees), axis))
