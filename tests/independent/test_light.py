"""Light, materials and colour against geometry, integrals and other people's libraries."""

from __future__ import annotations

import math
from typing import Any

import colour
import numpy as np
import pytest
from hypothesis import assume, given, strategies as st
from pyglm import glm

from cases.scenes import furnace
from shaderlab.reference import (
    attenuation as fade,
    gamma,
    light_maps,
    light_sources,
    lighting,
    microfacets,
    spotlight,
    tone_mapping,
)
from tests.independent.against import against

numbers = st.floats(-5.0, 5.0).map(lambda x: round(x, 4))
vectors = st.tuples(numbers, numbers, numbers)
directions = vectors.filter(lambda v: math.hypot(*v) > 0.1)
coefficients = st.floats(0.001, 2.0)
UP = np.array([0.0, 0.0, 1.0])


def angle(a: Any, b: Any) -> float:
    """The angle between two vectors, from the area and the projection, without a unit vector."""
    return math.atan2(float(np.linalg.norm(np.cross(a, b))), float(np.dot(a, b)))


def turned_by_half(v: Any, axis: Any) -> Any:
    """A vector turned by 180° around an axis, by a quaternion: a mirror's reflection, reversed."""
    q = glm.angleAxis(math.pi, glm.normalize(glm.dvec3(*axis)))
    return np.array(q * glm.dvec3(*v))


def raised(away: float, shininess: float) -> float:
    """The cosine of an angle, raised to a power; 0 from a right angle on."""
    return math.cos(away) ** shininess if away < math.pi / 2.0 else 0.0


def faces(normal: Any, light: Any) -> bool:
    """Whether the lamp is above the surface's horizon, which it may not lie on."""
    assume(abs(angle(normal, light) - math.pi / 2.0) > 1e-9)
    return angle(normal, light) < math.pi / 2.0


def lobe_by_angle(normal: Any, light: Any, view: Any, shininess: float) -> float:
    """Phong's highlight from the angle between the viewer and the mirrored lamp."""
    lit = faces(normal, light)
    return raised(angle(turned_by_half(light, normal), view), shininess) if lit else 0.0


def lambert_by_angle(normal: Any, light: Any) -> float:
    """The share of a beam that a tilted surface catches, from its angle."""
    return max(math.cos(angle(normal, light)), 0.0)


@against("the polynomial fitted to 1/F, whose coefficients come back", fade.attenuation)
@against("the roots of that polynomial (numpy.roots)", fade.reach, fade.crossover)
@given(coefficients, coefficients, coefficients, st.floats(0.01, 0.9))
def test_attenuation(constant: float, linear: float, quadratic: float, share: float) -> None:
    d = np.linspace(0.0, 10.0, 7)
    fitted = np.polyfit(d, 1.0 / fade.attenuation(d, constant, linear, quadratic), 2)
    np.testing.assert_allclose(fitted, (quadratic, linear, constant), rtol=1e-6, atol=1e-9)
    share = min(share, 0.99 / constant)
    roots = np.roots([quadratic, linear, constant - 1.0 / share])
    reach = fade.reach(share, constant, linear, quadratic)
    assert min(abs(roots - reach)) < 1e-6 * max(reach, 1.0)
    crossing = np.roots([quadratic, -linear, 0.0]).real.max()
    assert fade.crossover(linear, quadratic) == pytest.approx(crossing)


@against("angles by atan2, mirrored by a half turn of PyGLM's quaternion", lighting.phong,
         lighting.diffuse, lighting.blinn, lighting.lobe, lighting.mirrored_lobe,
         lighting.halfway_lobe, lighting.gated)  # fmt: skip
