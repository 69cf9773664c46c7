"""Depth, shadows and filtering: printed figures, laws, and the same formulas over bands."""

from __future__ import annotations

from math import radians
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from shaderlab.bands import Band
from shaderlab.reference import depth, filtering, shadows
from shaderlab.reference.transforms import look_at, orthographic, perspective


def holds(formula: Any, *inputs: Any) -> Band:
    """The formula's band of these inputs, which must hold its own float64 value."""
    arrays = [np.atleast_1d(np.asarray(x, np.float32)) for x in inputs]
    band = formula(*(Band.exact(x) for x in arrays))
    exact = formula(*(x.astype(np.float64) for x in arrays))
    assert band.contains(np.asarray(exact, np.float32)).all()
    assert not band.vacuous.any()
    return band


@pytest.mark.parametrize("near", [0.1, 1.0])
@given(share=st.floats(0.0, 1.0))
def test_window_depth_is_what_the_projection_gives(near: float, share: float) -> None:
    z = near + share * (100.0 - near)
    clip = perspective(radians(45.0), 1.0, near, 100.0) @ (0.0, 0.0, -z, 1.0)
    assert depth.window_depth(z, near, 100.0) == pytest.approx(
        0.5 * clip[2] / clip[3] + 0.5, abs=1e-12
    )


@pytest.mark.parametrize(
    ("start", "stop", "near", "share"),
    [
        (1.0, 2.0, 1.0, 0.505051),
        (1.0, 2.0, 0.1, 0.050050),
        (50.0, 100.0, 1.0, 0.010101),
        (50.0, 100.0, 0.1, 0.001001),
    ],
)
def test_share_of_the_depth_buffer(start: float, stop: float, near: float, share: float) -> None:
    got = depth.window_depth(stop, near, 100.0) - depth.window_depth(start, near, 100.0)
    assert got == pytest.approx(share, abs=5e-7)


@given(st.floats(0.0, 1.0))
def test_distance_is_the_inverse(value: float) -> None:
    z = depth.distance_of(value, 0.5, 80.0)
    assert depth.window_depth(z, 0.5, 80.0) == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize("near", [0.1, 1.0])
def test_a_step_is_one_code(near: float) -> None:
    z = 50.0
    step = depth.depth_step(z, near, 100.0)
    codes = depth.window_depth(np.array([z, z + step]), near, 100.0) * 2.0**24
    assert np.diff(codes).item() == pytest.approx(1.0, rel=1e-4)


def test_depth_over_bands() -> None:
    z = np.linspace(1.0, 99.0, 50)[:, None]
    assert (holds(depth.window_depth, z, 1.0, 100.0).hi <= 1.0001).all()
    holds(depth.distance_of, np.linspace(0.0, 0.99, 50)[:, None], 1.0, 100.0)
    holds(depth.linear_depth, z, 1.0, 100.0)
    holds(depth.depth_step, z, 1.0, 100.0)


def test_the_point_in_the_shadow_map() -> None:
    """Light at (−2, 4, −1), ±10, 1…7.5: the figures of the notes' scene, up being +y."""
    space = orthographic(-10, 10, -10, 10, 1, 7.5) @ look_at((-2, 4, -1), (0, 0, 0))
    got = shadows.shadow_coordinates(space @ (1.0, 0.0, 2.0, 1.0))
    np.testing.assert_allclose(got, (0.567082, 0.578072, 0.685453), atol=5e-7)
    tilted = orthographic(-10, 10, -10, 10, 1, 7.5) @ look_at((-2, 4, -1), (0, 0, 0), (1, 1, 1))
    got = shadows.shadow_coordinates(tilted @ (1.0, 0.0, 2.0, 1.0))
    np.testing.assert_allclose(got[:2], (0.544450, 0.592841), atol=5e-7)


def test_a_bias_lets_a_surface_out_of_its_own_shadow() -> None:
    stored = 0.5
    behind_itself = 0.5 + 1e-4
    assert shadows.shadow(behind_itself, stored) == 1.0
    assert shadows.shadow(behind_itself, stored, 1e-3) == 0.0
    assert shadows.shadow(0.6, stored, 1e-3) == 1.0
    assert shadows.shadow(1.0001, stored) == 0.0


