"""Transforms by other people: what the PyGLM library makes of the same arguments, in float64.

Source: PyGLM, Python bindings of G-Truc's "OpenGL Mathematics" (GLM), glm.translate, glm.rotate,
glm.lookAt, glm.quat and their double-precision kin.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.errors import require_extra


def _glm() -> Any:
    with require_extra("course", "the comparison with GLM"):
        from pyglm import glm
    return glm


def glm_rows(matrix: Any) -> Any:
    """A PyGLM matrix as mathematics writes it, rows first, in float64.

    >>> from pyglm import glm
    >>> glm_rows(glm.translate(glm.dvec3(1, 2, 3)))[:3, 3].tolist()
    [1.0, 2.0, 3.0]
    """
    return np.array([[column[row] for column in matrix] for row in range(len(matrix[0]))])


def translated_by_glm(aPos: Any, offset: Any, w: Any) -> Any:
    """The translation of (x, y, z, w) by the PyGLM library, of float64 arrays only, (…, 4).

    >>> translated_by_glm(np.array([[1.0, 0, 0]]), np.ones(3), np.ones(1)).tolist()
    [[2.0, 1.0, 1.0, 1.0]]
    """
    glm = _glm()
    matrix = glm_rows(glm.translate(glm.dvec3(*offset)))
    return np.column_stack([aPos, np.broadcast_to(w, (len(aPos), 1))]) @ matrix.T


def scaled_by_glm(aPos: Any, factors: Any, offset: Any) -> Any:
    """Scaling, then translation, of (x, y, z, 1): (…, 4).

    >>> scaled_by_glm(np.array([[7.0, 8, 9]]), np.array([1, 2, 3]), np.array([4, 5, 6])).tolist()
    [[11.0, 21.0, 33.0, 1.0]]
    """
    glm = _glm()
    matrix = glm_rows(glm.scale(glm.translate(glm.dvec3(*offset)), glm.dvec3(*factors)))
    return np.column_stack([aPos, np.ones(len(aPos))]) @ matrix.T


def scaled_then_rotated_by_glm(point: Any) -> Any:
    """A point under `glm.rotate` (90° around z) of `glm.scale` (2, 1, 1), as programs write it.

    >>> scaled_then_rotated_by_glm((0.0, 1.0, 0.0)).round(9).tolist()
    [-2.0, 0.0, 0.0]
    """
    glm = _glm()
    model = glm.scale(glm.dmat4(1.0), glm.dvec3(2.0, 1.0, 1.0))
    model = glm.rotate(model, glm.radians(90.0), glm.dvec3(0.0, 0.0, 1.0))
    return np.array((model * glm.dvec4(*point, 1.0)).xyz)


def translated_from_by_glm(diagonal: float) -> Any:
    """Where (1, 0, 0, 1) is after `glm.translate` (1, 2, 3) of a matrix with this diagonal.

    >>> translated_from_by_glm(1.0).tolist()
    [2.0, 2.0, 3.0, 1.0]
    """
    glm = _glm()
    moved = glm.translate(glm.dmat4(diagonal), glm.dvec3(1.0, 2.0, 3.0))
    return np.array(moved * glm.dvec4(1.0, 0.0, 0.0, 1.0))


def rotated_by_glm(aPos: Any, axis: Any, angle: Any, offset: Any) -> Any:
    """Rotation around an axis of any length, then translation: (…, 3).

    >>> up = np.array([0.0, 2.0, 0.0]), np.array([np.pi / 2])
    >>> rotated_by_glm(np.array([[0.0, 0, 1]]), *up, np.zeros(3)).round(9).tolist()
    [[1.0, 0.0, 0.0]]
    """
    glm = _glm()
    turn = glm.rotate(float(np.ravel(angle)[0]), glm.normalize(glm.dvec3(*axis)))
    return aPos @ glm_rows(turn)[:3, :3].T + offset


def euler_by_glm(aPos: Any, yaw: Any, pitch: Any, roll: Any) -> Any:
    """Points through roll around z, pitch around x, yaw around y: (…, 3).

    >>> nose = np.array([[0.0, 0.0, -1.0]])
    >>> euler_by_glm(nose, np.zeros(1), np.array([np.pi / 2]), np.zeros(1)).round(9).tolist()
    [[0.0, 1.0, -0.0]]
    """
    glm = _glm()
    matrix: Any = glm.dmat4(1.0)
    for angle, axis in ((yaw, (0, 1, 0)), (pitch, (1, 0, 0)), (roll, (0, 0, 1))):
        matrix = glm.rotate(matrix, float(np.ravel(angle)[0]), glm.dvec3(*axis))
    return aPos @ glm_rows(matrix)[:3, :3].T


def turned_by_glm(aPos: Any, q: Any) -> Any:
    """Vectors through a unit quaternion x, y, z, w: (…, 3).

    >>> half = np.sqrt(0.5)
    >>> turned_by_glm(np.array([[1.0, 0, 0]]), np.array([0, 0, half, half])).round(9).tolist()
    [[-0.0, 1.0, 0.0]]
    """
    glm = _glm()
    quaternion = glm.dquat(float(q[3]), *(float(x) for x in q[:3]))
    return np.array([list(quaternion * glm.dvec3(*v)) for v in np.asarray(aPos, float)])


def slerp_by_glm(a: Any, b: Any) -> Any:
    """slerp between two quaternions x, y, z, w, as a formula over t: (…, 4).

    >>> slerp_by_glm([0, 0, 0, 1], [0, 0, 1, 0])(np.array([0.5])).round(6).tolist()
    [0.0, 0.0, 0.707107, 0.707107]
    """
    glm = _glm()

    def between(t: Any) -> Any:
        start, end = (glm.dquat(float(q[3]), *(float(x) for x in q[:3])) for q in (a, b))
        found = glm.slerp(start, end, float(np.ravel(t)[0]))
        return np.array([found.x, found.y, found.z, found.w])

    return between


def in_camera_by_glm(aPos: Any, eye: Any, target: Any, up: Any) -> Any:
    """Places as a camera sees them, by glm.lookAt: (…, 3).

    >>> ahead, up = np.array([0.0, 0, -1]), np.array([0.0, 1, 0])
    >>> in_camera_by_glm(np.array([[1.0, 2, 3]]), np.zeros(3), ahead, up).tolist()
    [[1.0, 2.0, 3.0]]
    """
    glm = _glm()
    view = glm_rows(glm.lookAt(*(glm.dvec3(*v) for v in (eye, target, up))))
    return aPos @ view[:3, :3].T + view[:3, 3]


def rotation_by_glm_float32(angle: float, axis: Any) -> Any:
    """glm.rotate as C++ programs call it, in float32; rows first.

    >>> print(f"{rotation_by_glm_float32(np.pi / 2, (0, 0, 1))[1, 1]:.3g}")
    -4.37e-08
    """
    glm = _glm()
    return glm_rows(glm.rotate(glm.mat4(1.0), angle, glm.vec3(*axis)))


def perspective_by_glm(aPos: Any, view: Any, fovy: Any, aspect: Any, near: Any, far: Any) -> Any:
    """Clip coordinates through glm.perspective, in PyGLM's float32: (…, 4).

    >>> lens = (np.array([value]) for value in (np.pi / 2, 1.0, 1.0, 3.0))
    >>> perspective_by_glm(np.array([[0.0, 0, -3]]), np.eye(4), *lens).round(6).tolist()
    [[0.0, 0.0, 3.0, 3.0]]
    """
    glm = _glm()
    lens = (float(np.ravel(value)[0]) for value in (fovy, aspect, near, far))
    matrix = glm_rows(glm.perspective(*lens))
    return np.column_stack([aPos, np.ones(len(aPos))]) @ np.asarray(view).T @ matrix.T


def orthographic_by_glm(
    aPos: Any, view: Any, left: Any, right: Any, bottom: Any, top: Any, near: Any, far: Any
) -> Any:
    """Clip coordinates through glm.ortho in double precision: (…, 4).

    >>> numbers = (np.array([[1.0]])[0] * n for n in (-1, 1, -1, 1, 0, 2))
    >>> orthographic_by_glm(np.array([[0.5, 0, -1]]), np.eye(4), *numbers).tolist()
    [[0.5, 0.0, 0.0, 1.0]]
    """
    bounds = [float(np.ravel(b)[0]) for b in (left, right, bottom, top, near, far)]
    matrix = _ortho_of_unit_box(bounds)
    return np.column_stack([aPos, np.ones(len(aPos))]) @ np.asarray(view).T @ matrix.T


def _ortho_of_unit_box(bounds: Any) -> Any:
    """The box moved to the origin, scaled, z turned around: three steps of PyGLM's own."""
    glm = _glm()
    low, high = (
        np.array([bounds[0], bounds[2], -bounds[5]]),
        np.array([bounds[1], bounds[3], -bounds[4]]),
    )
    step = glm.scale(glm.dvec3(*(2.0 / (high - low) * (1, 1, -1))))
    return glm_rows(glm.translate(step, glm.dvec3(*(-(high + low) / 2.0))))


def clip_by_glm(aPos: Any, model: Any, view: Any, projection: Any) -> Any:
    """Clip coordinates through one product of matrices, made by PyGLM in float64: (…, 4).

    >>> clip_by_glm(np.array([[1.0, 2, 3]]), np.eye(4), np.eye(4), np.diag([2.0, 1, 1, 1])).tolist()
    [[2.0, 2.0, 3.0, 1.0]]
    """
    glm = _glm()
    m, v, p = (glm.dmat4(*np.asarray(a, float).T.ravel()) for a in (model, view, projection))
    chain = p * v * m
    return np.array([list(chain * glm.dvec4(*(*point, 1.0))) for point in np.asarray(aPos, float)])