@given(directions, directions, directions, st.sampled_from([1.0, 2.0, 8.0, 32.0]))
def test_lobes(normal: Any, light: Any, view: Any, shininess: float) -> None:
    n, l, v = (np.array(part) for part in (normal, light, view))  # noqa: E741
    close = {"rel": 1e-6, "abs": 1e-9}
    assert lighting.diffuse(n, l).item() == pytest.approx(lambert_by_angle(n, l), **close)
    lit = faces(n, l)
    expected = raised(angle(turned_by_half(l, n), v), shininess)
    assert lighting.mirrored_lobe(n, l, v, shininess).item() == pytest.approx(expected, **close)
    expected = lobe_by_angle(n, l, v, shininess)
    assert lighting.gated(math.cos(angle(n, l)), expected).item() == pytest.approx(expected)
    assert lighting.phong(n, l, v, shininess).item() == pytest.approx(expected, **close)
    if not 1e-4 < angle(l, v) < math.pi - 0.01:
        return  # no plane to turn in
    halfway = np.array(glm.slerp(glm.normalize(glm.dvec3(*l)), glm.normalize(glm.dvec3(*v)), 0.5))
    away = angle(n, halfway)
    expected = raised(away, shininess)
    assert lighting.halfway_lobe(n, l, v, shininess).item() == pytest.approx(expected, **close)
    lit_share = expected if lit else 0.0
    assert lighting.blinn(n, l, v, shininess).item() == pytest.approx(lit_share, **close)
    assert float(lighting.lobe(math.cos(away), shininess)) == pytest.approx(expected, **close)


@against("the angle at which the lobe, sampled, crosses one half", lighting.half_power_angle)
@pytest.mark.parametrize("shininess", [2.0, 32.0, 256.0])
def test_half_power(shininess: float) -> None:
    degrees = np.linspace(0.0, 89.0, 200_001)
    lobe = np.cos(np.radians(degrees)) ** shininess
    assert lighting.half_power_angle(shininess) == pytest.approx(
        np.interp(-0.5, -lobe, degrees), abs=1e-5
    )


@against("angles by atan2 and sums by hand, channel by channel", lighting.diffuse_factor,
         lighting.specular_factor, lighting.ambient_color, lighting.reflected_color,
         lighting.diffuse_color, lighting.phong_color, lighting.lit_material)  # fmt: skip
@given(vectors, directions, directions, directions)
def test_a_lit_fragment(place: Any, normal: Any, to_lamp: Any, to_eye: Any) -> None:
    where, n = np.array(place), np.array(normal)
    lamp, eye = where + to_lamp, where + to_eye
    light, surface = np.array([0.9, 0.7, 0.2]), np.array([0.25, 0.5, 1.0])
    caught = lambert_by_angle(n, to_lamp)
    shine = lobe_by_angle(n, np.array(to_lamp), np.array(to_eye), 16.0)
    close = {"rtol": 1e-6, "atol": 1e-9}
    np.testing.assert_allclose(lighting.diffuse_factor(where, n, lamp), [caught], **close)
    np.testing.assert_allclose(
        lighting.specular_factor(where, n, lamp, eye, 16.0), [shine], **close
    )
    channels = [float(a) * float(b) for a, b in zip(light, surface, strict=True)]
    np.testing.assert_allclose(lighting.reflected_color(light, surface)[:3], channels, **close)
    ambient = lighting.ambient_color(light, surface, 0.1)
    np.testing.assert_allclose(ambient[:3], [0.1 * c for c in channels], **close)
    lit = lighting.diffuse_color(where, n, lamp, light, surface, 0.1)
    np.testing.assert_allclose(lit[:3], [(0.1 + caught) * c for c in channels], **close)
    lit = lighting.phong_color(where, n, lamp, eye, light, surface, 0.1, 0.8, 0.5, 16.0)
    total = 0.1 + 0.8 * caught + 0.5 * shine
    np.testing.assert_allclose(lit[:3], [total * c for c in channels], **close)
    lit = lighting.lit_material(
        where, n, eye, 0.3 * surface, surface, light, 16.0, lamp, 0.2 * light, light, light
    )
    total = [
        float(k * s) * (0.3 * 0.2 + caught) + float(k * k) * shine
        for k, s in zip(light, surface, strict=True)
    ]
    np.testing.assert_allclose(lit[:3], total, **close)


