"""Lighting in float64: the catalogue's figures typed again, and laws that must hold."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from cases.scenes.chest import chest_diffuse, chest_specular
from cases.scenes.normal_rods import rods
from cases.scenes.plaza import plaza
from cases.scenes.pottery import vase
from shaderlab.reference import light_sources, lighting, microfacets, tone_mapping

UP = np.array([0.0, 0.0, 1.0])
ORIGIN, LAMP, EYE = np.zeros(3), np.array([1.2, 1.0, 2.0]), np.array([0.0, 0.0, 3.0])
CORAL, WHITE, DARK = np.array([1.0, 0.5, 0.31]), np.ones(3), np.zeros(3)
SURFACE = (ORIGIN, UP, CORAL, EYE, 0.5 * WHITE, 32.0)


def test_the_point_of_the_notes() -> None:
    diff = 2.0 / math.sqrt(6.44)
    assert lighting.diffuse_factor(ORIGIN, UP, LAMP).item() == pytest.approx(diff, rel=1e-12)
    spec = lighting.specular_factor(ORIGIN, UP, LAMP, EYE, 32.0).item()
    assert spec == pytest.approx(diff**32, rel=1e-12)
    lit = lighting.phong_color(ORIGIN, UP, LAMP, EYE, WHITE, CORAL, 0.1, 1.0, 0.5, 32.0)
    assert lit[:3] == pytest.approx([0.888356, 0.444178, 0.275390], abs=5e-7)
    lit = lighting.lit_material(
        ORIGIN, UP, EYE, CORAL, CORAL, 0.5 * WHITE, 32.0, LAMP, WHITE, WHITE, WHITE
    )
    assert lit[:3] == pytest.approx([1.788356, 0.894301, 0.554560], abs=5e-7)


def test_light_from_behind_adds_nothing_but_the_ambient_part() -> None:
    behind = -LAMP
    assert lighting.diffuse_factor(ORIGIN, UP, behind).item() == 0.0
    lit = lighting.diffuse_color(ORIGIN, UP, behind, WHITE, CORAL, 0.1)
    assert lit[:3] == pytest.approx(0.1 * CORAL)


@pytest.mark.parametrize(("shininess", "angle"), [(2, 45.0), (32, 11.882461), (256, 4.214387)])
def test_half_of_the_lobe_is_left_at_the_half_power_angle(shininess: int, angle: float) -> None:
    assert lighting.half_power_angle(shininess) == pytest.approx(angle, abs=5e-7)
    assert math.cos(math.radians(angle)) ** shininess == pytest.approx(0.5, abs=1e-6)


@given(st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_light_is_linear(one: float, other: float) -> None:
    def lit(strength: float) -> Any:
        color = strength * WHITE
        return light_sources.point(*SURFACE, LAMP, 1.0, 0.09, 0.032, color, color, color)

    assert lit(one) + lit(other) == pytest.approx(lit(one + other), rel=1e-9, abs=1e-12)


def test_a_far_point_light_is_a_directional_one() -> None:
    far = 1.0e7 * LAMP
    sun = light_sources.directional(*SURFACE, -LAMP, 0.1 * WHITE, WHITE, WHITE)
    lamp = light_sources.point(*SURFACE, far, 1.0, 0.0, 0.0, 0.1 * WHITE, WHITE, WHITE)
    assert lamp == pytest.approx(sun, rel=1e-9)


@pytest.mark.parametrize(("degrees", "inside"), [(12.4, True), (12.6, False), (90.0, False)])
def test_a_hard_spot_is_all_or_nothing(degrees: float, inside: bool) -> None:
    aside = np.cross(LAMP, UP) / np.linalg.norm(np.cross(LAMP, UP))
    turn = math.radians(degrees)
    axis = -math.cos(turn) * LAMP / np.linalg.norm(LAMP) + math.sin(turn) * aside
    cut_off = math.cos(math.radians(12.5))
    lit = light_sources.hard_spot(*SURFACE, LAMP, axis, cut_off, 0.2 * WHITE, WHITE, WHITE)
    without = light_sources.hard_spot(*SURFACE, LAMP, axis, cut_off, 0.2 * WHITE, DARK, DARK)
    assert bool(np.any(lit != without)) == inside
    assert without == pytest.approx(0.2 * CORAL)


def test_a_soft_spot_is_a_point_light_inside_and_ambient_outside() -> None:
    fading, colors = (1.0, 0.09, 0.032), (0.2 * WHITE, WHITE, WHITE)
    point = light_sources.point(*SURFACE, LAMP, *fading, *colors)
    spot = light_sources.soft_spot(*SURFACE, LAMP, -LAMP, 0.95, 0.9, *fading, *colors)
    assert spot == pytest.approx(point)
    away = light_sources.soft_spot(*SURFACE, LAMP, LAMP, 0.95, 0.9, *fading, *colors)
    left = light_sources.fading(ORIGIN, LAMP, *fading)
    assert away == pytest.approx(left * 0.2 * CORAL)


@given(st.floats(0.0, 1e6), st.floats(0.01, 10.0))
def test_tone_curves_stay_below_one_and_keep_the_order(light: float, exposure: float) -> None:
    brighter = 1.01 * light + 1e-9
    assert 0.0 <= tone_mapping.reinhard(light) < tone_mapping.reinhard(brighter) < 1.0
    low, high = (float(tone_mapping.exposed(x, exposure)) for x in (light, brighter))
    assert 0.0 <= low <= high <= 1.0
    # x/(1+x) is undone by y/(1−y), so nothing was lost.
    y = tone_mapping.reinhard(light)
    assert y / (1.0 - y) == pytest.approx(light, rel=1e-6, abs=1e-9)


def test_fresnel_and_geometry_run_between_their_limits() -> None:
    cosines = np.linspace(0.0, 1.0, 101)[:, None]
    reflected = microfacets.fresnel(cosines, 0.04)
    assert np.all(np.diff(reflected[:, 0]) <= 0.0)
    assert (reflected[0, 0], reflected[-1, 0]) == pytest.approx((1.0, 0.04))
    seen = microfacets.geometry(cosines, 0.7, 0.5)
    assert np.all(np.diff(seen[:, 0]) > 0.0)
    assert seen.min() >= 0.0 and seen.max() < 1.0


@pytest.mark.parametrize("roughness", [0.2, 0.5, 1.0])
def test_no_more_light_comes_out_than_goes_in(roughness: float) -> None:
    """A white metal in light from everywhere, by a sum over the hemisphere. What is missing below
    1 was reflected a second time, which the formula leaves out."""
    steps = 160
    tilt, around = np.meshgrid(
        (np.arange(steps) + 0.5) / steps * math.pi / 2.0,
        (np.arange(2 * steps) + 0.5) / steps * math.pi,
    )
    light = np.stack(
        [np.sin(tilt) * np.cos(around), np.sin(tilt) * np.sin(around), np.cos(tilt)], -1
    ).reshape(-1, 3)
    weight = (np.sin(tilt) * (math.pi / steps) * (math.pi / 2.0 / steps)).reshape(-1, 1)
    for slant in (0.0, 0.6, 1.2):
        view = np.array([math.sin(slant), 0.0, math.cos(slant)])
        out = microfacets.radiance(UP, view, light, WHITE, 1.0, roughness)
        total = float((out * weight).sum(axis=0)[0])
        assert 0.25 < total <= 1.0 + 1e-3


def test_a_chest_shines_where_it_is_iron() -> None:
    color, shine = chest_diffuse(64), chest_specular(64)
    assert color.shape == shine.shape == (64, 64, 4)
    assert color.min() >= 0.0 and max(color.max(), shine.max()) <= 1.0
    wood = color[..., 0] > 2.0 * color[..., 2]
    assert 0.3 < wood.mean() < 0.7
    assert shine[wood, 0].max() < 0.1 < np.median(shine[~wood, 0])


@pytest.mark.parametrize("solid", [plaza(tiles=4, segments=12), vase(segments=16, rings=24)])
def test_solids_face_outward(solid: Any) -> None:
    attributes = {k: v.astype(float) for k, v in solid["attributes"].items()}
    corners = solid["indices"].reshape(-1, 3)
    a, b, c = (attributes["aPos"][corners[:, k]] for k in range(3))
    facing = np.cross(b - a, c - a)
    normal = attributes["aNormal"][corners].sum(axis=1)
    real = np.linalg.norm(facing, axis=1) > 1e-9
    assert real.mean() > 0.9
    assert np.mean(np.sum(facing * normal, axis=1)[real] > 0.0) > 0.97


def test_rods_stand_where_the_model_puts_the_ball() -> None:
    model = np.diag([1.0, 0.5, 1.0, 1.0])
    made = rods(model, lambda normal: normal, length=0.2, rows=2, columns=4, thickness=0.01)
    low, high = made["attributes"]["aPos"].min(axis=0), made["attributes"]["aPos"].max(axis=0)
    assert len(made["indices"]) == 8 * 36
    assert np.all(high <= [1.3, 0.75, 1.3]) and np.all(low >= [-1.3, -0.75, -1.3])
