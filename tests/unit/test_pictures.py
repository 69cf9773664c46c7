"""Pictures: colours, marks, the flip, enlargement, and errors that name the file."""

from __future__ import annotations

import importlib
import math
import os
import resource
import struct
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from shaderlab.errors import AssetError
from shaderlab.model import pictures
from shaderlab.model.pictures import files


def test_three_channels_are_clipped_without_gamma() -> None:
    shown = pictures.to_display(np.array([[[0.5, -1.0, 2.0]]], dtype=np.float32))
    assert shown.image.tolist() == [[[128, 0, 255]]]
    assert "-1 to 2" in shown.caption


def test_alpha_is_dropped_as_a_window_does() -> None:
    pixel = np.array([[[1.0, 0.5, 0.2, 0.25]]])
    assert pictures.to_display(pixel).image.tolist() == [[[255, 128, 51]]]


def test_bytes_pass_through() -> None:
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    assert np.array_equal(pictures.to_display(pixels).image, pixels)


def test_two_channels_are_red_and_green() -> None:
    assert pictures.to_display(np.array([[[1.0, 0.2]]])).image.tolist() == [[[255, 51, 0]]]


def test_one_channel_is_false_coloured_over_its_finite_range() -> None:
    values = np.array([[2.0, 3.0, 6.0, np.inf]])
    shown = pictures.to_display(values)
    assert (shown.low, shown.high) == (2.0, 6.0)
    luma = shown.image[0, :3].astype(float) @ [0.2126, 0.7152, 0.0722]
    assert luma[0] < luma[1] < luma[2]
    assert shown.image[0, 3].tolist() == list(pictures.NOT_FINITE)
    assert "1 not finite" in shown.caption


def test_the_map_has_its_published_colours() -> None:
    ends = pictures.to_display(np.array([[0.0, 1.0]])).image[0].tolist()
    assert ends == [[68, 1, 84], [253, 231, 37]]


def test_one_range_makes_two_pictures_comparable() -> None:
    first = pictures.to_display(np.array([[0.0, 1.0]]), value_range=(0.0, 4.0)).image
    second = pictures.to_display(np.array([[1.0, 4.0]]), value_range=(0.0, 4.0)).image
    assert first[0, 1].tolist() == second[0, 0].tolist()


@pytest.mark.parametrize("value", [0.0, np.nan, 3.0e38])
def test_constant_or_empty_ranges_do_no_harm(value: float) -> None:
    assert pictures.to_display(np.full((2, 2, 1), value)).image.shape == (2, 2, 3)


def test_the_widest_range_of_floats_does_not_overflow() -> None:
    shown = pictures.to_display(np.array([[-1.7e308, 0.0, 1.7e308]]))
    assert len({tuple(p) for p in shown.image[0].tolist()}) == 3


def test_a_nan_in_any_channel_is_magenta() -> None:
    pixels = np.zeros((1, 2, 4), dtype=np.float32)
    pixels[0, 1, 2] = np.nan
    assert pictures.to_display(pixels).image.tolist() == [[[0, 0, 0], [255, 0, 255]]]


def test_wide_integers_become_levels() -> None:
    shown = pictures.to_display(np.array([[[0, 5, 10]]], dtype=np.int32))
    assert shown.image.tolist() == [[[0, 128, 255]]]


@pytest.mark.parametrize("bad", [np.zeros((2, 2, 5)), np.zeros(4), np.zeros((0, 2, 3))])
def test_other_shapes_are_refused(bad: np.ndarray) -> None:
    with pytest.raises(AssetError, match="height, width"):
        pictures.to_display(bad)


def distances(widths: np.ndarray, outside: np.ndarray) -> np.ndarray:
    """The distance picture in colours."""
    indices, palette = pictures.distance_picture(widths, outside)
    return np.asarray(palette[indices])


def test_distance_colours() -> None:
    widths = np.array([[-1.0, 0.0], [1.0, np.nan]])
    picture = distances(widths, np.zeros((2, 2), bool))
    assert picture.shape == (2, 2, 3)
    assert [tuple(c) for c in picture.reshape(4, 3).tolist()] == [
        pictures.BAND_LOW,
        pictures.BAND_MIDDLE,
        pictures.BAND_HIGH,
        pictures.UNCOVERED,
    ]