def shaded(n: Any, to_light: Any, to_eye: Any, surface: Any, shine: Any, lamp: Any) -> Any:
    """Diffuse and specular part by angles, of a lamp with the same colour for both."""
    lobe = lobe_by_angle(n, np.array(to_light), np.array(to_eye), 8.0)
    return lamp * (lambert_by_angle(n, to_light) * surface + lobe * shine)


@against("angles by atan2, and the polynomial of the attenuation", light_sources.directed,
         light_sources.direction_to_light, light_sources.directional, light_sources.fading,
         light_sources.point, light_sources.points, light_sources.hard_spot,
         light_sources.soft_spot)  # fmt: skip
@given(vectors, directions, directions, directions, directions)
def test_light_sources(place: Any, normal: Any, to_lamp: Any, to_eye: Any, axis: Any) -> None:
    where, n = np.array(place), np.array(normal)
    lamp, eye = where + to_lamp, where + to_eye
    surface, shine, color = (
        np.array([0.25, 0.5, 1.0]),
        np.array([0.5] * 3),
        np.array([0.9, 0.7, 0.2]),
    )
    close = {"rtol": 1e-6, "atol": 1e-9}
    fragment = (where, n, surface, eye, shine, 8.0)
    part = shaded(n, to_lamp, to_eye, surface, shine, color)
    ambient = 0.1 * color * surface
    got = light_sources.directed(
        np.array(to_lamp), np.array(to_eye), n, surface, shine, 8.0, color, color
    )
    np.testing.assert_allclose(got, part, **close)
    unit = light_sources.direction_to_light(np.array(axis))
    assert angle(unit, axis) == pytest.approx(math.pi) and np.hypot.reduce(unit) == pytest.approx(1)
    got = light_sources.directional(*fragment, -np.array(to_lamp), 0.1 * color, color, color)
    np.testing.assert_allclose(got, ambient + part, **close)
    far = math.dist(where, lamp)
    left = 1.0 / np.polyval([0.032, 0.09, 1.0], far)
    fading = light_sources.fading(where, lamp, 1.0, 0.09, 0.032)
    np.testing.assert_allclose(fading, [left], **close)
    lit = light_sources.point(*fragment, lamp, 1.0, 0.09, 0.032, 0.1 * color, color, color)
    np.testing.assert_allclose(lit, left * (ambient + part), **close)
    columns = ([1.0] * 2, [0.09] * 2, [0.032] * 2, [0.1 * color] * 2, [color] * 2, [color] * 2)
    twice = light_sources.points(*fragment, [lamp, lamp], *columns)
    np.testing.assert_allclose(twice, 2.0 * left * (ambient + part), **close)
    off_axis = angle(axis, -np.array(to_lamp))
    if abs(off_axis - 0.5) > 1e-6:
        hard = light_sources.hard_spot(
            *fragment, lamp, np.array(axis), math.cos(0.5), 0.1 * color, color, color
        )
        np.testing.assert_allclose(hard, ambient + (part if off_axis < 0.5 else 0.0), **close)
    cone = np.interp(math.cos(off_axis), [math.cos(0.6), math.cos(0.4)], [0.0, 1.0])
    soft = light_sources.soft_spot(
        *fragment, lamp, np.array(axis), math.cos(0.4), math.cos(0.6), 1.0, 0.09, 0.032,
        0.1 * color, color, color,
    )  # fmt: skip
    np.testing.assert_allclose(soft, left * (ambient + cone * part), **close)


@against("angles by atan2 and numpy.interp between the cosines", spotlight.spot_cosine,
         spotlight.ratio_of_cosines, spotlight.spot_ratio, spotlight.spot_intensity)  # fmt: skip
