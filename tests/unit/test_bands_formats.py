"""What reading a render target back may give: the right code is inside, its neighbour is not."""

from __future__ import annotations

import numpy as np
import pytest

from shaderlab.bands import Band
from shaderlab.errors import FormulaError


def codes(value: float, fmt: str, **options: float) -> tuple[float, float]:
    allowed = Band.exact([value]).quantise(fmt, **options)  # type: ignore[arg-type]
    return float(allowed.lo[0]), float(allowed.hi[0])


@pytest.mark.parametrize(
    ("value", "lowest", "highest"),
    [
        *((0.0, 0, 0), (1.0, 255, 255), (0.2, 51, 51), (0.5, 127, 128), (-3.0, 0, 0)),
        *((7.0, 255, 255), (0.76, 194, 194), (1 / 255, 1, 1), (0.39 / 255, 0, 0)),
        *((0.41 / 255, 0, 1), (0.59 / 255, 0, 1), (0.61 / 255, 1, 1), (np.inf, 255, 255)),
    ],
)
def test_eight_bits_are_at_most_six_tenths_of_a_code_off(
    value: float, lowest: int, highest: int
) -> None:
    assert codes(value, "rgba8") == (lowest, highest)


def test_every_code_comes_back_as_itself_and_nothing_else() -> None:
    all_codes = np.arange(256.0)
    for fmt in ("rgba8", "unorm8"):
        allowed = Band.exact(all_codes / 255.0).quantise(fmt)
        np.testing.assert_array_equal(allowed.lo, all_codes)
        np.testing.assert_array_equal(allowed.hi, all_codes)


@pytest.mark.parametrize(
    ("value", "code"), [(0.0, 0), (1.0, 255), (0.5, 187.516), (0.2140411, 127.5), (0.002, 6.59)]
)
def test_srgb_codes(value: float, code: float) -> None:
    lowest, highest = codes(value, "srgb8")
    assert lowest == np.ceil(code - 0.7) and highest == np.floor(code + 0.7)


def test_the_tolerance_is_a_parameter() -> None:
    assert codes(0.2, "rgba8", tolerance=1.0) == (50, 52)
    assert codes(0.5, "srgb8", tolerance=0.0001)[0] > codes(0.5, "srgb8", tolerance=0.0001)[1]


def test_halves_round_either_way() -> None:
    lowest, highest = codes(0.1, "rgba16f")
    assert highest == np.nextafter(np.float16(lowest), np.float16(1.0))
    assert lowest < 0.1 < highest
    assert codes(0.5, "rgba16f") == (0.5, 0.5)
    assert codes(1e6, "rgba16f") == (65504.0, np.inf)
    assert codes(-1e6, "rgba16f") == (-np.inf, -65504.0)
    assert codes(2.0**-16, "rgba16f")[0] == 0.0
    everything = np.arange(2**16, dtype=np.uint16).view(np.float16)
    normal = everything[np.isfinite(everything) & (np.abs(everything) >= 2.0**-14)]
    assert Band.exact(normal).quantise("rgba16f").contains(normal).all()


def test_floats_are_the_band_itself() -> None:
    band = Band.exact([[0.1, 5.0, -2.0]]) * 0.3
    allowed = band.quantise("rgba32f")
    np.testing.assert_array_equal(allowed.lo, band.lo)
    np.testing.assert_array_equal(allowed.hi, band.hi)


@pytest.mark.parametrize(("fmt", "largest"), [("depth16", 65535), ("depth24", 16777215)])
def test_depth_is_a_code_over_its_largest(fmt: str, largest: int) -> None:
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.0, 1.0, 500).astype(np.float32)
    allowed = Band.exact(depth).quantise(fmt)
    stored = np.rint(depth.astype(np.float64) * largest)
    assert allowed.contains((stored / largest).astype(np.float32)).all()
    assert allowed.contains(np.floor(depth.astype(np.float64) * largest) / largest).all()
    assert not allowed.contains((stored + 4) / largest).any()
    assert codes(1.5, fmt) == codes(1.0, fmt) and codes(1.5, fmt)[1] == 1.0
    assert codes(-1.0, fmt)[0] == 0.0


def test_float_depth_is_clamped() -> None:
    assert codes(1.5, "depth32f") == (1.0, 1.0) and codes(-2.0, "depth32f") == (0.0, 0.0)
    assert codes(0.25, "depth32f") == (0.25, 0.25)


def test_nan_is_any_code_in_fixed_point_and_nan_in_floats() -> None:
    undefined = Band.exact([1.0]) / 0.0
    fixed = undefined.quantise("rgba8")
    assert fixed.vacuous.all() and fixed.contains([77.0]) and not fixed.contains([np.nan])
    assert undefined.quantise("rgba16f").contains([np.nan])


def test_widths_count_codes_where_a_code_is_certain() -> None:
    allowed = Band.exact([0.2]).quantise("rgba8")
    assert allowed.widths([51.0]) == 0.0
    assert allowed.widths([52.0]) == 2.0 and allowed.widths([54.0]) == 6.0


def test_an_unknown_format_is_named_with_the_nearest() -> None:
    with pytest.raises(FormulaError, match="rgba16f"):
        Band.exact([1.0]).quantise("rgb16f")
