"""Matrices of the transform chain in float64, and the chain itself.

Matrices are written as mathematics writes them: rows first, points are columns, `A @ B` does B
first. Angles are radians. Spaces are OpenGL's: right-handed, the viewer looks down −z, and clip
space runs from −w to w on each axis.

Sources: "The OpenGL Graphics System: A Specification", version 1.0 (M. Segal, K. Akeley, 1992),
section 2.9.2 (translate, scale, rotate, frustum, ortho); the "OpenGL Utility Library" manual,
version 1.3 (1998), gluPerspective and gluLookAt.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.glslmath import Value, cos, cross, dot, mul, sin, swizzle, vec4

Matrix = npt.NDArray[np.float64]
Vector = Sequence[float] | npt.NDArray[Any]


def translate(offset: Vector) -> Matrix:
    """Moves points (w = 1) by `offset`; directions (w = 0) are unchanged.

    >>> (translate((1, 2, 3)) @ (0, 0, 0, 1)).tolist()
    [1.0, 2.0, 3.0, 1.0]
    """
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    return matrix


def scale(factors: Vector | float) -> Matrix:
    """Scales along x, y and z; a single number scales uniformly.

    >>> (scale((1, 2, 3)) @ (1, 1, 1, 1)).tolist()
    [1.0, 2.0, 3.0, 1.0]
    """
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(np.broadcast_to(np.asarray(factors, float), (3,)))
    return matrix


def rotate(angle: float, axis: Vector) -> Matrix:
    """Rotates by `angle` radians, counter-clockwise where `axis` points at the viewer.

    R = cos φ·I + (1 − cos φ)·u uᵀ + sin φ·[u]ₓ, u the unit axis (O. Rodrigues, 1840).

    >>> (rotate(math.radians(90), (0, 0, 1)) @ (1, 0, 0, 1)).round(12).tolist()
    [0.0, 1.0, 0.0, 1.0]
    """
    u = _unit("rotate: axis", axis)
    crossed = np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])
    matrix = np.eye(4)
    matrix[:3, :3] = (
        math.cos(angle) * np.eye(3)
        + (1.0 - math.cos(angle)) * np.outer(u, u)
        + math.sin(angle) * crossed
    )
    return matrix


def look_at(eye: Vector, target: Vector, up: Vector = (0.0, 1.0, 0.0)) -> Matrix:
    """The view matrix of a camera at `eye` that looks at `target`.

    >>> (look_at((0, 0, 3), (0, 0, 0)) @ (0, 0, 0, 1)).tolist()
    [0.0, 0.0, -3.0, 1.0]
    """
    forward = _unit("look_at: target − eye", np.subtract(target, eye))
    side = _unit("look_at: forward × up", np.cross(forward, up))
    matrix = np.eye(4)
    matrix[:3, :3] = side, np.cross(side, forward), -forward
    return np.asarray(matrix @ translate(-np.asarray(eye, float)))


def perspective(fovy: float, aspect: float, near: float, far: float) -> Matrix:
    """Perspective projection with a vertical field of view of `fovy` radians, 0 < near < far.

    z = −near lands on depth −1, z = −far on +1 (after the division by w).

    >>> perspective(math.radians(45), 4 / 3, 0.1, 100.0)[2].round(6).tolist()
    [0.0, 0.0, -1.002002, -0.2002]
    """
    if not 0.0 < near < far:
        raise ValueError(f"perspective: need 0 < near < far, not near={near}, far={far}")
    focal = 1.0 / math.tan(fovy / 2.0)
    matrix = np.zeros((4, 4))
    matrix[0, 0] = focal / aspect
    matrix[1, 1] = focal
    matrix[2, 2] = (far + near) / (near - far)
    matrix[2, 3] = 2.0 * far * near / (near - far)
    matrix[3, 2] = -1.0
    return matrix


def frustum(
    left: float, right: float, bottom: float, top: float, near: float, far: float
) -> Matrix:
    """Perspective projection by six planes, 0 < near < far: the window of the near plane goes from
    (left, bottom) to (right, top), and its middle need not be straight ahead.

    Its corners land on x, y = ±1 and depth −1, z = −far on depth 1 (after the division by w).

    Source: The OpenGL Graphics System: A Specification (version 2.1), M. Segal and K. Akeley, 2006,
    §2.11.2, Frustum.

    >>> (frustum(-1.0, 3.0, -0.5, 1.5, 0.5, 20.0) @ (3.0, 1.5, -0.5, 1.0)).round(9).tolist()
    [0.5, 0.5, -0.5, 0.5]
    """
    if not 0.0 < near < far:
        raise ValueError(f"frustum: need 0 < near < far, not near={near}, far={far}")
    low, high = np.array([left, bottom], float), np.array([right, top], float)
    matrix = np.zeros((4, 4))
    matrix[:2, :2] = np.diag(2.0 * near / (high - low))
    matrix[:2, 2] = (high + low) / (high - low)
    matrix[2, 2] = (far + near) / (near - far)
    matrix[2, 3] = 2.0 * far * near / (near - far)
    matrix[3, 2] = -1.0
    return matrix


def orthographic(
    left: float, right: float, bottom: float, top: float, near: float, far: float
) -> Matrix:
    """Parallel projection of a box onto −1…1; z = −near lands on −1, z = −far on +1.

    >>> (orthographic(-10, 10, -10, 10, 1, 7.5) @ (10, -10, -1, 1)).tolist()
    [1.0, -1.0, -1.0, 1.0]
    """
    low = np.array([left, bottom, -near], float)
    high = np.array([right, top, -far], float)
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(2.0 / (high - low))
    matrix[:3, 3] = -(high + low) / (high - low)
    return matrix


def normal_matrix(model: Matrix) -> Matrix:
    """The matrix for normals where `model` transforms points: its inverse transpose, 3 × 3.

    >>> normal_matrix(scale((1, 2, 4))).diagonal().tolist()
    [1.0, 0.5, 0.25]
    """
    return np.asarray(np.linalg.inv(np.asarray(model, float)[:3, :3]).T)


def clip_position(aPos: Value, model: Value, view: Value, projection: Value) -> Value:
    """From a mesh's own space to clip space: projection · (view · (model · (x, y, z, 1))).

    Args:
        aPos: positions, (…, 3).
        model, view, projection: 4 × 4.

    Returns (…, 4), before the division by w.

    >>> view, projection = translate((0, 0, -3)), perspective(math.radians(45), 1.0, 0.1, 100.0)
    >>> clip_position(np.array([0.5, 0.5, 0.0]), np.eye(4), view, projection).round(6).tolist()
    [1.207107, 1.207107, 2.805806, 3.0]
    """
    return mul(projection, mul(view, mul(model, vec4(aPos, 1.0))))


def world_position(aPos: Value, model: Value) -> Value:
    """From a mesh's own space to the world's: the first three of model · (x, y, z, 1).

    >>> world_position(np.array([1.0, 0.0, 0.0]), translate((1, 2, 3))).tolist()
    [2.0, 2.0, 3.0]
    """
    return swizzle(mul(model, vec4(aPos, 1.0)), "xyz")


def world_normal(aNormal: Value, normalMatrix: Value) -> Value:
    """Normals through a `normal_matrix`; not of unit length afterwards.

    >>> world_normal(np.array([1.0, 1.0, 0.0]), normal_matrix(scale((1, 2, 1)))).tolist()
    [1.0, 0.5, 0.0]
    """
    return mul(normalMatrix, aNormal)


def device_position(aPos: Value, model: Value, view: Value, projection: Value) -> Value:
    """Normalised device coordinates: `clip_position` divided by its w, (…, 3).

    >>> view, projection = translate((0, 0, -3)), perspective(math.radians(45), 1.0, 0.1, 100.0)
    >>> device_position(np.array([0.5, 0.5, 0.0]), np.eye(4), view, projection).round(6).tolist()
    [0.402369, 0.402369, 0.935269]
    """
    clip = clip_position(aPos, model, view, projection)
    return swizzle(clip, "xyz") / swizzle(clip, "w")


def translated(aPos: Value, offset: Value, w: Value) -> Value:
    """Translation of (x, y, z, w): `offset` is scaled by w, so a direction (w = 0) is unchanged.

    >>> translated(np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]), 1.0).tolist()
    [5.0, 7.0, 9.0, 1.0]
    >>> translated(np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]), 0.0).tolist()
    [1.0, 2.0, 3.0, 0.0]
    """
    return vec4(aPos + offset * w, w)


def scaled(aPos: Value, factors: Value, offset: Value) -> Value:
    """Scaling, then translation, of the point (x, y, z, 1): (…, 4).

    >>> scaled(np.array([4.0, 5.0, 6.0]), np.array([1.0, 2.0, 3.0]), np.zeros(3)).tolist()
    [4.0, 10.0, 18.0, 1.0]
    """
    return vec4(aPos * factors + offset, 1.0)


def rotated(aPos: Value, axis: Value, angle: Value) -> Value:
    """`rotate` for many points: v cos φ + (u × v) sin φ + u (u·v)(1 − cos φ), (…, 3).

    Args:
        aPos: points or directions v, (…, 3).
        axis: u, of length 1.
        angle: φ in radians, −π … π.

    Source: O. Rodrigues, 1840.

    >>> rotated(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), math.pi / 2).round(9).tolist()
    [0.0, 1.0, 0.0]
    """
    cosine = cos(angle)
    return (
        aPos * cosine + cross(axis, aPos) * sin(angle) + axis * (dot(axis, aPos) * (1.0 - cosine))
    )


def in_view(world: Value, view: Value, projection: Value) -> Value:
    """From the world to clip space: projection · (view · (x, y, z, 1)), of a (…, 3).

    >>> in_view(np.array([1.0, 2.0, -5.0]), np.eye(4), np.eye(4)).tolist()
    [1.0, 2.0, -5.0, 1.0]
    """
    return mul(projection, mul(view, vec4(world, 1.0)))


def signed_area(points: Vector) -> float:
    """A polygon's area in the plane, positive for counter-clockwise corners.

    Source: the shoelace formula, C. F. Gauss, 1795.

    >>> signed_area([(0, 0), (1, 0), (0, 1)])
    0.5
    """
    x, y = np.asarray(points, float)[:, :2].T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2.0)


def _unit(what: str, vector: Vector | npt.NDArray[Any]) -> Matrix:
    array = np.asarray(vector, float)
    length = float(np.linalg.norm(array))
    if length == 0.0:
        raise ValueError(f"{what} has no direction")
    return array / length