@given(vectors, directions, directions, st.floats(0.1, 0.7), st.floats(0.05, 0.7))
def test_spotlight(place: Any, to_lamp: Any, axis: Any, inner: float, soft: float) -> None:
    where, lamp = np.array(place), np.add(place, to_lamp)
    theta = math.cos(angle(axis, -np.array(to_lamp)))
    outer_cosine, inner_cosine = math.cos(inner + soft), math.cos(inner)
    cone = (np.array(axis), inner_cosine, outer_cosine)
    assert spotlight.spot_cosine(where, lamp, cone[0]).item() == pytest.approx(theta, abs=1e-7)
    share = np.interp(theta, [outer_cosine, inner_cosine], [0.0, 1.0])
    assert spotlight.spot_intensity(where, lamp, *cone).item() == pytest.approx(share, abs=1e-5)
    line = np.polyfit([outer_cosine, inner_cosine], [0.0, 1.0], 1)
    ratio = float(spotlight.ratio_of_cosines(theta, inner_cosine, outer_cosine))
    assert ratio == pytest.approx(np.polyval(line, theta), rel=1e-6, abs=1e-6)
    assert spotlight.spot_ratio(where, lamp, *cone).item() == pytest.approx(ratio, abs=1e-5)


@against("the solid angle of a small square (A. van Oosterom, J. Strackee, 1983)", light_maps.baked)
@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_irradiance_is_intensity_by_solid_angle(x: float, y: float) -> None:
    lamp, half = np.array([0.3, -0.4, 1.5]), 0.5e-3
    around = ((-half, -half), (half, -half), (half, half), (-half, half))
    corners = [np.array([x + dx, y + dy, 0.0]) - lamp for dx, dy in around]

    def triangle(a: Any, b: Any, c: Any) -> float:
        la, lb, lc = (float(np.linalg.norm(v)) for v in (a, b, c))
        below = la * lb * lc + a @ b * lc + a @ c * lb + b @ c * la
        return 2.0 * math.atan2(abs(float(np.linalg.det([a, b, c]))), float(below))

    solid = triangle(*corners[:3]) + triangle(corners[0], *corners[2:])
    expected = 7.0 * solid / (2.0 * half) ** 2
    got = light_maps.baked(np.array([x, y]), lamp, 7.0)
    assert np.asarray(got).item() == pytest.approx(expected, rel=1e-5)


@against("colour-science's gamma_function", gamma.gamma_encode)
@against("colour-science's eotf_sRGB and its inverse", gamma.srgb_encode, gamma.srgb_decode)
def test_transfer_curves() -> None:
    values = np.linspace(0.001, 1.0, 1001)
    for power in (1.0, 2.2, 2.4):
        expected = colour.gamma_function(values, 1.0 / power)
        np.testing.assert_allclose(gamma.gamma_encode(values, power), expected, rtol=1e-12)
    encoded = colour.models.eotf_inverse_sRGB(values)
    np.testing.assert_allclose(gamma.srgb_encode(values), encoded, atol=2e-15)
    np.testing.assert_allclose(gamma.srgb_decode(encoded), values, atol=1e-8)


@against("the ordinary differential equation of a film that saturates, solved step by step",
         tone_mapping.exposed)  # fmt: skip
@against("its inverse y / (1 − y), and numpy.clip", tone_mapping.reinhard, tone_mapping.clipped)
def test_tone_curves() -> None:
    steps = np.linspace(0.0, 4.0, 40_001)
    density = 0.0
    for _ in steps[1:]:  # what is not yet exposed is exposed at a rate of 1.5
        half = density + 0.5 * 1e-4 * 1.5 * (1.0 - density)
        density += 1e-4 * 1.5 * (1.0 - half)
    assert float(tone_mapping.exposed(4.0, 1.5)) == pytest.approx(density, rel=1e-7)
    light = np.array([0.0, 0.25, 1.0, 9.0])
    dark = tone_mapping.reinhard(light)
    np.testing.assert_allclose(dark / (1.0 - dark), light, rtol=1e-12)
    np.testing.assert_array_equal(tone_mapping.clipped(light), np.clip(light, 0.0, 1.0))


