"""Cameras as the uniforms that shaders read, and turns in degrees."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from typing import Any

import numpy as np
import numpy.typing as npt

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


def turned(degrees: float, axis: Vector = (0.0, 1.0, 0.0)) -> Matrix:
    """A rotation by so many degrees, around y unless told otherwise.

    >>> (turned(90.0) @ (1, 0, 0, 1)).round(12).tolist()
    [0.0, 0.0, -1.0, 1.0]
    """
    return np.asarray(rotate(radians(degrees), axis))
