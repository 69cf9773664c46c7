"""Depth, shadows and filtering: printed figures, laws, and the same formulas over bands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from shaderlab.bands import Band
from shaderlab.reference import depth, filtering, shadows
from shaderlab.reference.transforms import look_at, orthographic


def holds(formula: Any, *inputs: Any) -> Band:
    """The formula's band of these inputs, which must hold its own float64 value."""
    arrays = [np.atleast_1d(np.asarray(x, np.float32)) for x in inputs]
    band = formula(*(Band.exact(x) for x in arrays))
    exact = formula(*(x.astype(np.float64) for x in arrays))
    assert band.contains(np.asarray(exact, np.float32)).all()
    assert not band.vacuous.any()
    return band


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