def hemisphere(steps: int) -> tuple[Any, Any]:
    """Directions around +z (n, 3), and the solid angle of each (n,), by the midpoint rule."""
    height = (np.arange(steps) + 0.5) / steps
    around = (np.arange(2 * steps) + 0.5) * math.pi / steps
    z, phi = (part.ravel() for part in np.meshgrid(height, around))
    flat = np.sqrt(1.0 - z * z)
    solid = np.full(z.shape, math.pi / steps / steps)
    return np.stack([flat * np.cos(phi), flat * np.sin(phi), z], -1), solid


@against("the normals of an ellipsoid: 1 / curvature (B. Walter et al., 2007)",
         microfacets.distribution, microfacets.distribution_of, microfacets.distribution_either,
         microfacets.facing_share)  # fmt: skip
@pytest.mark.parametrize("roughness", [0.4, 0.7, 1.0])
def test_microfacets_are_the_normals_of_an_ellipsoid(roughness: float) -> None:
    """GGX has the normals of an ellipsoid of height α over its unit circle, seen from above: a
    direction's share is the area with that normal, 1 / Gaussian curvature, over the circle's π."""
    alpha = roughness * roughness
    tilt = np.linspace(0.0, 1.5, 31)
    n = np.stack([np.sin(tilt), 0.0 * tilt, np.cos(tilt)], -1)
    semi = np.array([1.0, 1.0, alpha])
    support = np.sqrt(((semi * n) ** 2).sum(-1))  # the distance of the tangent plane
    curvature = support**4 / np.prod(semi) ** 2
    found = microfacets.distribution(n[:, 2], roughness)
    np.testing.assert_allclose(found, 1.0 / curvature / math.pi, rtol=1e-9)
    for formula in (microfacets.distribution_of, microfacets.distribution_either):
        np.testing.assert_allclose(formula(UP, n, roughness)[:, 0], found, rtol=1e-9)
    directions_, solid = hemisphere(400)
    share = (
        microfacets.distribution(directions_[:, 2], roughness) * directions_[:, 2] * solid
    ).sum()
    assert microfacets.facing_share(roughness) == pytest.approx(share, rel=5e-3)


@against("Smith's condition on the visible area, integrated (E. Heitz, 2014, equation 16)",
         microfacets.masking)  # fmt: skip
@pytest.mark.parametrize("roughness", [0.5, 0.8])
@pytest.mark.parametrize("slant", [0.2, 0.8, 1.3])
def test_what_is_not_masked_covers_the_view(roughness: float, slant: float) -> None:
    view = np.array([math.sin(slant), 0.0, math.cos(slant)])
    facets, solid = hemisphere(500)
    facing = np.clip(facets @ view, 0.0, None)
    seen = (microfacets.distribution(facets[:, 2], roughness) * facing * solid).sum()
    got = float(microfacets.masking(view[2], roughness))
    assert got == pytest.approx(view[2] / seen, rel=5e-3)


@against("its reciprocal, a straight line in 1 / cosine, with k as printed (B. Karis, 2013)",
         microfacets.shadowing, microfacets.shadowing_under_sky, microfacets.geometry)  # fmt: skip
def test_schlick_s_shadowing_is_a_line_in_the_reciprocal() -> None:
    cosine = np.linspace(0.05, 1.0, 20)
    for formula, k in (
        (microfacets.shadowing, (0.5 + 1.0) ** 2 / 8.0),
        (microfacets.shadowing_under_sky, 0.5**2 / 2.0),
    ):
        slope, start = np.polyfit(1.0 / cosine, 1.0 / formula(cosine, 0.5), 1)
        assert (slope, start) == pytest.approx((k, 1.0 - k))
    both = microfacets.geometry(cosine, 1.0, 0.5)
    np.testing.assert_allclose(both, microfacets.shadowing(cosine, 0.5), rtol=1e-12)


