"""Bytes packed in zlib's format (RFC 1950) as quickly as may be: a run's pictures and numbers."""

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shaderlab.errors import AssetError, require_extra
from shaderlab.files import write_if_changed

from .display import as_pixels, enlarge, to_display

try:
    # ISA-L packs them as small as zlib's first level does, in a fourth of its time.
    from isal.isal_zlib import compress
except ImportError:  # there is none for this processor
    from zlib import compress


def deflate(data: bytes | memoryview) -> bytes:
    """`data` in few bytes: the first level, after which both take far longer for little."""
    return compress(data, 1)


SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunk(kind: bytes, data: bytes) -> bytes:
    """One of the parts that a PNG file consists of."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


Bytes = NDArray[np.uint8]

_COLOUR_TYPES = {1: 0, 3: 2, 4: 6}  # by the number of channels: grey, RGB, RGBA
_INDEXED = 3
_UP = 2  # the filter "each byte less the one above it"


def encode(pixels: Bytes, palette: Bytes | None = None) -> bytes:
    """uint8 (height, width, 1, 3 or 4), row 0 at the bottom, as the bytes of a PNG file; `palette`
    is uint8 (1…256, 3), for one channel of indices into it."""
    height, width, channels = pixels.shape
    rows = pixels[::-1].reshape(height, width * channels)
    lines = np.empty((height, 1 + width * channels), np.uint8)
    lines[:, 0] = _UP
    lines[0, 1:] = rows[0]
    np.subtract(rows[1:], rows[:-1], out=lines[1:, 1:])
    colours = _COLOUR_TYPES[channels] if palette is None else _INDEXED
    head = struct.pack(">IIBBBBB", width, height, 8, colours, 0, 0, 0)
    table = b"" if palette is None else chunk(b"PLTE", palette.tobytes())
    data = chunk(b"IDAT", deflate(lines.data))
    return SIGNATURE + chunk(b"IHDR", head) + table + data + chunk(b"IEND", b"")


Floats = NDArray[np.float32]

LARGEST_SIDE = 16384


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

    Raises AssetError: the file can't be written."""
    pixels = as_pixels(array)
    if pixels.dtype != np.uint8 or pixels.shape[2] == 2:
        pixels = to_display(pixels).image
    pixels = enlarge(pixels, max(1, -(-min_side // min(pixels.shape[:2]))))
    write_picture(path, pixels, palette)


def write_picture(
    path: str | Path, pixels: NDArray[np.uint8], palette: NDArray[np.uint8] | None = None
) -> None:
    """Write uint8 pixels (height, width, 1, 3 or 4) as an image file, whole or not at all.

    Here, and nowhere else, it is decided how pictures are encoded. Raises AssetError.
    """
    try:
        write_if_changed(path, encode(pixels, palette))
    except OSError as error:
        raise AssetError(
            f"can't write the picture ({error.strerror or error})",
            file=path,
            remedy="check that the folder exists and is writable, and that the disk is not full",
        ) from error


def load(path: str | Path) -> Floats:
    """An image file as float32 (height, width, 1…4), row 0 the lowest.

    Integer formats become 0…1; no colour space is converted and alpha is not multiplied in. Raises
    AssetError: the file is missing, damaged, empty, or too large for a texture, or the extra
    "images" is not installed."""
    source = Path(path)
    if not source.is_file():
        what = "is a folder, not an image" if source.is_dir() else "there is no such image file"
        raise AssetError(what, file=source, remedy="check the path and its spelling")
    with require_extra("images", "reading an image file", source):
        import OpenImageIO as oiio

    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    opened = oiio.ImageInput.open(str(source), config)
    if opened is None:
        raise _damage_error(source, oiio.geterror())
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
        raise _damage_error(source, problem)
    shaped = np.asarray(pixels, dtype=np.float32).reshape(spec.height, spec.width, spec.nchannels)
    return np.ascontiguousarray(shaped[::-1])


def _damage_error(path: Path, problem: str) -> AssetError:
    return AssetError(
        f"can't read the image ({problem.strip() or 'no reason given'})",
        file=path,
        remedy="open it in an image viewer; if that fails too, make it anew",
    )
