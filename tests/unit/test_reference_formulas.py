"""The formulas in float64: the catalogue's figures, laws that must hold, second opinions."""

from __future__ import annotations

from math import cos, radians, sin, tan

import numpy as np
import pytest
from hypothesis import given, strategies as st

from cases.scenes import waves
from shaderlab.reference import (
    attenuation as fade,
    blending,
    depth_stencil,
    gamma,
    lighting,
    spotlight,
)

# d, Kl, Kq, F(d), d at 5 %, d at 1 %: the catalogue's twelve rows, typed again.
ROWS = [
    (7, 0.7, 1.8, 0.010626993, 3.060300, 7.224303),
    (13, 0.35, 0.44, 0.012514078, 6.185585, 14.607545),
    (20, 0.22, 0.20, 0.011709602, 9.212300, 21.705393),
    (32, 0.14, 0.07, 0.012960083, 15.505410, 36.620283),
    (50, 0.09, 0.032, 0.011695906, 23.001280, 54.233013),
    (65, 0.07, 0.017, 0.012924071, 31.435740, 74.280997),
    (100, 0.045, 0.0075, 0.012422360, 47.421556, 111.930414),
    (160, 0.027, 0.0028, 0.012987013, 77.694997, 183.275326),
    (200, 0.022, 0.0019, 0.012285012, 94.377976, 222.549706),
    (325, 0.014, 0.0007, 0.012580594, 155.054104, 366.202833),
    (600, 0.007, 0.0002, 0.012953368, 291.217104, 686.279973),
    (3250, 0.0014, 0.000007, 0.012580594, 1550.541037, 3662.028328),
]


@pytest.mark.parametrize(("d", "kl", "kq", "at_d", "five", "one"), ROWS)
def test_attenuation_table(
    d: float, kl: float, kq: float, at_d: float, five: float, one: float
) -> None:
    assert fade.attenuation(d, 1.0, kl, kq) == pytest.approx(at_d, abs=5e-10)
    assert fade.reach(0.05, 1.0, kl, kq) == pytest.approx(five, abs=5e-7)
    assert fade.reach(0.01, 1.0, kl, kq) == pytest.approx(one, abs=5e-7)


@pytest.mark.parametrize(
    ("angle", "inner", "outer", "ratio"),
    [
        (30, 25, 35, 0.537811),
        (26, 25, 35, 0.913789),
        (14, 25, 35, 1.734179),
        (34, 25, 35, 0.113424),
        (50, 25, 35, -2.023555),
        (15, 12.5, 17.5, 0.540717),
        (25, 25, 35, 1.0),
        (35, 25, 35, 0.0),
    ],
)
def test_spotlight_table(angle: float, inner: float, outer: float, ratio: float) -> None:
    lamp, axis = np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, -4.0])
    fragment = lamp + 7.0 * np.array([sin(radians(angle)), 0.0, -cos(radians(angle))])
    cosines = cos(radians(inner)), cos(radians(outer))
    got = spotlight.spot_ratio(fragment[None], lamp, axis, *cosines)
    assert got.shape == (1, 1)
    assert got.item() == pytest.approx(ratio, abs=5e-7)
    clamped = spotlight.spot_intensity(fragment[None], lamp, axis, *cosines)
    assert clamped.item() == pytest.approx(min(max(ratio, 0.0), 1.0), abs=5e-7)


def test_the_notes_took_a_cosine_of_radians() -> None:
    assert cos(12.5) == pytest.approx(0.9978, abs=5e-5)
    assert cos(radians(12.5)) == pytest.approx(0.976296, abs=5e-7)


def test_gamma_figures() -> None:
    assert gamma.gamma_encode(0.5, 2.2) == pytest.approx(0.729740, abs=5e-7)
    assert round(255 * float(gamma.srgb_encode(0.5))) == 188


def test_blinn_phong_past_a_right_angle() -> None:
    normal = np.array([0.0, 1.0, 0.0])
    light = np.array([tan(radians(60.0)), 1.0, 0.0])
    view = np.array([1.0, 1.0, 0.0])
    assert lighting.phong(normal, light, view, 8.0).item() == 0.0
    expected = cos(radians(52.5)) ** 8.0
    assert lighting.blinn(normal, light, view, 8.0).item() == pytest.approx(expected)
    assert expected == pytest.approx(0.018862, abs=5e-7)


@given(st.floats(-89.0, 89.0), st.floats(-89.0, 89.0))
def test_blinn_is_never_cut_off(light: float, view: float) -> None:
    """Its angle is half the sum of the two, so it stays below 90° above the surface."""
    normal = np.array([0.0, 1.0, 0.0])
    to_light = np.array([sin(radians(light)), cos(radians(light)), 0.0])
    to_view = np.array([sin(radians(view)), cos(radians(view)), 0.0])
    got = lighting.blinn(normal, to_light, to_view, 1.0).item()
    assert got == pytest.approx(cos(radians((light + view) / 2.0)), abs=1e-9)
    assert got > 0.0


def test_shininess_at_the_mirrored_direction() -> None:
    """Both lobes are 1 where the viewer stands in the mirrored ray, whatever the shininess."""
    normal, light = np.array([0.0, 0.0, 2.0]), np.array([0.6, 0.0, 0.8])
    view = np.array([-0.6, 0.0, 0.8])
    for shininess in (2.0, 32.0, 256.0):
        for lobe in (lighting.phong, lighting.blinn):
            assert lobe(normal, light, view, shininess).item() == pytest.approx(1.0)
    assert lighting.diffuse(normal, light).item() == pytest.approx(0.8)


def test_blend_equation() -> None:
    green, red = np.array([0.0, 1.0, 0.0, 0.6]), np.array([1.0, 0.0, 0.0, 1.0])
    result = blending.over(green, red)
    np.testing.assert_allclose(result, (0.4, 0.6, 0.0, 0.76), atol=1e-15)
    assert np.rint(255.0 * result).tolist() == [102, 153, 0, 194]


def test_a_mask_of_zero_compares_zero_with_zero() -> None:
    for reference, stored in ((1, 2), (2, 1), (255, 0)):
        passing = {
            func
            for func in depth_stencil.FUNCTIONS
            if depth_stencil.stencil_passes(func, reference, stored, 0)
        }
        assert passing == {"equal", "lequal", "gequal", "always"}


@pytest.mark.parametrize(
    ("time", "green"),
    [
        (0.0, 0.5),
        (1.0, 0.920735),
        (2.0, 0.954649),
        (3.0, 0.570560),
        (np.pi / 2, 1.0),
        (3 * np.pi / 2, 0.0),
    ],
)
def test_pulse(time: float, green: float) -> None:
    assert waves.pulse(time) == pytest.approx(green, abs=5e-7)
