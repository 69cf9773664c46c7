"""Euler angles, quaternions, coordinate spaces, rays: against PyGLM and against plain geometry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from cases.scenes import boxes, studio
from shaderlab.bands import Band, Rules
from shaderlab.reference import euler, quaternions, spaces, transforms

CLOSE: Any = {"rtol": 1e-9, "atol": 1e-9}

angles = st.floats(-math.pi, math.pi)
numbers = st.floats(-20.0, 20.0).map(lambda x: round(x, 6))
vectors = st.tuples(numbers, numbers, numbers)
directions = vectors.filter(lambda v: math.hypot(*v) > 0.1)


@given(angles, angles)
def test_gimbal_lock_leaves_only_a_difference(yaw: float, roll: float) -> None:
    locked = euler.euler_matrix(yaw, math.pi / 2, roll)
    np.testing.assert_allclose(euler.euler_matrix(yaw - roll, math.pi / 2, 0.0), locked, **CLOSE)


def test_viewport_figures() -> None:
    viewport, whole = np.array([10.0, 20.0, 640.0, 480.0]), np.array([0.0, 1.0])
    got = spaces.window(np.array([0.5, -0.5, 0.2]), viewport, whole)
    np.testing.assert_allclose(got, (490.0, 140.0, 0.6), atol=1e-12)
    half = spaces.window(np.array([0.5, -0.5, 0.2]), viewport, np.array([0.25, 0.75]))
    assert half[2] == pytest.approx(0.55)


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
