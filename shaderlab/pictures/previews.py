"""Small copies of picture files, for the page: made once, when the picture is drawn.

`picture.png` has `picture@320.webp` beside it (at most 320 pixels in each direction), or
`picture@320.png` where that is hardly larger, and `picture@0.webp` in its own size. WebP loses
what eyes don't see; the PNG has every value.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shaderlab.pictures.files import PNG, encoded, reduced, write

_WEBP: dict[str, int | str] = {
    "compression": "webp:70",  # a photograph's usual quality
    # How hard the encoder looks for a shorter file, 0 to 6: the default, 6, takes three times as
    # long for files a twelfth smaller, and no nearer to the picture.
    "webp:method": 2,
}


def save_previews(path: str | Path, pixels: NDArray[np.uint8], sides: tuple[int, ...]) -> None:
    """Write copies of at most `sides` pixels (0: as large as it is) beside the PNG file `path`.

    Args:
        path: the PNG file, already written.
        pixels: what is in it, uint8 (height, width, 3), row 0 at the bottom.
        sides: which copies.

    Raises:
        AssetError: a file can't be written.
        OSError: the PNG file has gone.
    """
    for side in sides:
        small = reduced(pixels, side) if side else pixels
        webp = encoded("webp", small, _WEBP, path)
        png = encoded("png", small, PNG, path) if side else b""
        if (len(png) or Path(path).stat().st_size) > 1.25 * len(webp):
            write(_copy_path(Path(path), side, "webp"), webp)
        elif side:
            write(_copy_path(Path(path), side, "png"), png)


def preview(path: str | Path, side: int) -> Path:
    """A PNG file's copy of at most `side` pixels, or the file itself if there is none."""
    for suffix in ("webp", "png"):
        file = _copy_path(Path(path), side, suffix)
        if file.is_file():
            return file
    return Path(path)


def _copy_path(path: Path, side: int, suffix: str) -> Path:
    return path.with_name(f"{path.stem}@{side}.{suffix}")
