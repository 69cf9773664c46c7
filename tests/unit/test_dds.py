"""DDS files: what is read of them, and what is wrong with them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from cases.scenes.block_codecs import compressed, decoded_blocks
from shaderlab import CompressedTexture
from shaderlab.assets import checker
from shaderlab.drivers.programs.textures import read_dds
from shaderlab.errors import AssetError, CaseError

IMAGE = checker(size=16, cells=4)


def dds(
    code: bytes, data: bytes, size: tuple[int, int] = (16, 16), dxgi: int = 0, levels: int = 1
) -> bytes:
    """A file as Microsoft's guide lays it out: height, width, levels, and the format's code."""
    head = struct.pack("<4s7I44x", b"DDS ", 124, 0x1007, size[1], size[0], len(data), 0, levels)
    head += struct.pack("<2I4s5I", 32, 4, code, 0, 0, 0, 0, 0) + bytes(20)
    assert len(head) == 128
    return head + (struct.pack("<5I", dxgi, 3, 0, 1, 0) if code == b"DX10" else b"") + data


@pytest.mark.parametrize(
    ("code", "dxgi", "format"),
    [(b"DXT1", 0, "bc1"), (b"DXT5", 0, "bc3"), (b"DX10", 71, "bc1"), (b"DX10", 77, "bc3"),
     (b"DX10", 98, "bc7")],
)  # fmt: skip
def test_blocks_are_read_as_they_are(tmp_path: Path, code: bytes, dxgi: int, format: str) -> None:
    blocks = compressed(IMAGE, format)
    (tmp_path / "a.dds").write_bytes(dds(code, blocks, dxgi=dxgi))
    got = read_dds(tmp_path / "a.dds")
    assert (got.format, got.size, got.levels) == (format, (16, 16), (blocks,))
    codes = decoded_blocks(got.levels[0], format, got.size)
    assert np.abs(codes / 255.0 - IMAGE).max() < 0.06


def test_levels_one_after_the_other(tmp_path: Path) -> None:
    levels = [bytes([n]) * size for n, size in enumerate((128, 32, 8, 8, 8))]
    (tmp_path / "a.dds").write_bytes(dds(b"DXT1", b"".join(levels), levels=5))
    assert read_dds(tmp_path / "a.dds").levels == tuple(levels)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "no DDS file"),
        (b"PNG " * 40, "no DDS file"),
        (dds(b"DXT1", bytes(127)), "level 0 of 1 needs 128 bytes, there are 127"),
        (dds(b"DXT1", bytes(130), levels=2), "level 1 of 2 needs 32 bytes, there are 2"),
        (dds(b"DXT3", bytes(256)), "DXT3"),
        (dds(b"DX10", bytes(256), dxgi=95), "DXGI format 95"),
        (dds(b"DXT1", b"", size=(0, 4)), "0 × 4"),
        (dds(b"DXT1", b"", size=(99999, 4)), "99999 × 4"),
    ],
)
def test_what_is_wrong_with_a_file(tmp_path: Path, data: bytes, says: str) -> None:
    file = tmp_path / "bad.dds"
    file.write_bytes(data)
    with pytest.raises(AssetError, match=says) as raised:
        read_dds(file)
    assert raised.value.file == str(file)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match="can't read it"):
        read_dds(tmp_path / "none.dds")


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({}, "either file or blocks"),
        ({"file": "a.dds", "blocks": [b""]}, "either file or blocks"),
        ({"blocks": [bytes(8)], "format": "bc2", "size": (4, 4)}, "bc2"),
        ({"blocks": [bytes(8)], "format": "bc1"}, "size must be positive"),
        ({"file": "a.dds", "compare": "less"}, "no compressed depths"),
    ],
)
def test_what_can_not_be_a_compressed_texture(given: dict[str, object], says: str) -> None:
    with pytest.raises(CaseError, match=says):
        CompressedTexture(**given)  # type: ignore[arg-type]


def test_odd_images_are_no_blocks() -> None:
    with pytest.raises(AssetError, match="5 × 4"):
        compressed(np.zeros((4, 5, 4)), "bc1")
    with pytest.raises(AssetError, match="bc9"):
        compressed(np.zeros((4, 4, 4)), "bc9")
