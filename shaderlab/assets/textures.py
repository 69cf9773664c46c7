"""Textures made by arithmetic: the same on every machine, without files.

Each is a float32 array (height, width, channels) of values in 0…1. Row 0 is the bottom row and
column 0 the left one, as OpenGL uploads them, so texture coordinate (0, 0) is the lower left.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
Color = Sequence[float]


def solid(color: Color) -> Array:
    """One texel of one colour.

    >>> solid((1.0, 0.0, 0.0, 1.0)).shape
    (1, 1, 4)
    """
    return np.asarray(color, np.float32)[None, None, :]


def checker(
    size: int = 64,
    cells: int = 8,
    dark: Color = (0.13, 0.15, 0.19, 1.0),
    light: Color = (0.87, 0.86, 0.82, 1.0),
) -> Array:
    """A chessboard of `cells` × `cells` fields; the lower left one is dark.

    >>> checker(size=4, cells=2, dark=(0.0,), light=(1.0,))[..., 0].astype(int).tolist()
    [[0, 0, 1, 1], [0, 0, 1, 1], [1, 1, 0, 0], [1, 1, 0, 0]]
    """
    if size % cells:
        raise ValueError(f"checker: {cells} cells do not divide {size} texels")
    step = np.arange(size) * cells // size
    odd = ((step[:, None] + step[None, :]) % 2)[..., None]
    return np.where(odd == 1, np.asarray(light), np.asarray(dark)).astype(np.float32)