def exact_fresnel(cosine: Any, index: float) -> Any:
    """Fresnel's equations for unpolarised light on glass."""
    inside = np.sqrt(1.0 - (1.0 - cosine * cosine) / index**2)
    s = (cosine - index * inside) / (cosine + index * inside)
    p = (inside - index * cosine) / (inside + index * cosine)
    return 0.5 * (s * s + p * p)


@against("Fresnel's own equations at index 1.5, to 0.04 (Schlick's is an approximation)",
         microfacets.fresnel, microfacets.base_reflectance)  # fmt: skip
def test_schlick_is_close_to_fresnel() -> None:
    cosine = np.linspace(0.0, 1.0, 101)
    approximate = microfacets.fresnel(cosine, ((1.5 - 1.0) / (1.5 + 1.0)) ** 2)
    assert np.abs(approximate - exact_fresnel(cosine, 1.5)).max() < 0.04
    steps = np.log((approximate[1:-1] - 0.04) / 0.96) / np.log(1.0 - cosine[1:-1])
    np.testing.assert_allclose(steps, 5.0, rtol=1e-7)  # the power of 1 − cosine
    glass = float(exact_fresnel(np.array(1.0), 1.5))
    assert float(np.ravel(microfacets.base_reflectance(0.9, 0.0))[0]) == pytest.approx(glass)
    assert float(np.ravel(microfacets.base_reflectance(0.9, 1.0))[0]) == pytest.approx(0.9)


@against("Helmholtz's reciprocity: lamp and viewer can be exchanged", microfacets.radiance)
@given(st.floats(0.0, 1.3), st.floats(0.0, 1.3), st.floats(0.0, 3.1))
def test_light_goes_both_ways(one: float, other: float, around: float) -> None:
    a = np.array([math.sin(one), 0.0, math.cos(one)])
    flat = math.sin(other)
    b = np.array([flat * math.cos(around), flat * math.sin(around), math.cos(other)])
    metal = np.array([0.9, 0.6, 0.3])
    forth = microfacets.radiance(UP, a, b, metal, 1.0, 0.5) / b[2]
    back = microfacets.radiance(UP, b, a, metal, 1.0, 0.5) / a[2]
    np.testing.assert_allclose(forth, back, rtol=1e-9)


def test_the_white_furnace_by_directions_of_light_chosen_at_random() -> None:
    """The lesson's figures: the integral, and what its few halfway vectors give too much."""
    normal_view, roughness = 0.7, 0.5
    # One direction in each of 1000 × 1000 equal parts of the hemisphere.
    parts, chosen = np.indices((1000, 1000)), np.random.default_rng(513)
    cosine, share = ((part.ravel() + chosen.random(part.size)) / 1000.0 for part in parts)
    turn = 2.0 * math.pi * share
    sine = np.sqrt(1.0 - cosine * cosine)
    light = np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=-1)
    view = np.array([math.sqrt(1.0 - normal_view**2), 0.0, normal_view])
    half = light + view
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    # D by the slope of the microfacets, G by Smith's Λ: the forms of Walter et al., not ours.
    slope2 = 1.0 / half[:, 2] ** 2 - 1.0
    alpha2 = roughness**4
    d = alpha2 / (math.pi * half[:, 2] ** 4 * (alpha2 + slope2) ** 2)

    def masked(c: Any) -> Any:
        return 1.0 / (1.0 + 0.5 * (np.sqrt(1.0 + alpha2 * (1.0 / c**2 - 1.0)) - 1.0))

    found = 2.0 * math.pi * d * masked(cosine) * masked(normal_view) / (4.0 * normal_view)
    assert found.mean() == pytest.approx(0.884792, abs=1e-4)
    few = furnace.reflected_share(normal_view, roughness, microfacets.masking, 16, RING)
    assert few.item() == pytest.approx(0.893975, abs=1e-6)


RING = np.cos((np.arange(8) + 0.5) / 8.0 * np.pi)
