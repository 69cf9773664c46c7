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

# Digits of five rows, three columns each, the top row first.
_ROWS = {
    "0": "75557", "1": "26227", "2": "71747", "3": "71717", "4": "55711", "5": "74717",
    "6": "74757", "7": "71122", "8": "75757", "9": "75717",
}  # fmt: skip


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


def uv_grid(size: int = 256, cells: int = 8) -> Array:
    """A grid whose fields show their column and row; red grows with s, green with t. RGBA.

    Field "27" is column 2, row 7; "00" holds the first texel. At most ten fields a side; each
    needs 16 texels for its figures to be legible.

    >>> uv_grid(32, 2)[0, 0].astype(float).round(2).tolist()
    [0.15, 0.15, 0.55, 1.0]
    """
    if not 1 <= cells <= 10 or size % cells:
        raise ValueError(f"uv_grid: {cells} fields do not divide {size} texels")
    t, s = np.mgrid[0:size, 0:size] / size
    column, row = np.floor(s * cells).astype(int), np.floor(t * cells).astype(int)
    odd = (column + row) % 2
    red = 0.15 + 0.75 * column / max(cells - 1, 1)
    green = 0.15 + 0.75 * row / max(cells - 1, 1)
    image = np.stack([red, green, np.full_like(red, 0.55), np.ones_like(red)], -1)
    image[..., :3] *= np.where(odd == 1, 0.78, 1.0)[..., None]
    side = size // cells
    dot = side // 9
    if dot < 1:
        return image.astype(np.float32)
    for y in range(cells):
        for x in range(cells):
            ink = 1.0 if image[y * side, x * side, :3].mean() < 0.5 else 0.08
            for place, digit in enumerate((x, y)):
                left = x * side + (1 + 4 * place) * dot
                _write(image, str(digit), left, y * side + 2 * dot, dot, ink)
    return image.astype(np.float32)


def _write(image: Array, digit: str, left: int, bottom: int, dot: int, ink: float) -> None:
    """One digit, 3 × 5 dots, its lower left corner at a texel."""
    for row, bits in enumerate(reversed(_ROWS[digit])):
        for column in range(3):
            if int(bits) >> (2 - column) & 1:
                y, x = bottom + row * dot, left + column * dot
                image[y : y + dot, x : x + dot, :3] = ink
