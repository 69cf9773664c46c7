"""Test charts: textures that say of every texel where it lies."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

# Digits of five rows, three columns each, the top row first.
_ROWS = {
    "0": "75557", "1": "26227", "2": "71747", "3": "71717", "4": "55711", "5": "74717",
    "6": "74757", "7": "71122", "8": "75757", "9": "75717",
}  # fmt: skip


def uv_grid(size: int = 256, cells: int = 8) -> Array:
    """A grid whose fields say their column and row: red grows with s, green with t. RGBA.

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
