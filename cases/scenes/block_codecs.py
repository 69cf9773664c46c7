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


def between_ends(blocks: bytes, format: str, size: tuple[int, int]) -> tuple[Array, Array]:
    """What blocks of BC1 or BC3 stand for, with nothing rounded, in codes (height, width, 4); and
    how far the two ends of each texel's line are apart, in each channel.

    Source: Khronos Data Format Specification 1.3, section 18, "S3TC Compressed Texture Image
    Formats"; BC1 without alpha.

    Args:
        blocks, size: as in `decoded_blocks`.
        format: "bc1" or "bc3".

    >>> block = bytes((0x1F, 0xF8, 0x1F, 0x00)) + bytes(4 * [0b11100100])  # magenta, blue
    >>> values, apart = between_ends(block, "bc1", (4, 4))
    >>> values[0, :, 0].tolist(), apart[0, 0].tolist()
    ([255.0, 0.0, 170.0, 85.0], [255.0, 0.0, 0.0, 0.0])
    """
    parts = np.frombuffer(blocks, np.uint8).reshape(-1, 16 if format == "bc3" else 8)
    colors = parts[:, -8:].astype(np.uint32)
    codes = colors[:, [0, 2]] | colors[:, [1, 3]] << 8
    fields = codes[..., None] >> np.array([11, 5, 0]) & np.array([31, 63, 31])
    one, other = np.moveaxis(fields * 255.0 / np.array([31.0, 63.0, 31.0]), 1, 0)
    four = (codes[:, :1] > codes[:, 1:]) | (format == "bc3")
    third = np.where(four, (2.0 * one + other) / 3.0, (one + other) / 2.0)
    last = np.where(four, (one + 2.0 * other) / 3.0, 0.0)
    hues = _picked(np.stack([one, other, third, last], 1), colors[:, 4:], 2)
    alpha = np.full((*hues.shape[:-1], 1), 255.0), np.zeros((len(parts), 1))
    if format == "bc3":
        alpha = _alphas(parts[:, :8])
    apart = np.hstack([np.abs(one - other), alpha[1]])
    whole = np.broadcast_to(apart[:, None], (len(parts), 16, 4))
    values = np.concatenate([hues, alpha[0]], -1)
    return _laid_out(values, size), _laid_out(whole, size)


def _alphas(parts: Array) -> tuple[Array, Array]:
    """The alphas of BC3's blocks, (n, 16, 1), and how far their ends are apart, (n, 1)."""
    one, other = parts[:, :1].astype(float), parts[:, 1:2].astype(float)
    steps = np.arange(1, 7)
    seventh = ((7.0 - steps) * one + steps * other) / 7.0
    fifth = ((5.0 - steps[:4]) * one + steps[:4] * other) / 5.0
    ends = np.broadcast_to([0.0, 255.0], (len(parts), 2))
    between = np.where(one > other, seventh, np.hstack([fifth, ends]))
    palette = np.hstack([one, other, between])
    return _picked(palette[..., None], parts[:, 2:], 3), np.abs(one - other)


def _picked(palette: Array, packed: Array, bits: int) -> Array:
    """Of each block's palette (n, colours, channels) the 16 that numbers of so many bits name."""
    flags = np.unpackbits(packed.astype(np.uint8), axis=1, bitorder="little")
    numbers = flags.reshape(-1, 16, bits) @ (1 << np.arange(bits))
    return np.asarray(np.take_along_axis(palette, numbers[..., None], 1))


def _laid_out(texels: Array, size: tuple[int, int]) -> Array:
    """Blocks of 16 texels as an image."""
    width, height = size
    blocks = texels.reshape(height // 4, width // 4, 4, 4, -1)
    return np.asarray(blocks.swapaxes(1, 2).reshape(height, width, -1))
