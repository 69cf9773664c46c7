"""The matrices against PyGLM, an implementation by other people, and against plain geometry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from shaderlab.reference import transforms

CLOSE: Any = {"rtol": 1e-12, "atol": 1e-12}

numbers = st.floats(-50.0, 50.0).map(lambda x: round(x, 6))
angles = st.floats(-7.0, 7.0)
vectors = st.tuples(numbers, numbers, numbers)
directions = vectors.filter(lambda v: math.hypot(*v) > 0.1)


def test_scale_evenly() -> None:
    np.testing.assert_array_equal(transforms.scale(0.5), np.diag([0.5, 0.5, 0.5, 1.0]))


def test_planes_land_on_minus_and_plus_one() -> None:
    for matrix in (
        transforms.perspective(math.radians(45), 4 / 3, 0.1, 100.0),
        transforms.orthographic(-1, 1, -1, 1, 0.1, 100.0),
    ):
        near, far = matrix @ (0, 0, -0.1, 1), matrix @ (0, 0, -100.0, 1)
        assert near[2] / near[3] == pytest.approx(-1.0, abs=1e-12)
        assert far[2] / far[3] == pytest.approx(1.0, abs=1e-12)


def test_the_notes_corner() -> None:
    inputs = (
        np.array([[0.5, 0.5, 0.0]]),
        transforms.rotate(math.radians(-55), (1, 0, 0)) @ transforms.scale(0.5),
        transforms.translate((0, 0, -3)),
        transforms.perspective(math.radians(45), 4 / 3, 0.1, 100.0),
    )
    clip = transforms.clip_position(*inputs)
    np.testing.assert_allclose(clip[0], (0.452665, 0.346184, 3.011004, 3.204788), atol=5e-7)
    device = transforms.device_position(*inputs)
    np.testing.assert_allclose(device[0], (0.141246, 0.108021, 0.939533), atol=5e-7)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: transforms.rotate(1.0, (0, 0, 0)), "axis has no direction"),
        (lambda: transforms.look_at((1, 1, 1), (1, 1, 1)), "target − eye has no direction"),
        (lambda: transforms.look_at((0, 0, 0), (0, 1, 0)), "forward × up has no direction"),
        (lambda: transforms.perspective(1.0, 1.0, 0.0, 10.0), "0 < near < far"),
        (lambda: transforms.perspective(1.0, 1.0, 5.0, 5.0), "0 < near < far"),
    ],
)
def test_what_has_no_matrix(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()


def test_a_direction_is_not_translated() -> None:
    got = transforms.translated(np.array([[1.0, 0.0, 0.0]]), np.array([5.0, 6.0, 7.0]), 0.0)
    np.testing.assert_array_equal(got, [[1.0, 0.0, 0.0, 0.0]])


def test_equation_3_4() -> None:
    turned = transforms.rotate(math.radians(30), (0, 0, 1)) @ (1, 2, 3, 1)
    np.testing.assert_allclose(turned[:2], (-0.133975, 2.232051), atol=5e-7)
    moved = transforms.translate((5, 6, 7)) @ turned
    np.testing.assert_allclose(moved, (4.866025, 8.232051, 10.0, 1.0), atol=5e-7)
