"""Euler angles and gimbal lock: yaw around y, pitch around x, roll around z.

R = R_y(yaw) · R_x(pitch) · R_z(roll): the roll acts first, in the thing's own frame, the yaw last,
in the world's. With −z forward and y up these are an aircraft's heading, climb and bank.

Source: L. Euler, "Formulae generales pro translatione quacunque corporum rigidorum", 1776; in this
order, tangent frames and names, "Quaternions and Rotation Sequences" (J. B. Kuipers, 1999), ch. 4.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.glslmath import Value, cos, sin, swizzle, vec3
from shaderlab.reference.transforms import Matrix, rotate


def euler_turned(aPos: Value, yaw: Value, pitch: Value, roll: Value) -> Value:
    """Points through roll, then pitch, then yaw: (…, 3). Angles in radians, −π … π.

    >>> import math
    >>> nose = np.array([0.0, 0.0, -1.0])
    >>> euler_turned(nose, 0.0, math.pi / 2, 0.0).round(9).tolist()
    [0.0, 1.0, -0.0]
    """
    x, y, z = (swizzle(aPos, name) for name in "xyz")
    x, y = cos(roll) * x - sin(roll) * y, sin(roll) * x + cos(roll) * y
    y, z = cos(pitch) * y - sin(pitch) * z, sin(pitch) * y + cos(pitch) * z
    x, z = cos(yaw) * x + sin(yaw) * z, cos(yaw) * z - sin(yaw) * x
    return vec3(x, y, z)


def euler_matrix(yaw: float, pitch: float, roll: float) -> Matrix:
    """The same as one 4 × 4 matrix, from three rotations.

    >>> import math
    >>> euler_matrix(0.0, math.pi / 2, 0.0)[:3, 2].round(9).tolist()
    [0.0, -1.0, 0.0]
    """
    turns = ((yaw, (0, 1, 0)), (pitch, (1, 0, 0)), (roll, (0, 0, 1)))
    a, b, c = (rotate(angle, axis) for angle, axis in turns)
    return np.asarray(a @ b @ c)


def gimbal_axes(yaw: float, pitch: float) -> Any:
    """The axes of the three rotations in a pose, as rows: yaw's, pitch's, roll's.

    Yaw's is fixed; yaw rotates pitch's, and both rotate roll's.

    >>> gimbal_axes(0.0, 0.0).tolist()
    [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    """
    turn = rotate(yaw, (0, 1, 0))[:3, :3]
    pitched = turn @ rotate(pitch, (1, 0, 0))[:3, :3]
    return np.array([[0.0, 1.0, 0.0], turn[:, 0], pitched[:, 2]])


def gimbal_freedom(pitch: float) -> float:
    """The volume that the three axes span, |cos(pitch)|: 1 at right angles, 0 in gimbal lock.

    >>> import math
    >>> round(gimbal_freedom(math.radians(60.0)), 12)
    0.5
    """
    return float(abs(np.linalg.det(gimbal_axes(0.3, pitch))))