def test_the_slope_bias_grows_as_light_grazes() -> None:
    normal = np.array([0.0, 1.0, 0.0])
    angles = np.radians([0.0, 30.0, 60.0, 85.0])
    lights = np.stack([np.sin(angles), np.cos(angles), 0.0 * angles], axis=1)
    bias = shadows.slope_bias(normal, lights, 0.005, 0.05)[:, 0]
    assert bias[0] == 0.005 and (np.diff(bias) >= 0.0).all()
    np.testing.assert_allclose(bias[2:], 0.05 * (1.0 - np.cos(angles[2:])), atol=1e-15)


def test_shadows_over_bands() -> None:
    rng = np.random.default_rng(2)
    current, closest = rng.random((2, 64, 1))
    band = holds(shadows.shadow, current, closest, 0.005)
    assert not band.undecided.any()
    same = shadows.shadow(Band.exact([0.5]), Band.exact([0.5]) * Band.exact([1.0]), 0.0)
    assert not same.undecided.any(), "equal depths are decided: not in shadow"
    holds(shadows.slope_bias, rng.normal(size=(64, 3)), rng.normal(size=(64, 3)), 0.005, 0.05)
    holds(shadows.shadow_coordinates, rng.random((64, 4)) + 0.5)
    nine = [Band.exact(rng.random((64, 1))) for _ in range(9)]
    band = shadows.filtered_shadow(Band.exact(current), nine)
    ninths = band.lo * 9.0
    assert np.abs(ninths - np.rint(ninths)).max() < 1e-4


def test_linear_filtering_in_numpy() -> None:
    """Against mixing written out with indices, wrapping round, over a texture of 5 × 3."""
    rng = np.random.default_rng(1)
    texels = rng.random((3, 5, 4))
    uv = rng.uniform(-1.0, 2.0, (200, 2))
    x, y = (filtering.first_texel(uv[:, k], n).astype(int) for k, n in enumerate((5.0, 3.0)))
    across, up = (filtering.weight(uv[:, k : k + 1], n) for k, n in enumerate((5.0, 3.0)))

    def texel(dx: int, dy: int) -> np.ndarray:
        return texels[(y + dy) % 3, (x + dx) % 5]

    got = filtering.bilinear(texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1), across, up)
    wide = np.pad(texels, ((3, 6), (5, 10), (0, 0)), mode="wrap")
    position = uv * (5.0, 3.0) - 0.5
    low = np.floor(position).astype(int)
    f = position - low
    expected = np.zeros_like(got)
    for dy in (0, 1):
        for dx in (0, 1):
            share = np.where(dx, f[:, 0], 1 - f[:, 0]) * np.where(dy, f[:, 1], 1 - f[:, 1])
            expected += share[:, None] * wide[low[:, 1] + dy + 3, low[:, 0] + dx + 5]
    np.testing.assert_allclose(got, expected, atol=1e-14)


def test_weights_are_as_precise_as_hardware_keeps_them() -> None:
    u = np.linspace(0.2, 0.8, 33)[:, None]
    for bits in (4, 8):
        band = filtering.weight(Band.exact(u), 4.0, bits)
        exact = filtering.weight(u.astype(np.float32).astype(float), 4.0)
        coarse = np.floor(exact * 2.0**bits) / 2.0**bits
        assert band.contains(coarse.astype(np.float32)).all()
        assert (band.hi - band.lo)[5] == pytest.approx(2.0 * 2.0**-bits, rel=1e-3)
        off = (exact + 2.5 * 2.0**-bits).astype(np.float32)
        inner = (exact > 0.2) & (exact < 0.7)
        assert not band.contains(off)[inner].any()


def test_filtering_over_bands() -> None:
    rng = np.random.default_rng(4)
    corners = [rng.random((40, 3)) for _ in range(4)]
    holds(filtering.bilinear, *corners, rng.random((40, 1)), rng.random((40, 1)))
    holds(filtering.box, *corners)
    holds(filtering.nearest_texel, rng.random((40, 1)), 8.0)
