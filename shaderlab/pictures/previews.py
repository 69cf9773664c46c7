"""Small copies beside a picture file, for pages that show many: made once, when it is drawn.

`picture.png` has `picture@320.webp` beside it (at most 320 pixels in each direction), or
`picture@320.png` where that is hardly larger, and `picture@0.webp` in its own size. WebP loses
what eyes don't see; the PNG keeps every value.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shaderlab.errors import AssetError
from shaderlab.pictures.files import reduced, save_png

_QUALITY = "webp:70"  # a photograph's usual one
# How hard the encoder looks for a shorter file, 0 to 6: the default, 6, takes three times as long
# for files a twelfth smaller, and no nearer to the picture.
_EFFORT = 2


def save_previews(path: str | Path, pixels: NDArray[np.uint8], sides: tuple[int, ...]) -> None:
    """Write copies of at most `sides` pixels (0: as large as it is) beside the PNG file `path`.

    Args:
        path: the PNG file, already written.
        pixels: what is in it, uint8 (height, width, 3), row 0 at the bottom.
        sides: which copies.

    Raises:
        AssetError: a file can't be written.
    """
    for side in sides:
        small = reduced(pixels, side) if side else pixels
        webp = _beside(Path(path), side, "webp")
        _save_webp(webp, small)
        rival = Path(path)
        if side:
            rival = _beside(Path(path), side, "png")
            save_png(rival, small)
        loser = webp if rival.stat().st_size <= 1.25 * webp.stat().st_size else rival
        if loser == webp or side:
            loser.unlink()


def preview(path: str | Path, side: int) -> bytes:
    """The bytes of a PNG file's copy of at most `side` pixels, or of the file if there is none.

    Raises:
        OSError: it can't be read.
    """
    for suffix in ("webp", "png"):
        file = _beside(Path(path), side, suffix)
        if file.is_file():
            return file.read_bytes()
    return Path(path).read_bytes()


def _beside(path: Path, side: int, suffix: str) -> Path:
    return path.with_name(f"{path.stem}@{side}.{suffix}")


def _save_webp(path: Path, pixels: NDArray[Any]) -> None:
    import OpenImageIO as oiio

    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, "uint8")
    spec.attribute("compression", _QUALITY)
    spec.attribute("webp:method", _EFFORT)
    output = oiio.ImageOutput.create("webp")
    written = (
        output is not None
        and output.open(str(path), spec)
        and output.write_image(np.ascontiguousarray(pixels[::-1]))
        and output.close()
    )
    if not written:
        why = output.geterror() if output is not None else oiio.geterror()
        raise AssetError(f"can't write the picture ({why})", file=path)
