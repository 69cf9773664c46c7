"""Compressed textures' blocks, and DDS files: a header, then the blocks of each mipmap level, the
largest first.

Source: Microsoft, "Programming Guide for DDS" (DDS_HEADER, DDS_PIXELFORMAT, DDS_HEADER_DXT10).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

from shaderlab.errors import AssetError, CaseError
from shaderlab.files import read_regular
from shaderlab.model.textures import BLOCK_BYTES, CompressedTexture, level_sizes

_HEADER, _EXTENDED = 128, 20
_FOUR_CC = {b"DXT1": "bc1", b"DXT5": "bc3"}
_DXGI = {71: "bc1", 77: "bc3", 98: "bc7"}
_KNOWN = "DXT1, DXT5, and of DX10 files BC1, BC3 and BC7 (UNORM)"


@dataclass(frozen=True)
class Blocks:
    """A compressed image: its format, size (width, height) and the bytes of each level."""

    format: str
    size: tuple[int, int]
    levels: tuple[bytes, ...]


def level_bytes(format: str, size: tuple[int, int]) -> int:
    """How many bytes a level takes: its blocks, those at the edges whole.

    >>> level_bytes("bc1", (8, 8)), level_bytes("bc7", (5, 1))
    (32, 32)
    """
    width, height = size
    return -(-width // 4) * -(-height // 4) * BLOCK_BYTES[format]


def read_dds(path: Path) -> Blocks:
    """The blocks of a two-dimensional DDS file.

    Raises:
        AssetError: there is no such file, it is no DDS file, it is cut short, or its format is
            none of those known here.
    """
    try:
        data = read_regular(path)
    except OSError as error:
        raise AssetError(f"can't read it ({error.strerror})", file=str(path)) from error
    if len(data) < _HEADER or data[:4] != b"DDS ":
        raise AssetError("this is no DDS file", file=str(path), remedy="it must begin with 'DDS '")
    height, width, count = struct.unpack_from("<2I8xI", data, 12)
    code = data[84:88]
    start, format = _HEADER, _FOUR_CC.get(code)
    if code == b"DX10" and len(data) >= _HEADER + _EXTENDED:
        (number,) = struct.unpack_from("<I", data, _HEADER)
        start, format = _HEADER + _EXTENDED, _DXGI.get(number)
        code = b"DXGI format %d" % number
    if format is None:
        said = code.decode("ascii", "replace").strip("\0") or "no compression"
        raise AssetError(f"a DDS file of {said}", file=str(path), remedy=f"known are {_KNOWN}")
    if not (1 <= width <= 16384 and 1 <= height <= 16384):
        raise AssetError(f"a DDS file of {width} × {height} texels", file=str(path))
    sizes = level_sizes(width, height)[: max(count, 1)]
    levels = []
    for number, size in enumerate(sizes):
        length = level_bytes(format, size)
        if start + length > len(data):
            raise AssetError(
                f"it is cut short: level {number} of {len(sizes)} needs {length} bytes, "
                f"there are {max(len(data) - start, 0)}",
                file=str(path),
            )
        levels.append(data[start : start + length])
        start += length
    return Blocks(format, (width, height), tuple(levels))


def blocks_of(source: CompressedTexture, folder: Path) -> Blocks:
    """The blocks of a texture, from its file or as it gives them.

    Raises:
        CaseError: a level has another number of bytes than its size asks for.
        AssetError: the file can't be read; see `read_dds`.
    """
    if source.file is not None:
        blocks = read_dds(folder / source.file)
    else:
        given = source.blocks() if callable(source.blocks) else source.blocks
        blocks = Blocks(source.format, source.size, tuple(given))
    sizes = level_sizes(*blocks.size)
    if len(blocks.levels) > len(sizes):
        raise CaseError(
            f"CompressedTexture: {len(blocks.levels)} levels, but {blocks.size[0]} × "
            f"{blocks.size[1]} has {len(sizes)}"
        )
    for number, data in enumerate(blocks.levels):
        wanted = level_bytes(blocks.format, sizes[number])
        if len(data) != wanted:
            raise CaseError(
                f"CompressedTexture: level {number} of {blocks.format}, {sizes[number][0]} × "
                f"{sizes[number][1]}, takes {wanted} bytes, not {len(data)}"
            )
    return blocks
