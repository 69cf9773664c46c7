"""PNG files (ISO/IEC 15948): the one format that pictures are written in."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from .deflate import deflated
from .packing import SIGNATURE, chunk

Bytes = NDArray[np.uint8]

_COLOUR_TYPES = {1: 0, 3: 2, 4: 6}  # by the number of channels: grey, RGB, RGBA
_INDEXED = 3
_UP = 2  # the filter "each byte less the one above it"


def encode(pixels: Bytes, palette: Bytes | None = None) -> bytes:
    """uint8 (height, width, 1, 3 or 4), row 0 at the bottom, as the bytes of a PNG file.

    Args:
        pixels: the picture.
        palette: uint8 (1…256, 3), for one channel of indices into it.
    """
    height, width, channels = pixels.shape
    rows = pixels[::-1].reshape(height, width * channels)
    lines = np.empty((height, 1 + width * channels), np.uint8)
    lines[:, 0] = _UP
    lines[0, 1:] = rows[0]
    np.subtract(rows[1:], rows[:-1], out=lines[1:, 1:])
    colours = _COLOUR_TYPES[channels] if palette is None else _INDEXED
    head = struct.pack(">IIBBBBB", width, height, 8, colours, 0, 0, 0)
    table = b"" if palette is None else chunk(b"PLTE", palette.tobytes())
    data = chunk(b"IDAT", deflated(lines.data))
    return SIGNATURE + chunk(b"IHDR", head) + table + data + chunk(b"IEND", b"")
