"""Quaternions as rotations: product, rotation of a vector, interpolation.

A quaternion is an array (…, 4) of x, y, z, w, the scalar last, as a vec4 holds it. A unit one
rotates by φ around the unit axis u if it is (u sin φ/2, cos φ/2); q and −q are the same rotation.

Sources: W. R. Hamilton, "On quaternions", 1844 (product); K. Shoemake, "Animating rotation with
quaternion curves", SIGGRAPH 1985 (q v q*, slerp, and the matrix).
"""

from __future__ import annotations

import math

import numpy as np

from shaderlab.glslmath import Value, acos, cross, dot, sin, swizzle, vec4
from shaderlab.reference.transforms import Matrix, Vector


def axis_angle(axis: Vector, angle: float) -> Matrix:
    """The unit quaternion that rotates by `angle` radians around `axis`, of any length but 0.

    >>> axis_angle((0, 0, 5), math.pi).round(12).tolist()
    [0.0, 0.0, 1.0, 0.0]
    """
    unit = np.asarray(axis, float) / np.linalg.norm(axis)
    return np.array([*(math.sin(angle / 2.0) * unit), math.cos(angle / 2.0)])


def product(p: Value, q: Value) -> Value:
    """Hamilton's product p q: the rotation q, then the rotation p.

    >>> i, j = np.array([1.0, 0, 0, 0]), np.array([0, 1.0, 0, 0])
    >>> product(i, j).tolist(), product(j, i).tolist()
    ([0.0, 0.0, 1.0, 0.0], [0.0, 0.0, -1.0, 0.0])
    """
    pv, pw = swizzle(p, "xyz"), swizzle(p, "w")
    qv, qw = swizzle(q, "xyz"), swizzle(q, "w")
    return vec4(qv * pw + pv * qw + cross(pv, qv), pw * qw - dot(pv, qv))


def conjugate(q: Value) -> Value:
    """q*, the opposite rotation; for a unit quaternion also its inverse.

    >>> conjugate(np.array([0.6, 0.0, 0.0, 0.8])).tolist()
    [-0.6, -0.0, -0.0, 0.8]
    """
    return q * np.array([-1.0, -1.0, -1.0, 1.0])


def turned(v: Value, q: Value) -> Value:
    """A vector rotated by a unit quaternion: the first three of q (v, 0) q*, (…, 3).

    >>> turned(np.array([1.0, 0.0, 0.0]), axis_angle((0, 0, 1), math.pi / 2)).round(12).tolist()
    [0.0, 1.0, 0.0]
    """
    return swizzle(product(product(q, vec4(v, 0.0)), conjugate(q)), "xyz")


def slerp(a: Value, b: Value, t: Value) -> Value:
    """Spherical interpolation from a (t = 0) to b (t = 1), at constant angular speed.

    Args:
        a, b: unit quaternions with a·b ≥ 0 (else take −b) and not nearly the same.
        t: 0…1.

    >>> half = slerp(np.array([0, 0, 0, 1.0]), axis_angle((0, 0, 1), math.pi / 2), 0.5)
    >>> np.allclose(half, axis_angle((0, 0, 1), math.pi / 4))
    True
    """
    angle = acos(dot(a, b))
    return (a * sin((1.0 - t) * angle) + b * sin(t * angle)) / sin(angle)


def matrix_of(q: Vector) -> Matrix:
    """The 4 × 4 rotation matrix of a unit quaternion.

    >>> matrix_of(axis_angle((0, 0, 1), math.pi / 2))[:2, :2].round(12).tolist()
    [[0.0, -1.0], [1.0, 0.0]]
    """
    x, y, z, w = np.asarray(q, float)
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return matrix
