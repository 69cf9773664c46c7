"""Small copies of picture files, for the page: made once, when the picture is drawn.

`picture.png` has `picture@320.png` beside it, at most 320 pixels in each direction.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shaderlab.pictures.files import reduced, write_picture


def save_preview(path: str | Path, pixels: NDArray[np.uint8], side: int) -> None:
    """Write a copy of at most `side` pixels in each direction beside the PNG file `path`.

    Args:
        path: the PNG file.
        pixels: what is in it, uint8 (height, width, 3), row 0 at the bottom.
        side: how large the copy is at most.

    Raises:
        AssetError: the copy can't be written.
    """
    write_picture(_copy_path(Path(path), side), reduced(pixels, side))


def preview(path: str | Path, side: int) -> Path:
    """A PNG file's copy of at most `side` pixels, or the file itself if there is none."""
    file = _copy_path(Path(path), side)
    return file if side and file.is_file() else Path(path)


def _copy_path(path: Path, side: int) -> Path:
    return path.with_name(f"{path.stem}@{side}.png")
