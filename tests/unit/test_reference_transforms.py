"""The matrices against PyGLM, an implementation by other people, and against plain geometry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from pyglm import glm

from shaderlab.reference import transforms

CLOSE: Any = {"rtol": 1e-12, "atol": 1e-12}

numbers = st.floats(-50.0, 50.0).map(lambda x: round(x, 6))
angles = st.floats(-7.0, 7.0)
vectors = st.tuples(numbers, numbers, numbers)
directions = vectors.filter(lambda v: math.hypot(*v) > 0.1)


def rows(matrix: Any) -> Any:
    """A PyGLM matrix as mathematics writes it."""
    return np.array([[matrix[c][r] for c in range(4)] for r in range(4)])


@given(vectors)
def test_translate(offset: Any) -> None:
    theirs = glm.translate(glm.dvec3(*offset))
    np.testing.assert_allclose(transforms.translate(offset), rows(theirs), **CLOSE)


@given(vectors)
def test_scale(factors: Any) -> None:
    np.testing.assert_allclose(
        transforms.scale(factors), rows(glm.scale(glm.dvec3(*factors))), **CLOSE
    )


def test_scale_evenly() -> None:
    np.testing.assert_array_equal(transforms.scale(0.5), np.diag([0.5, 0.5, 0.5, 1.0]))


@given(angles, directions)
def test_rotate(angle: float, axis: Any) -> None:
    theirs = glm.rotate(angle, glm.normalize(glm.dvec3(*axis)))
    np.testing.assert_allclose(transforms.rotate(angle, axis), rows(theirs), **CLOSE)


@given(vectors, directions)
def test_look_at(eye: Any, ahead: Any) -> None:
    if math.hypot(ahead[0], ahead[2]) < 0.05:
        return  # looking along `up` has no side
    target = np.add(eye, ahead)
    theirs = glm.lookAt(glm.dvec3(*eye), glm.dvec3(*target), glm.dvec3(0, 1, 0))
    np.testing.assert_allclose(transforms.look_at(eye, target), rows(theirs), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("aspect", [0.5, 1.0, 4 / 3, 16 / 9])
@pytest.mark.parametrize("fovy", [20.0, 45.0, 100.0])
def test_perspective(fovy: float, aspect: float) -> None:
    theirs = glm.perspective(math.radians(fovy), aspect, 0.1, 100.0)
    ours = transforms.perspective(math.radians(fovy), aspect, 0.1, 100.0)
    np.testing.assert_allclose(ours, rows(theirs), rtol=1e-6)  # theirs is float32


def test_orthographic() -> None:
    theirs = glm.ortho(-3.0, 5.0, -2.0, 7.0, 1.0, 7.5)
    np.testing.assert_allclose(
        transforms.orthographic(-3, 5, -2, 7, 1, 7.5), rows(theirs), rtol=1e-6
    )


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


@given(angles, directions, directions)
def test_normals_stay_upright(angle: float, axis: Any, factors: Any) -> None:
    """A tangent and the normal stay at right angles under any model matrix."""
    if min(abs(f) for f in factors) < 0.05:
        return
    model = transforms.rotate(angle, axis) @ transforms.scale(factors)
    tangent = model[:3, :3] @ (1.0, 2.0, 0.5)
    normal = transforms.normal_matrix(model) @ (2.0, -1.0, 0.0)
    cosine = tangent @ normal / (np.linalg.norm(tangent) * np.linalg.norm(normal))
    assert abs(cosine) < 1e-9


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


@given(vectors, vectors, angles, directions)
def test_one_vertex_at_a_time_is_the_matrix(
    point: Any, other: Any, angle: float, axis: Any
) -> None:
    """What shaders compute step by step against the matrices of this module."""
    place, unit = np.array([point]), np.array(axis) / np.linalg.norm(axis)
    homogeneous = np.array([*point, 1.0])
    moved = transforms.translate(other) @ homogeneous
    np.testing.assert_allclose(
        transforms.translated(place, np.array(other), 1.0)[0], moved, **CLOSE
    )
    stretched = transforms.translate((1, 2, 3)) @ transforms.scale(other) @ homogeneous
    got = transforms.scaled(place, np.array(other), np.array([1.0, 2.0, 3.0]))[0]
    np.testing.assert_allclose(got, stretched, rtol=1e-12, atol=1e-10)
    turned = transforms.rotate(angle, axis) @ homogeneous
    np.testing.assert_allclose(
        transforms.rotated(place, unit, angle)[0], turned[:3], rtol=1e-10, atol=1e-10
    )


def test_a_direction_is_not_translated() -> None:
    got = transforms.translated(np.array([[1.0, 0.0, 0.0]]), np.array([5.0, 6.0, 7.0]), 0.0)
    np.testing.assert_array_equal(got, [[1.0, 0.0, 0.0, 0.0]])


def test_equation_3_4() -> None:
    turned = transforms.rotate(math.radians(30), (0, 0, 1)) @ (1, 2, 3, 1)
    np.testing.assert_allclose(turned[:2], (-0.133975, 2.232051), atol=5e-7)
    moved = transforms.translate((5, 6, 7)) @ turned
    np.testing.assert_allclose(moved, (4.866025, 8.232051, 10.0, 1.0), atol=5e-7)
