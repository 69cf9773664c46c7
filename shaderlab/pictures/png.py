"""Pictures as PNG, all in memory: a scene has many small ones, and each should cost little.

W3C, Portable Network Graphics (PNG) Specification, third edition: 8 bits a channel, or a byte a
pixel with a palette; no interlacing. Colours are sRGB.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_COLOUR_TYPES = {1: 0, 3: 2, 4: 6}  # by channels: grey, RGB, RGBA
_INDEXED = 3
_LEVEL = 3  # of zlib: a third of the default's time, for files a tenth larger
_INDEXED_LEVEL = 4  # a byte a pixel and few of them different: cheap, and a tenth smaller than 3


def encode(pixels: Bytes, palette: Bytes | None = None) -> bytes:
    """A PNG file's bytes.

    Args:
        pixels: (height, width, 1, 3 or 4), the top row first.
        palette: (colours, 3), for pixels of one channel that are indices of it; 256 at most.
    """
    height, width, channels = pixels.shape
    kind = _COLOUR_TYPES[channels] if palette is None else _INDEXED
    header = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    chunks = [_chunk(b"IHDR", header), _chunk(b"sRGB", b"\0")]
    if palette is None:
        data = zlib.compress(_less_the_left(pixels), _LEVEL)
    else:
        chunks.append(_chunk(b"PLTE", palette.tobytes()))
        data = zlib.compress(_as_they_are(pixels), _INDEXED_LEVEL)
    return b"".join((_SIGNATURE, *chunks, _chunk(b"IDAT", data), _chunk(b"IEND", b"")))


def _less_the_left(pixels: Bytes) -> bytes:
    """Rows with filter 1: each byte less that of the pixel to its left."""
    height, width, channels = pixels.shape
    rows = np.empty((height, 1 + width * channels), np.uint8)
    rows[:, 0] = 1
    filtered = rows[:, 1:].reshape(height, width, channels, copy=False)
    filtered[:, 0] = pixels[:, 0]
    np.subtract(pixels[:, 1:], pixels[:, :-1], out=filtered[:, 1:])
    return rows.tobytes()


def _as_they_are(pixels: Bytes) -> bytes:
    """Rows with filter 0, which suits indices."""
    return np.pad(pixels[:, :, 0], ((0, 0), (1, 0))).tobytes()


def _chunk(kind: bytes, data: bytes) -> bytes:
    checked = kind + data
    return struct.pack(">I", len(data)) + checked + struct.pack(">I", zlib.crc32(checked))