def test_a_lone_value_outside_shows_both_colours_of_the_check() -> None:
    outside = np.zeros((3, 3), bool)
    outside[1, 1] = True
    for widths in (np.full((3, 3), 0.2), np.full((3, 3), np.nan)):
        picture = distances(widths, outside)
        assert picture.shape == (6, 6, 3)
        cell = {tuple(p) for p in picture[2:4, 2:4].reshape(-1, 3).tolist()}
        assert len(cell) == 2 and cell & set(pictures.OUTSIDE) and pictures.CHECK in cell
        rest = {tuple(p) for p in picture[:2].reshape(-1, 3).tolist()}
        assert not rest & {pictures.CHECK, *pictures.OUTSIDE}


def test_the_further_outside_the_brighter() -> None:
    for expected, width in zip(pictures.OUTSIDE, (1.5, -99.0, 1e3, 1e5, math.nan), strict=True):
        picture = distances(np.array([[width]]), np.array([[True]]))
        assert {tuple(p) for p in picture.reshape(-1, 3).tolist()} == {expected, pictures.CHECK}
    light = [sum(colour) for colour in pictures.OUTSIDE]
    assert light == sorted(light)


def test_of_several_components_the_furthest_is_shown() -> None:
    widths = np.array([[[0.1, -1.0, np.nan]]])
    picture = distances(widths, np.zeros((1, 1, 3), bool))
    assert tuple(picture[0, 0].tolist()) == pictures.BAND_LOW
    bad = np.array([[[False, False, True]]])
    marked = distances(widths, bad)
    assert {tuple(p) for p in marked.reshape(-1, 3).tolist()} == {
        pictures.OUTSIDE[-1],
        pictures.CHECK,
    }


def test_files_have_the_top_row_first_and_come_back_in_gl_order(tmp_path: Path) -> None:
    import OpenImageIO as oiio

    pixels = np.zeros((2, 1, 3), dtype=np.uint8)
    pixels[0] = (255, 0, 0)
    pictures.save_png(tmp_path / "a.png", pixels)
    raw = oiio.ImageBuf(str(tmp_path / "a.png")).get_pixels("uint8")
    assert raw[-1, 0].tolist() == [255, 0, 0]
    assert np.array_equal(pictures.load(tmp_path / "a.png"), pixels / np.float32(255))


def test_small_tables_are_enlarged_by_a_whole_factor(tmp_path: Path) -> None:
    table = np.arange(3 * 8 * 3, dtype=np.uint8).reshape(3, 8, 3)
    pictures.save_png(tmp_path / "t.png", table, min_side=100)
    back = np.rint(pictures.load(tmp_path / "t.png") * 255).astype(np.uint8)
    assert back.shape == (102, 272, 3)
    assert np.array_equal(back[::34, ::34], table)


def test_alpha_is_not_multiplied_in(tmp_path: Path) -> None:
    pixels = np.array([[[200, 100, 50, 10]]], dtype=np.uint8)
    pictures.save_png(tmp_path / "a.png", pixels)
    assert np.rint(pictures.load(tmp_path / "a.png") * 255).tolist() == pixels.tolist()


def test_floats_and_two_channels_are_converted_on_saving(tmp_path: Path) -> None:
    pictures.save_png(tmp_path / "f.png", np.full((2, 2, 2), 1.0))
    assert pictures.load(tmp_path / "f.png")[0, 0].tolist() == [1.0, 1.0, 0.0]


def test_a_failed_write_leaves_the_old_file_and_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "a.png"
    pictures.save_png(target, np.zeros((1, 1, 3), np.uint8))
    before = target.read_bytes()

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(AssetError, match="No space left") as caught:
        pictures.save_png(target, np.ones((1, 1, 3), np.uint8))
    assert caught.value.file == str(target) and caught.value.remedy
    assert target.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_where_files_may_not_be_large_a_picture_is_named(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 255, (256, 256, 3), dtype=np.uint8)
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (9000, old[1]))
    try:
        with pytest.raises(AssetError, match=r"p\.png: can't write the picture \(File too"):
            pictures.save_png(tmp_path / "p.png", noise)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)
    assert not list(tmp_path.iterdir())


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match="nowhere"):
        pictures.save_png(tmp_path / "nowhere" / "a.png", np.zeros((1, 1, 3), np.uint8))


def test_written_files_may_be_read_by_others(tmp_path: Path) -> None:
    old = os.umask(0o022)
    try:
        pictures.save_png(tmp_path / "a.png", np.zeros((1, 1, 3), np.uint8))
    finally:
        os.umask(old)
    assert (tmp_path / "a.png").stat().st_mode & 0o777 == 0o644


