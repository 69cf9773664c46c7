"""Transforms, spaces, rotations, cameras and depth against PyGLM, and against plain geometry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from pyglm import glm

from shaderlab.reference import (
    cascades,
    cube_maps,
    depth,
    euler,
    quaternions,
    shadows,
    spaces,
    tangent_space,
    transforms,
)
from tests.independent.against import against

CLOSE: Any = {"rtol": 1e-5, "atol": 1e-5}
numbers = st.floats(-9.0, 9.0).map(lambda x: round(x, 4))
vectors = st.tuples(numbers, numbers, numbers)
directions = vectors.filter(lambda v: math.hypot(*v) > 0.1)
angles = st.floats(-3.0, 3.0)


def rows(matrix: Any) -> Any:
    """A PyGLM matrix as mathematics writes it."""
    return np.array([[matrix[c][r] for c in range(len(matrix))] for r in range(len(matrix[0]))])


def glm_of(matrix: Any) -> Any:
    """A matrix of ours as PyGLM has it, columns first."""
    return glm.dmat4(*np.asarray(matrix, float).T.ravel().tolist())


def vec(v: Any) -> Any:
    return glm.dvec3(*(float(x) for x in v))


def lens() -> Any:
    """The projection of LENS; PyGLM makes projections in float32."""
    return glm.dmat4(glm.perspective(*LENS))


LENS = (math.radians(50.0), 1.5, 0.2, 70.0)
BOX = (-3.0, 5.0, -2.0, 7.0, 1.0, 7.5)


@against("PyGLM's translate, scale and rotate", transforms.translate, transforms.scale,
         transforms.rotate, transforms.translated, transforms.scaled,
         transforms.rotated)  # fmt: skip
@given(vectors, directions, angles, vectors)
def test_matrices(offset: Any, factors: Any, angle: float, point: Any) -> None:
    axis = glm.normalize(vec(factors))
    moved, stretched = glm.translate(vec(offset)), glm.scale(vec(factors))
    rotated = glm.rotate(angle, axis)
    for ours, theirs in (
        (transforms.translate(offset), moved),
        (transforms.scale(factors), stretched),
        (transforms.rotate(angle, factors), rotated),
    ):
        np.testing.assert_allclose(ours, rows(theirs), **CLOSE)
    place, shift = np.array(point), np.array(offset)
    got = transforms.translated(place, shift, 1.0)
    np.testing.assert_allclose(got, np.array(moved * glm.dvec4(*point, 1.0)), **CLOSE)
    got = transforms.scaled(place, np.array(factors), shift)
    np.testing.assert_allclose(got, np.array(moved * stretched * glm.dvec4(*point, 1.0)), **CLOSE)
    got = transforms.rotated(place, np.array(axis), angle)
    np.testing.assert_allclose(got, np.array(rotated * glm.dvec4(*point, 1.0))[:3], **CLOSE)


@against("PyGLM's perspective, frustum, ortho and lookAt", transforms.perspective,
         transforms.frustum, transforms.orthographic, transforms.look_at, spaces.perspective_clip,
         spaces.orthographic_clip, spaces.in_camera, transforms.in_view)  # fmt: skip
@given(vectors, directions, vectors)
def test_cameras(eye: Any, ahead: Any, point: Any) -> None:
    np.testing.assert_allclose(transforms.perspective(*LENS), rows(lens()), **CLOSE)
    box = glm.dmat4(glm.ortho(*BOX))
    np.testing.assert_allclose(transforms.orthographic(*BOX), rows(box), **CLOSE)
    np.testing.assert_allclose(
        transforms.frustum(*BOX), rows(glm.dmat4(glm.frustum(*BOX))), **CLOSE
    )
    seen, whole = np.array(point), glm.dvec4(*point, 1.0)
    np.testing.assert_allclose(
        spaces.perspective_clip(seen, *LENS), rows(lens()) @ np.array(whole), **CLOSE
    )
    np.testing.assert_allclose(
        spaces.orthographic_clip(seen, *BOX), rows(box) @ np.array(whole), rtol=1e-5, atol=1e-5
    )
    if math.hypot(ahead[0], ahead[2]) < 0.05:
        return  # looking along `up` has no side
    target = np.add(eye, ahead)
    view = glm.lookAt(vec(eye), vec(target), glm.dvec3(0, 1, 0))
    np.testing.assert_allclose(transforms.look_at(eye, target), rows(view), **CLOSE)
    up = np.array([0.0, 1.0, 0.0])
    found = spaces.in_camera(seen, np.array(eye), target, up)
    np.testing.assert_allclose(found, np.array(view * whole)[:3], **CLOSE)
    clip = transforms.in_view(seen, rows(view), transforms.perspective(*LENS))
    np.testing.assert_allclose(clip, rows(lens()) @ np.array(view * whole), rtol=1e-5, atol=1e-5)


@against("PyGLM's project and its matrix products", transforms.clip_position,
         transforms.device_position, transforms.world_position, spaces.device, spaces.window,
         shadows.shadow_coordinates)  # fmt: skip
@given(vectors.map(lambda v: (v[0], v[1], -1.0 - abs(v[2]))), angles)
def test_the_whole_chain(point: Any, angle: float) -> None:
    model, view = transforms.rotate(angle, (0, 0, 1)), transforms.translate((0.5, -0.25, -1.0))
    projection, place = rows(lens()), np.array(point)
    chain = (model, view, projection)
    clip = lens() * glm_of(view) * glm_of(model) * glm.dvec4(*point, 1.0)
    np.testing.assert_allclose(transforms.clip_position(place, *chain), np.array(clip), **CLOSE)
    world = glm_of(model) * glm.dvec4(*point, 1.0)
    np.testing.assert_allclose(
        transforms.world_position(place, model), np.array(world)[:3], **CLOSE
    )
    viewport = glm.dvec4(10.0, 20.0, 640.0, 480.0)
    window = np.array(glm.project(vec(point), glm_of(view @ model), lens(), viewport))
    ndc = (window - (330.0, 260.0, 0.5)) / (320.0, 240.0, 0.5)
    np.testing.assert_allclose(transforms.device_position(place, *chain), ndc, **CLOSE)
    np.testing.assert_allclose(spaces.device(np.array(clip)), ndc, **CLOSE)
    got = spaces.window(ndc, np.array(viewport), np.array([0.0, 1.0]))
    np.testing.assert_allclose(got, window, rtol=1e-6, atol=1e-5)
    unit = np.array(glm.project(vec(point), glm_of(view @ model), lens(), glm.dvec4(0, 0, 1, 1)))
    np.testing.assert_allclose(shadows.shadow_coordinates(np.array(clip)), unit, **CLOSE)


@against("PyGLM's inverseTranspose, and the right angle to a transformed surface",
         transforms.normal_matrix, transforms.world_normal)  # fmt: skip
@given(angles, directions)
def test_normals(angle: float, factors: Any) -> None:
    if min(abs(f) for f in factors) < 0.05:
        return
    model = transforms.rotate(angle, (1, 2, 2)) @ transforms.scale(factors)
    theirs = glm.inverseTranspose(glm.dmat3(glm_of(model)))
    matrix = transforms.normal_matrix(model)
    np.testing.assert_allclose(matrix, rows(theirs), rtol=1e-6, atol=1e-9)
    normal = transforms.world_normal(np.array([2.0, -1.0, 0.0]), matrix)
    tangent = model[:3, :3] @ (1.0, 2.0, 0.5)
    assert abs(tangent @ normal) < 1e-8 * np.linalg.norm(tangent) * np.linalg.norm(normal)


@against("PyGLM's quaternions", quaternions.axis_angle, quaternions.product, quaternions.conjugate,
         quaternions.turned, quaternions.slerp, quaternions.matrix_of)  # fmt: skip
@given(directions, angles, directions, angles, vectors)
def test_quaternions(axis: Any, angle: float, other: Any, much: float, point: Any) -> None:
    def both(axis: Any, angle: float) -> Any:
        theirs = glm.angleAxis(angle, glm.normalize(vec(axis)))
        ours = quaternions.axis_angle(axis, angle)
        np.testing.assert_allclose(ours, numbers_of(theirs), **CLOSE)
        return ours, theirs

    def numbers_of(q: Any) -> Any:
        return np.array([q.x, q.y, q.z, q.w])

    (p, their_p), (q, their_q) = both(axis, angle), both(other, much)
    np.testing.assert_allclose(quaternions.product(p, q), numbers_of(their_p * their_q), **CLOSE)
    np.testing.assert_allclose(
        quaternions.conjugate(p), numbers_of(glm.conjugate(their_p)), **CLOSE
    )
    turned = quaternions.turned(np.array(point), p)
    np.testing.assert_allclose(turned, np.array(their_p * vec(point)), rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(
        quaternions.matrix_of(p), rows(glm.mat4_cast(their_p)), rtol=1e-6, atol=1e-6
    )
    if 0.0 <= glm.dot(their_p, their_q) < 0.999:
        half = quaternions.slerp(p, q, 0.3)
        np.testing.assert_allclose(half, numbers_of(glm.slerp(their_p, their_q, 0.3)), **CLOSE)


@against("PyGLM's rotate, three times", euler.euler_turned, euler.euler_matrix)
@against("the rotation's derivative by each angle, a finite difference", euler.gimbal_axes,
         euler.gimbal_freedom)  # fmt: skip
@given(angles, angles, angles, vectors)
def test_euler_angles(yaw: float, pitch: float, roll: float, point: Any) -> None:
    theirs = glm.dmat4(1.0)
    for angle, axis in ((yaw, (0, 1, 0)), (pitch, (1, 0, 0)), (roll, (0, 0, 1))):
        theirs = glm.rotate(theirs, angle, glm.dvec3(*axis))
    np.testing.assert_allclose(euler.euler_matrix(yaw, pitch, roll), rows(theirs), **CLOSE)
    turned = euler.euler_turned(np.array(point), yaw, pitch, roll)
    np.testing.assert_allclose(turned, np.array(theirs * glm.dvec4(*point, 1.0))[:3], **CLOSE)
    axes = []
    for step in np.eye(3) * 1e-5:
        ahead, back = (
            euler.euler_matrix(*(np.array([yaw, pitch, roll]) + sign * step))[:3, :3]
            for sign in (1.0, -1.0)
        )
        spin = (ahead - back) / 2e-5 @ rows(theirs)[:3, :3].T  # the cross product by the axis
        axes.append([spin[2, 1], spin[0, 2], spin[1, 0]])
    np.testing.assert_allclose(euler.gimbal_axes(yaw, pitch), axes, atol=1e-8)
    assert euler.gimbal_freedom(pitch) == pytest.approx(abs(np.linalg.det(axes)), abs=1e-7)


@against("PyGLM's rotation of a camera behind the origin", spaces.orbit_eye)
@against("PyGLM's product with the view's rotation alone, w for z", spaces.sky_clip)
@given(angles, vectors)
def test_orbit_and_sky(angle: float, point: Any) -> None:
    around = glm.rotate(angle, glm.dvec3(0, 1, 0)) * glm.dvec4(0, 1.5, 4.0, 1.0)
    np.testing.assert_allclose(spaces.orbit_eye(angle, 4.0, 1.5), np.array(around)[:3], **CLOSE)
    view = glm.lookAt(glm.dvec3(3, 2, 5), glm.dvec3(0, 0, 0), glm.dvec3(0, 1, 0))
    still = glm.dmat4(glm.dmat3(view))
    x, y, _, w = lens() * still * glm.dvec4(*point, 1.0)
    found = spaces.sky_clip(np.array(point), rows(view), rows(lens()))
    np.testing.assert_allclose(found, (x, y, w, w), rtol=1e-5, atol=1e-5)


@against("PyGLM's project and unProject along the axis", depth.window_depth, depth.distance_of,
         spaces.depth_of)  # fmt: skip
@against("numpy.interp between the planes", depth.linear_depth)
@given(st.floats(0.21, 69.0))
def test_depth(z: float) -> None:
    viewport = glm.dvec4(0, 0, 1, 1)
    window = glm.project(glm.dvec3(0, 0, -z), glm.dmat4(1.0), lens(), viewport).z
    assert depth.window_depth(z, 0.2, 70.0) == pytest.approx(window, abs=3e-7)
    back = glm.unProject(glm.dvec3(0.5, 0.5, window), glm.dmat4(1.0), lens(), viewport).z
    assert depth.distance_of(window, 0.2, 70.0) == pytest.approx(-back, rel=2e-4)
    assert depth.linear_depth(z, 0.2, 70.0) == pytest.approx(np.interp(z, [0.2, 70.0], [0.0, 1.0]))
    device, slope = spaces.depth_of(-z, 0.2, 70.0)
    assert device == pytest.approx(2.0 * window - 1.0, abs=6e-7)
    step = 1e-4 * z
    near, far = (
        glm.project(glm.dvec3(0, 0, -z + s), glm.dmat4(1.0), lens(), viewport).z
        for s in (step, -step)
    )
    assert slope == pytest.approx(2.0 * (near - far) / (2.0 * step), rel=1e-5)


@against("depths rounded to codes: the distance to the next code, and a wall drawn pixel by pixel",
         depth.depth_step, depth.same_code_share)  # fmt: skip
def test_steps_of_a_fixed_point_buffer() -> None:
    near, far, bits = 0.1, 100.0, 16

    def code(z: Any) -> Any:
        return np.rint((1.0 / near - 1.0 / np.asarray(z)) / (1.0 / near - 1.0 / far) * 2.0**bits)

    z = np.linspace(9.9, 10.1, 2_000_001)
    changes = z[1:][np.diff(code(z)) > 0]
    assert depth.depth_step(10.0, near, far, bits) == pytest.approx(
        np.diff(changes).mean(), rel=0.01
    )
    wall = 1.0 / np.linspace(1.0 / 9.0, 1.0 / 11.0, 400_001)
    for gap in (0.002, 0.008):
        share = (code(wall) == code(wall + gap)).mean()
        expected = depth.same_code_share(gap, 10.0, 1.0, near, far, bits)
        assert expected == pytest.approx(share, abs=0.005)


@against("angles by acos", shadows.slope_bias)
@against("comparisons one by one, in Python", shadows.shadow, shadows.filtered_shadow)
@given(
    directions,
    directions,
    st.floats(0.0, 1.2),
    st.lists(st.floats(0.0, 1.0), min_size=9, max_size=9),
)
def test_shadows(normal: Any, light: Any, current: float, closest: list[float]) -> None:
    between = math.acos(
        max(-1.0, min(1.0, glm.dot(glm.normalize(vec(normal)), glm.normalize(vec(light)))))
    )
    bias = shadows.slope_bias(np.array(normal), np.array(light), 0.005, 0.05).item()
    assert bias == pytest.approx(max(0.05 * (1.0 - math.cos(between)), 0.005), rel=1e-6)
    dark = [current <= 1.0 and current - 0.01 > stored for stored in closest]
    assert [float(shadows.shadow(current, s, 0.01)) for s in closest] == [float(d) for d in dark]
    mean = sum(dark) / 9.0
    assert float(shadows.filtered_shadow(current, closest, 0.01)) == pytest.approx(mean)


@against("least squares over the triangle: place as a function of u and v", tangent_space.tangent,
         tangent_space.bitangent)  # fmt: skip
@against("numpy.linalg.det", tangent_space.uv_area)
@given(directions, directions, numbers, numbers, numbers, numbers)
def test_tangent_space(a: Any, b: Any, u1: float, v1: float, u2: float, v2: float) -> None:
    area = float(np.linalg.det([[u1, v1], [u2, v2]]))
    normal = np.cross(a, b)
    uv1, uv2 = np.array([u1, v1]), np.array([u2, v2])
    assert tangent_space.uv_area(uv1, uv2).item() == pytest.approx(area, abs=1e-9)
    if abs(area) < 0.5 or np.linalg.norm(normal) < 0.5:
        return
    solved, *_ = np.linalg.lstsq(
        np.array([[u1, v1], [u2, v2]]), np.array([a, b], float), rcond=None
    )
    unit = normal / np.linalg.norm(normal)
    t = tangent_space.tangent(np.array(a), np.array(b), uv1, uv2, unit)
    np.testing.assert_allclose(t, solved[0] / np.linalg.norm(solved[0]), rtol=1e-5, atol=1e-5)
    # In the surface, at right angles to T, on the side to which v grows.
    side = tangent_space.bitangent(unit, t, uv1, uv2)
    assert abs(side @ unit) < 1e-9 and abs(side @ t) < 1e-9
    assert side @ solved[1] > 0.0


@against("acos of the decoded texel's height", tangent_space.tilt_of_flat_bytes)
@against("numpy.interp from 0…1 to −1…1", tangent_space.decoded_normal)
def test_bytes_as_normals() -> None:
    texels = np.arange(256) / 255.0
    expected = np.interp(texels, [0.0, 1.0], [-1.0, 1.0])
    np.testing.assert_allclose(tangent_space.decoded_normal(texels), expected, atol=1e-15)
    flat = expected[[128, 128, 255]]
    tilt = math.degrees(math.acos(flat[2] / float(np.linalg.norm(flat))))
    assert tangent_space.tilt_of_flat_bytes() == pytest.approx(tilt, rel=1e-6)


@against("equal ratios and equal differences", cascades.split_distances)
@against("numpy.searchsorted", cascades.cascade_index)
@against("PyGLM's unProject of a narrower lens, and ortho of the box around them",
         cascades.slice_corners, cascades.fitted)  # fmt: skip
def test_cascades() -> None:
    equal = cascades.split_distances(0.5, 60.0, 4, 0.0)
    ratio = cascades.split_distances(0.5, 60.0, 4, 1.0)
    assert np.diff([0.5, *equal]) == pytest.approx([59.5 / 4] * 4)
    assert np.divide(ratio, [0.5, *ratio[:-1]]) == pytest.approx([120.0**0.25] * 4)
    mixed = cascades.split_distances(0.5, 60.0, 4, 0.3)
    assert mixed == pytest.approx([0.3 * b + 0.7 * a for a, b in zip(equal, ratio, strict=True)])
    for z in (0.6, 5.0, 40.0, 70.0):
        index = np.searchsorted(ratio[:-1], z, side="right")
        assert float(cascades.cascade_index(z, ratio)) == index
    view = glm.lookAt(glm.dvec3(3, 2, 5), glm.dvec3(0, 0, 0), glm.dvec3(0, 1, 0))
    narrow = glm.dmat4(glm.perspective(math.radians(50.0), 1.5, 2.0, 9.0))
    corners = [
        np.array(glm.unProject(glm.dvec3(x, y, z), view, narrow, glm.dvec4(0, 0, 1, 1)))
        for z in (0, 1) for y in (0, 1) for x in (0, 1)
    ]  # fmt: skip
    got = cascades.slice_corners(rows(view), transforms.perspective(*LENS), 2.0, 9.0)
    np.testing.assert_allclose(got, corners, rtol=1e-4, atol=1e-4)
    lamp = glm.lookAt(glm.dvec3(9, 12, 3), glm.dvec3(0, 0, 0), glm.dvec3(0, 1, 0))
    matrix = cascades.fitted(rows(lamp), corners, (1.0, 40.0))
    placed = np.array([np.array(glm_of(matrix) * glm.dvec4(*c, 1.0)) for c in corners])
    assert placed[:, :2].min(0) == pytest.approx([-1.0, -1.0])
    assert placed[:, :2].max(0) == pytest.approx([1.0, 1.0])


@against("PyGLM's reflect", cube_maps.mirrored)
@against("PyGLM's refract, and Snell's law of sines", cube_maps.bent)
@against("its expansion in powers of the cosine (numpy.polyval)", cube_maps.fresnel)
@given(vectors, directions, vectors)
def test_rays(place: Any, normal: Any, eye: Any) -> None:
    ray = np.subtract(place, eye)
    if np.linalg.norm(ray) < 0.1:
        return
    n, incoming = glm.normalize(vec(normal)), glm.normalize(vec(ray))
    where = (np.array(place), np.array(normal), np.array(eye))
    np.testing.assert_allclose(
        cube_maps.mirrored(*where), np.array(glm.reflect(incoming, n)), **CLOSE
    )
    cosine = max(-glm.dot(n, incoming), 0.0)
    powers = np.poly1d([-1.0, 1.0]) ** 5
    expected = 0.04 + 0.96 * np.polyval(powers.coeffs, cosine)
    assert cube_maps.fresnel(*where, 0.04).item() == pytest.approx(expected, rel=1e-6, abs=1e-9)
    if cosine > 0.01:
        inside = cube_maps.bent(*where, 1.0 / 1.52)
        np.testing.assert_allclose(inside, np.array(glm.refract(incoming, n, 1.0 / 1.52)), **CLOSE)
        sines = [np.linalg.norm(np.cross(np.array(n), v)) for v in (np.array(incoming), inside)]
        assert sines[0] == pytest.approx(1.52 * sines[1], rel=1e-6, abs=1e-9)


# Table 8.19 of "The OpenGL Graphics System: A Specification", version 4.6: the directions of s and
# t on the face that the axis goes through.
FACES = [
    ((1, 0, 0), (0, 0, -1), (0, -1, 0)), ((-1, 0, 0), (0, 0, 1), (0, -1, 0)),
    ((0, 1, 0), (1, 0, 0), (0, 0, 1)), ((0, -1, 0), (1, 0, 0), (0, 0, -1)),
    ((0, 0, 1), (1, 0, 0), (0, -1, 0)), ((0, 0, -1), (-1, 0, 0), (0, -1, 0)),
]  # fmt: skip


@against("OpenGL's table of faces, walked the other way: from face, s and t to the direction",
         cube_maps.face_coordinates)  # fmt: skip
@given(st.integers(0, 5), st.floats(0.01, 0.99), st.floats(0.01, 0.99), st.floats(0.1, 9.0))
def test_cube_faces(face: int, s: float, t: float, length: float) -> None:
    axis, along_s, along_t = (np.array(v, float) for v in FACES[face])
    direction = length * (axis + (2.0 * s - 1.0) * along_s + (2.0 * t - 1.0) * along_t)
    np.testing.assert_allclose(cube_maps.face_coordinates(direction), (face, s, t), atol=1e-9)
