"""Image files: pictures written for the report, textures read for cases.

Files have the top row first, OpenGL the lowest; the flip happens here and nowhere else.
"""

from __future__ import annotations

import functools
import resource
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shaderlab.errors import AssetError
from shaderlab.files import memory_file, write_bytes
from shaderlab.pictures.display import as_pixels, enlarge, to_display

Floats = NDArray[np.float32]

LARGEST_SIDE = 16384
_OVERHEAD = 1 << 16  # bytes that an encoded picture may have more than its pixels
PNG = {
    "oiio:UnassociatedAlpha": 1,
    # A third of the default's time, for files a tenth larger.
    "png:compressionLevel": 3,
    "png:filter": 16,  # libpng's number for "each byte less the one to the left"
}


def save_png(
    path: str | Path,
    array: NDArray[Any],
    *,
    min_side: int = 1,
    palette: NDArray[np.uint8] | None = None,
) -> None:
    """Write an array as a PNG file, whole or not at all.

    Args:
        path: the file; its folder must exist.
        array: uint8 (height, width, 1, 3 or 4), row 0 at the bottom; anything else goes
            through `to_display` first.
        min_side: a picture whose shorter side is smaller is enlarged by a whole factor, each
            pixel becoming a square.
        palette: uint8 (colours, 3), for an array of one channel of indices.

    Raises:
        AssetError: the file can't be written.
    """
    pixels = as_pixels(array)
    if pixels.dtype != np.uint8 or pixels.shape[2] == 2:
        pixels = to_display(pixels).image
    pixels = enlarge(pixels, max(1, -(-min_side // min(pixels.shape[:2]))))
    if palette is not None:
        pixels = palette[pixels[:, :, 0]]
    write(Path(path), encoded("png", pixels, PNG, path))


def encoded(
    kind: str, pixels: NDArray[np.uint8], attributes: Mapping[str, int | str], path: str | Path
) -> bytes:
    """uint8 pixels (height, width, channels), row 0 at the bottom, as the bytes of an image file.

    They are encoded in memory: on a full disk OpenImageIO reports no error for a PNG file, and
    never returns from a WebP file.

    Args:
        kind, attributes: those of OpenImageIO.
        pixels: the picture.
        path: the file that they are for.

    Raises:
        AssetError: they can't be encoded; names the file.
    """
    import OpenImageIO as oiio

    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, "uint8")
    for name, value in attributes.items():
        spec.attribute(name, value)
    output = oiio.ImageOutput.create(kind)
    if output is None:
        raise _unwritten(path, oiio.geterror() or f"no {kind} writer")
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)[0]  # of files in memory as well
    if limit != resource.RLIM_INFINITY and limit < pixels.nbytes + _OVERHEAD:
        raise _unwritten(path, f"this process may write files of {limit} bytes only")
    with memory_file() as file:
        opened = output.open(f"/dev/fd/{file.fileno()}", spec)
        done = opened and output.write_image(np.ascontiguousarray(pixels[::-1])) and output.close()
        problem = output.geterror()
        if problem or not done:
            raise _unwritten(path, problem or "the file could not be finished")
        file.seek(0)
        return file.read()


def write(path: Path, data: bytes) -> None:
    """Write the bytes of an image file, whole or not at all. Raises AssetError."""
    try:
        write_bytes(path, data)
    except OSError as error:
        raise _unwritten(path, error.strerror or str(error)) from error


def _unwritten(target: str | Path, problem: str) -> AssetError:
    return AssetError(
        f"can't write the picture ({problem})",
        file=target,
        remedy="check that the folder exists, may be written to, and has room",
    )


def load(path: str | Path) -> Floats:
    """An image file as float32 (height, width, 1…4), row 0 the lowest.

    Integer formats become 0…1; no colour space is converted and alpha is not multiplied in.

    Raises:
        AssetError: the file is missing, damaged, empty, or too large for a texture.
    """
    import OpenImageIO as oiio

    source = Path(path)
    if not source.is_file():
        what = "is a folder, not an image" if source.is_dir() else "there is no such image file"
        raise AssetError(what, file=source, remedy="check the path and its spelling")
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    opened = oiio.ImageInput.open(str(source), config)
    if opened is None:
        raise _damaged(source, oiio.geterror())
    try:
        spec = opened.spec()
        if max(spec.width, spec.height) > LARGEST_SIDE or spec.depth > 1:
            raise AssetError(
                f"the image is {spec.width} × {spec.height} × {spec.depth}, "
                f"larger than {LARGEST_SIDE} × {LARGEST_SIDE}",
                file=source,
                remedy="scale it down",
            )
        if not 1 <= spec.nchannels <= 4:
            raise AssetError(
                f"the image has {spec.nchannels} channels; a texture has one to four",
                file=source,
                remedy="save it as grey, RGB or RGBA",
            )
        pixels = opened.read_image("float")
        problem = opened.geterror()
    finally:
        opened.close()
    if pixels is None or problem:
        raise _damaged(source, problem)
    shaped = np.asarray(pixels, dtype=np.float32).reshape(spec.height, spec.width, spec.nchannels)
    return np.ascontiguousarray(shaped[::-1])


def reduced(pixels: NDArray[np.uint8], side: int) -> NDArray[np.uint8]:
    """uint8 (height, width, channels), at most `side` pixels in each direction.

    Each new pixel is the mean of its own block: quick, and no colour rings around an edge.
    """
    height, width = pixels.shape[:2]
    scale = side / max(height, width)
    if scale >= 1:
        return pixels
    means: NDArray[Any] = pixels
    for length in (height, width):
        count = max(1, round(length * scale))
        starts = np.arange(count) * length // count
        blocks = np.diff(starts, append=length)
        sums = means[starts].astype(np.float32)
        # One row of each block after the other: `np.add.reduceat` takes three times as long.
        for step in range(1, int(blocks.max())):
            more = blocks > step
            sums[more] += means[starts[more] + step]
        sums /= blocks.astype(np.float32)[:, None, None]
        means = np.ascontiguousarray(sums.swapaxes(0, 1))
    return np.asarray(np.rint(means), dtype=np.uint8)


def coarse(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Values of a picture (height, width, channels) at so many pixels in its longer direction, or
    up to twice as many.

    Colours are means of squares. Numbers that are no colours, which are integers or stand alone,
    may have no mean: of these each square gives one.
    """
    factor = max(values.shape[:2]) // side
    if factor < 2:
        return values
    down, across = (min(factor, count) for count in values.shape[:2])
    height, width = values.shape[0] // down * down, values.shape[1] // across * across
    if values.dtype.kind != "f" or values.shape[2] == 1:
        return values[:height:down, :width:across]
    with np.errstate(all="ignore"):
        rows = functools.reduce(np.add, (values[start:height:down] for start in range(down)))
        columns = (rows[:, start:width:across] for start in range(across))
        return np.asarray(functools.reduce(np.add, columns) / (down * across))


def _damaged(path: Path, problem: str) -> AssetError:
    return AssetError(
        f"can't read the image ({problem.strip() or 'no reason given'})",
        file=path,
        remedy="open it in an image viewer; if that fails too, make it anew",
    )
