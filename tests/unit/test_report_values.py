"""Packed numbers come back as they were; the palette is the library's."""

from __future__ import annotations

import json
import zlib

import numpy as np

from shaderlab.model import pictures
from shaderlab.model.pictures import Values, judged_part, pack
from tests.unit.test_report_samples import INF, NAN

ODD = (0.0, -0.0, 1.0, -1.5, NAN, INF, -INF, 1e-45, -1e-45, 3.4e38, -3.4e38, 16777217.0)


def values(measured: np.ndarray, reference: np.ndarray) -> Values:
    shape = measured.shape
    return Values(
        size=(shape[1], shape[0]),
        origin=(0, 0),
        unit=0.0,
        whole=True,
        measured=measured,
        reference=reference,
        low=np.full(shape, -INF),
        high=np.full(shape, 0.1).astype("f4").astype(float),
        judged=np.ones(shape, bool),
        outside=measured > 0,
    )


def unpack(data: bytes) -> Values:
    """What `pack` made, read as the page's script reads it."""
    text, _, body = zlib.decompress(data).partition(b"\n")
    head = json.loads(text)
    rows, width, components = head["rows"], head["columns"], head["components"]
    planes = (components, rows, width)
    count = rows * width * components
    flags = np.frombuffer(body, np.uint8, count).reshape(planes)
    wide = [unfold(body[count * at :], count).reshape(planes) for at in (1, 5, 9, 13)]
    measured = wide[0].copy()
    measured[:, :, 0] = np.cumsum(measured[:, :, 0], axis=1, dtype=np.int32)
    measured = np.cumsum(measured, axis=2, dtype=np.int32)
    nearest = wide[1] + measured
    high_end = nearest - wide[2] - wide[3]
    numbers = [floats(each) for each in (measured, nearest, nearest + wide[2], high_end)]
    m, r, low, high = (np.moveaxis(each, 0, -1).astype(np.float64) for each in numbers)
    judged, outside = (np.moveaxis(flags & bit, 0, -1).astype(bool) for bit in (1, 2))
    return Values(
        size=tuple(head["size"]),
        origin=tuple(head["origin"]),
        unit=head["unit"],
        whole=head["whole"],
        measured=m,
        reference=r,
        low=low,
        high=high,
        judged=judged,
        outside=outside,
    )


def unfold(data: bytes, count: int) -> np.ndarray:
    folded = np.frombuffer(joined(data, count, 4), np.uint32)
    return ((folded >> 1) ^ (np.uint32(0) - (folded & 1))).astype(np.int32)


def joined(data: bytes, count: int, size: int) -> bytes:
    return np.frombuffer(data, np.uint8, count * size).reshape(size, count).T.tobytes()


def floats(ordered: np.ndarray) -> np.ndarray:
    bits = np.where(ordered < 0, ordered ^ np.int32(0x7FFFFFFF), ordered)
    return np.ascontiguousarray(bits).view(np.float32)


def test_every_float32_comes_back_bit_for_bit() -> None:
    generator = np.random.default_rng(3)
    bits = generator.integers(0, 2**32, (9, 7, 3), dtype=np.uint32)
    measured = bits.view(np.float32).astype(float)
    measured.ravel()[: len(ODD)] = np.array(ODD, np.float32)
    back = unpack(pack(values(measured, measured)))
    same = np.float32(back.measured).view("u4") == np.float32(measured).view("u4")
    assert (same | np.isnan(measured)).all() and np.isnan(back.measured[np.isnan(measured)]).all()
    assert (back.low == -INF).all() and (back.high == np.float32(0.1)).all()
    assert (back.outside == (measured > 0)).all()


def test_references_are_the_nearest_float32() -> None:
    generator = np.random.default_rng(4)
    reference = np.exp(generator.uniform(-60, 60, (16, 16, 4))) * generator.choice([-1, 1], 4)
    back = unpack(pack(values(reference.astype("f4").astype(float), reference)))
    assert (back.reference == np.float32(reference)).all()


def test_only_what_was_judged_is_kept() -> None:
    covered = np.zeros((40, 50), bool)
    covered[10:13, 20:25] = True
    full = np.random.default_rng(5).random((40, 50, 2))
    part = judged_part(arrays(full, covered))
    assert part.origin == (20, 10) and part.size == (50, 40) and part.whole
    assert (unpack(pack(part)).measured == np.float32(full[10:13, 20:25])).all()


def test_a_huge_picture_is_cut_around_its_worst_value() -> None:
    covered = np.ones((600, 600), bool)
    full = np.zeros((600, 600, 4))
    full[590, 3] = 7.0
    part = judged_part(arrays(full, covered), (3, 590))
    assert not part.whole and part.measured.shape == (64, 64, 4)
    x, y = part.origin
    assert (part.measured[590 - y, 3 - x] == 7.0).all()


def test_nothing_judged_is_a_file_too() -> None:
    part = judged_part(arrays(np.zeros((4, 4, 1)), np.zeros((4, 4), bool)))
    assert not unpack(pack(part)).judged.any()


def test_smooth_values_are_small() -> None:
    y, x = np.mgrid[0:64, 0:64] / 64
    smooth = np.sqrt(x + y + 0.1)[..., None]
    assert len(pack(values(smooth.astype("f4").astype(float), smooth))) < 0.4 * smooth.size * 18


def arrays(full: np.ndarray, covered: np.ndarray) -> dict[str, np.ndarray]:
    each = dict.fromkeys(("measured", "exact", "low", "high"), full)
    return {**each, "outside": full > 9, "covered": covered, "unit": np.float64(0)}


def test_the_palette_is_the_librarys_and_that_of_the_pictures() -> None:
    import OpenImageIO as oiio

    steps = np.linspace(0.0, 1.0, 256, dtype=np.float32)[None, :, None]
    shown = pictures.to_display(steps).image[0]
    assert shown.tobytes().hex() == pictures.VIRIDIS
    mapped = oiio.ImageBufAlgo.color_map(oiio.ImageBuf(steps), 0, "viridis").get_pixels("float")
    light = mapped[0, :, :3]  # linear
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    assert np.abs(shown - encoded * 255).max() < 0.6
