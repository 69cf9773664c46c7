"""Images as compressed blocks, by the `etcpak` library (ETC1, ETC2, BC1, BC3, BC7)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.errors import AssetError, require_extra, suggest

Array = npt.NDArray[Any]

# What compresses each format.
_BY = {
    "etc1": "compress_etc1_rgb",
    "etc2_rgb8": "compress_etc2_rgb",
    "etc2_eac_rgba8": "compress_etc2_rgba",
    "bc1": "compress_bc1",
    "bc3": "compress_bc3",
    "bc7": "compress_bc7",
}


def compressed(image: Array, format: str) -> bytes:
    """An image's blocks, its first row first.

    Args:
        image: (height, width, 4) of 0…1, both sides multiples of 4.
        format: "etc1", "etc2_rgb8", "etc2_eac_rgba8", "bc1", "bc3" or "bc7".

    >>> len(compressed(np.zeros((8, 8, 4)), "bc1"))
    32
    """
    with require_extra("course", "compressing texels"):
        import etcpak

    if format not in _BY:
        raise AssetError(f"nothing compresses {format!r}", remedy=suggest(format, _BY))
    height, width = image.shape[:2]
    if height % 4 or width % 4:
        raise AssetError(f"{width} × {height} texels are no blocks of 4 × 4")
    codes = np.rint(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)
    packed = codes.tobytes()
    if format == "bc7":
        return bytes(etcpak.compress_bc7(packed, width, height, etcpak.BC7CompressBlockParams()))
    return bytes(getattr(etcpak, _BY[format])(packed, width, height))


def decoded_blocks(blocks: bytes, format: str, size: tuple[int, int]) -> Any:
    """Compressed blocks as the library `texture2ddecoder` decodes them: codes (height, width, 4).

    Args:
        blocks: of one level, its first row first.
        format: "etc1", "etc2_rgb8", "etc2_eac_rgba8", "bc1", "bc3" or "bc7".
        size: (width, height).

    >>> decoded_blocks(bytes(8), "bc1", (4, 4))[0, 0].tolist()
    [0, 0, 0, 255]
    """
    with require_extra("course", "decoding compressed texels"):
        import texture2ddecoder

    function = {
        "etc1": texture2ddecoder.decode_etc1,
        "etc2_rgb8": texture2ddecoder.decode_etc2,
        "etc2_eac_rgba8": texture2ddecoder.decode_etc2a8,
        "bc1": texture2ddecoder.decode_bc1,
        "bc3": texture2ddecoder.decode_bc3,
        "bc7": texture2ddecoder.decode_bc7,
    }[format]
    width, height = size
    codes = np.frombuffer(function(blocks, width, height), np.uint8)
    return codes.reshape(height, width, 4)[..., [2, 1, 0, 3]]