def test_loading_names_what_is_wrong(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match="no such image") as caught:
        pictures.load(tmp_path / "gone.png")
    assert caught.value.file == str(tmp_path / "gone.png")
    with pytest.raises(AssetError, match="folder"):
        pictures.load(tmp_path)
    (tmp_path / "text.png").write_text("not a picture")
    with pytest.raises(AssetError, match="can't read"):
        pictures.load(tmp_path / "text.png")
    pictures.save_png(tmp_path / "whole.png", np.random.default_rng(1).random((64, 64, 3)))
    data = (tmp_path / "whole.png").read_bytes()
    (tmp_path / "cut.png").write_bytes(data[: len(data) // 2])
    with pytest.raises(AssetError, match="can't read"):
        pictures.load(tmp_path / "cut.png")


def test_oversized_images_are_refused_before_they_are_read(tmp_path: Path) -> None:
    header = b"P5\n20000 1\n255\n"
    (tmp_path / "wide.pgm").write_bytes(header + bytes(20000))
    with pytest.raises(AssetError, match="larger than") as caught:
        pictures.load(tmp_path / "wide.pgm")
    assert caught.value.file == str(tmp_path / "wide.pgm")


def png(folder: Path, width: int = 32, height: int = 32) -> bytes:
    """A PNG file of 32 × 32 pixels whose header says another size."""
    noise = np.random.default_rng(0).integers(0, 256, (32, 32, 3), dtype=np.uint8)
    pictures.save_png(folder / "good.png", noise)
    good = (folder / "good.png").read_bytes()
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return good[:12] + header + struct.pack(">I", zlib.crc32(header)) + good[33:]


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("zero.png", lambda folder: png(folder, 0, 0)),
        ("enormous.png", lambda folder: png(folder, 10**6, 10**6)),
        ("wider.png", lambda folder: png(folder, 16384, 16384)),
        ("half.png", lambda folder: png(folder)[:900]),
        ("start.png", lambda folder: png(folder)[:20]),
        ("empty.png", lambda folder: b""),
        ("words.png", lambda folder: b"no image"),
        ("zero.pnm", lambda folder: b"P6 0 0 255\n"),
        ("enormous.pnm", lambda folder: b"P6 16000 16000 255\nabc"),
        ("zero.tga", lambda folder: bytes(2) + b"\2" + bytes(13) + b"\x18\0"),
        ("half.hdr", lambda folder: b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 8\nxx"),
    ],
)
def test_a_damaged_image_is_named(tmp_path: Path, name: str, make: Callable[[Path], bytes]) -> None:
    """Nothing, half of it, or a size that is not there: the file's name and a remedy, no crash."""
    path = tmp_path / name
    path.write_bytes(make(tmp_path))
    with pytest.raises(AssetError) as caught:
        pictures.load(path)
    assert caught.value.file == str(path) and caught.value.remedy
    assert caught.value.message.startswith(("can't read the image (", "the image is "))


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (7, 1), (33, 18)])
def test_every_pixel_is_what_another_decoder_reads(
    tmp_path: Path, shape: tuple[int, int], channels: int
) -> None:
    noise = np.random.default_rng(7).integers(0, 256, (*shape, channels), dtype=np.uint8)
    pictures.save_png(tmp_path / "n.png", noise)
    assert np.array_equal(np.rint(pictures.load(tmp_path / "n.png") * 255), noise)


def test_indices_are_written_as_their_colours(tmp_path: Path) -> None:
    colours = np.array([[7, 8, 9], [255, 0, 0], [1, 2, 250]], np.uint8)
    indices = np.random.default_rng(4).integers(0, 3, (20, 31, 1), np.uint8)
    pictures.save_png(tmp_path / "i.png", indices, min_side=40, palette=colours)
    large = np.rint(pictures.load(tmp_path / "i.png") * 255).astype(np.uint8)
    assert np.array_equal(large[::2, ::2], colours[indices[..., 0]])
    assert np.array_equal(large[1::2, 1::2], colours[indices[..., 0]])


def test_without_isa_l_zlib_packs_the_same_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    data = np.random.default_rng(5).integers(0, 9, 3000, np.uint8).tobytes()
    quick = files.deflate(data)
    monkeypatch.setitem(sys.modules, "isal.isal_zlib", None)
    slow = importlib.reload(files).deflate(data)
    monkeypatch.undo()
    importlib.reload(files)
    assert slow == zlib.compress(data, 1)
    assert zlib.decompress(quick) == zlib.decompress(slow) == data
