"""Euler angles, quaternions, coordinate spaces, rays: against PyGLM and against plain geometry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from pyglm import glm

from cases.scenes import boxes, studio
from cases.scenes.glm import glm_rows
from shaderlab.bands import Band, Rules
from shaderlab.reference import euler, quaternions, spaces, transforms

CLOSE: Any = {"rtol": 1e-9, "atol": 1e-9}

angles = st.floats(-math.pi, math.pi)
numbers = st.floats(-20.0, 20.0).map(lambda x: round(x, 6))
vectors = st.tuples(numbers, numbers, numbers)
directions = vectors.filter(lambda v: math.hypot(*v) > 0.1)


@given(angles, angles, angles, vectors)
def test_euler_angles(yaw: float, pitch: float, roll: float, point: Any) -> None:
    theirs = glm.rotate(glm.dmat4(1.0), yaw, glm.dvec3(0, 1, 0))
    theirs = glm.rotate(theirs, pitch, glm.dvec3(1, 0, 0))
    theirs = glm.rotate(theirs, roll, glm.dvec3(0, 0, 1))
    np.testing.assert_allclose(euler.euler_matrix(yaw, pitch, roll), glm_rows(theirs), **CLOSE)
    turned = euler.euler_turned(np.array([point]), yaw, pitch, roll)[0]
    np.testing.assert_allclose(turned, (glm_rows(theirs) @ (*point, 1.0))[:3], **CLOSE)


@given(angles, angles)
def test_gimbal_lock_leaves_only_a_difference(yaw: float, roll: float) -> None:
    locked = euler.euler_matrix(yaw, math.pi / 2, roll)
    np.testing.assert_allclose(euler.euler_matrix(yaw - roll, math.pi / 2, 0.0), locked, **CLOSE)


@given(angles)
def test_freedom_is_the_cosine_of_the_pitch(pitch: float) -> None:
    assert euler.gimbal_freedom(pitch) == pytest.approx(abs(math.cos(pitch)), abs=1e-12)


@given(directions, angles, vectors)
def test_quaternion_and_matrix_turn_alike(axis: Any, angle: float, point: Any) -> None:
    q = quaternions.axis_angle(axis, angle)
    matrix = transforms.rotate(angle, axis)
    np.testing.assert_allclose(quaternions.matrix_of(q), matrix, **CLOSE)
    turned = quaternions.turned(np.array([point]), q)[0]
    np.testing.assert_allclose(turned, matrix[:3, :3] @ point, rtol=1e-8, atol=1e-8)


@given(directions, angles, directions, angles)
def test_products_compose(axis: Any, angle: float, other: Any, much: float) -> None:
    p, q = quaternions.axis_angle(axis, angle), quaternions.axis_angle(other, much)
    both = quaternions.matrix_of(quaternions.product(p, q))
    np.testing.assert_allclose(both, quaternions.matrix_of(p) @ quaternions.matrix_of(q), **CLOSE)


@pytest.mark.parametrize("t", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_slerp_is_even_and_agrees_with_glm(t: float) -> None:
    a, b = quaternions.axis_angle((1, 2, 2), 0.2), quaternions.axis_angle((1, 2, 2), 1.8)
    found = quaternions.slerp(a, b, t)
    np.testing.assert_allclose(found, quaternions.axis_angle((1, 2, 2), 0.2 + 1.6 * t), **CLOSE)
    theirs = glm.slerp(glm.dquat(a[3], *a[:3]), glm.dquat(b[3], *b[:3]), t)
    np.testing.assert_allclose(found, (theirs.x, theirs.y, theirs.z, theirs.w), **CLOSE)


@given(vectors, directions, vectors)
def test_in_camera_is_the_view_matrix(eye: Any, ahead: Any, place: Any) -> None:
    if math.hypot(ahead[0], ahead[2]) < 0.05:
        return  # looking along `up` has no side
    target, up = np.add(eye, ahead), np.array([0.0, 1.0, 0.0])
    seen = spaces.in_camera(np.array([place]), np.array(eye), target, up)[0]
    expected = transforms.look_at(eye, target) @ (*place, 1.0)
    np.testing.assert_allclose(seen, expected[:3], rtol=1e-7, atol=1e-7)


@given(vectors)
def test_projections_are_their_matrices(place: Any) -> None:
    seen, point = np.array([place]), (*place, 1.0)
    lens = (math.radians(50.0), 1.5, 0.2, 70.0)
    got = spaces.perspective_clip(seen, *lens)[0]
    np.testing.assert_allclose(got, transforms.perspective(*lens) @ point, **CLOSE)
    box = (-3.0, 5.0, -2.0, 7.0, 1.0, 7.5)
    got = spaces.orthographic_clip(seen, *box)[0]
    np.testing.assert_allclose(got, transforms.orthographic(*box) @ point, **CLOSE)


def test_viewport_figures() -> None:
    viewport, whole = np.array([10.0, 20.0, 640.0, 480.0]), np.array([0.0, 1.0])
    got = spaces.window(np.array([0.5, -0.5, 0.2]), viewport, whole)
    np.testing.assert_allclose(got, (490.0, 140.0, 0.6), atol=1e-12)
    half = spaces.window(np.array([0.5, -0.5, 0.2]), viewport, np.array([0.25, 0.75]))
    assert half[2] == pytest.approx(0.55)


@given(st.floats(-100.0, -0.1))
def test_depth_and_its_slope(z: float) -> None:
    matrix = transforms.perspective(1.0, 1.0, 0.1, 100.0)
    clip = matrix @ (0.0, 0.0, z, 1.0)
    depth, slope = spaces.depth_of(z, 0.1, 100.0)
    assert depth == pytest.approx(clip[2] / clip[3], abs=1e-12)
    step = 1e-6 * abs(z)
    ends = [spaces.depth_of(z + s, 0.1, 100.0)[0] for s in (step, -step)]
    assert slope == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-3)
    assert slope < 0.0


def test_rays_and_boxes() -> None:
    camera = transforms.perspective(1.0, 1.0, 0.1, 50.0)
    behind, before = transforms.translate((0, 0, -8)), transforms.translate((0, 0, -4))
    aside = transforms.translate((9, 0, -4))
    assert boxes.nearest_box(32, 32, (64, 64), [behind, before, aside], camera) == 2
    assert boxes.nearest_box(32, 32, (64, 64), [aside], camera) == 0
    past = boxes.slab_distance(np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, 1.0]))
    assert math.isinf(past)


def test_formulas_take_bands() -> None:
    """Each gives an interval around its float64 value, and no wide one."""
    rules = Rules()
    rng = np.random.default_rng(5)
    place = rng.uniform(-2.0, 2.0, (8, 3)).astype(np.float32)
    q = quaternions.axis_angle((1, 2, 2), 1.0).astype(np.float32)
    calls = (
        (quaternions.turned, (place, q)),
        (
            spaces.in_camera,
            (place, np.float32([3, 2, 5]), np.float32([0, 1, 0]), np.float32([0, 1, 0])),
        ),
        (spaces.device, (np.concatenate([place, np.full((8, 1), 3, np.float32)], 1),)),
        (studio.studio_color, (np.abs(place) / 2.0, place)),
        (transforms.rotated, (place, np.float32([0, 0, 1]), np.float32([0.5]))),
    )
    for formula, inputs in calls:
        exact = formula(*(np.asarray(x, np.float64) for x in inputs))
        band = formula(*(Band.exact(x, rules) for x in inputs))
        assert np.all((band.lo <= exact) & (exact <= band.hi)), formula.__name__
        assert float(np.max(band.hi - band.lo)) < 0.02, formula.__name__
