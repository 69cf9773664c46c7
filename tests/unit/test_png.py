"""PNG files are read by other libraries as what was written, whatever their size and channels."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from shaderlab import pictures
from shaderlab.pictures.png import encode

COLOURS = np.array([[7, 8, 9], [255, 0, 0], [1, 2, 250]], np.uint8)


def decoded(data: bytes, folder: Path) -> np.ndarray:
    """What OpenImageIO reads, the top row first, as bytes."""
    import OpenImageIO as oiio

    (folder / "p.png").write_bytes(data)
    image = oiio.ImageInput.open(str(folder / "p.png"))
    found = np.asarray(image.read_image("uint8"))
    assert not image.geterror()
    return found


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("size", [(1, 1), (1, 7), (7, 1), (33, 65)])
def test_every_byte_comes_back(tmp_path: Path, channels: int, size: tuple[int, int]) -> None:
    pixels = np.random.default_rng(3).integers(0, 256, (*size, channels), np.uint8)
    if channels == 4:
        pixels[..., 3] = 255  # readers multiply by alpha unless asked not to
    assert np.array_equal(decoded(encode(pixels), tmp_path).reshape(pixels.shape), pixels)
    upside_down = np.ascontiguousarray(pixels[::-1])
    assert encode(upside_down[::-1]) == encode(pixels)  # however the array lies in memory


def test_indices_come_back_as_colours(tmp_path: Path) -> None:
    indices = np.random.default_rng(4).integers(0, 3, (20, 31, 1), np.uint8)
    found = decoded(encode(indices, COLOURS), tmp_path)
    assert np.array_equal(found, COLOURS[indices[..., 0]])
    pictures.save_png(tmp_path / "i.png", indices, min_side=40, palette=COLOURS)
    large = np.rint(pictures.load(tmp_path / "i.png") * 255).astype(np.uint8)
    assert np.array_equal(large[::2, ::2], COLOURS[indices[..., 0]])


def test_chunks_are_whole_and_checked() -> None:
    data, found = encode(np.zeros((2, 3, 1), np.uint8), COLOURS), []
    place = 8
    while place < len(data):
        length, kind = struct.unpack(">I4s", data[place : place + 8])
        content = data[place + 4 : place + 8 + length]
        (checksum,) = struct.unpack(">I", data[place + 8 + length : place + 12 + length])
        assert checksum == zlib.crc32(content)
        found.append(kind)
        place += 12 + length
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and place == len(data)
    assert found == [b"IHDR", b"sRGB", b"PLTE", b"IDAT", b"IEND"]


def test_a_byte_that_changed_is_noticed(tmp_path: Path) -> None:
    """The checksums are there to be compared: a reader refuses a file that is not as written."""
    from shaderlab.errors import AssetError

    data = bytearray(encode(np.random.default_rng(5).integers(0, 256, (9, 9, 3), np.uint8)))
    data[-20] ^= 1
    (tmp_path / "p.png").write_bytes(data)
    with pytest.raises(AssetError, match="can't read"):
        pictures.load(tmp_path / "p.png")


def test_a_smooth_picture_packs_well() -> None:
    ramp = np.broadcast_to(np.arange(256, dtype=np.uint8)[None, :, None], (256, 256, 3))
    assert len(encode(np.ascontiguousarray(ramp))) < ramp.size / 100
