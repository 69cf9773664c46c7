"""Tangent space: the frame of a normal map's normals.

Sources: J. F. Blinn, "Simulation of Wrinkled Surfaces", SIGGRAPH 1978 (normals that are not the
surface's own); E. Lengyel, "Mathematics for 3D Game Programming and Computer Graphics", third
edition (2011), section 7.8 (tangents from positions and texture coordinates, equation 7.34, and
their Gram–Schmidt orthogonalisation); OpenGL 4.5 core specification, equation 2.1 (codes of
unsigned normalised numbers).
"""

from __future__ import annotations

import math

from shaderlab.glslmath import Value, cross, dot, normalize, sign, swizzle


def decoded_normal(texel: Value) -> Value:
    """n = 2t − 1: from the range of colours, 0…1, to that of directions, −1…1.

    >>> print(f"{decoded_normal(128 / 255):.6f} {decoded_normal(127 / 255):.6f}")
    0.003922 -0.003922
    """
    return 2.0 * texel - 1.0


def tilt_of_flat_bytes() -> float:
    """The angle in degrees between a "flat" texel (128, 128, 255) and the surface's normal: no byte
    encodes 0.

    >>> print(f"{tilt_of_flat_bytes():.6f}")
    0.317755
    """
    aside = decoded_normal(128 / 255)
    return math.degrees(math.atan(math.hypot(aside, aside)))


def uv_area(uv1: Value, uv2: Value) -> Value:
    """Twice a triangle's signed area in the texture; negative where the texture is mirrored.

    >>> uv_area(np.array([1.0, 0.0]), np.array([0.0, 1.0])).tolist()
    [1.0]
    """
    return swizzle(uv1, "x") * swizzle(uv2, "y") - swizzle(uv2, "x") * swizzle(uv1, "y")


def tangent(edge1: Value, edge2: Value, uv1: Value, uv2: Value, normal: Value) -> Value:
    """T, the direction in which u grows: (Δv₂ E₁ − Δv₁ E₂) / det, made perpendicular to the normal.

    Args:
        edge1, edge2: from a triangle's first corner to the others, (…, 3).
        uv1, uv2: the same in texture coordinates, (…, 2); not parallel.
        normal: of length 1, (…, 3).

    Returns a unit vector (…, 3).

    >>> east, north, up = np.eye(3)
    >>> tangent(2.0 * east, north + east, np.array([2.0, 0.0]), np.array([1.0, 1.0]), up).tolist()
    [1.0, 0.0, 0.0]
    """
    along = swizzle(uv2, "y") * edge1 - swizzle(uv1, "y") * edge2
    along = along / uv_area(uv1, uv2)
    return normalize(along - dot(along, normal) * normal)


def bitangent(normal: Value, tangent: Value, uv1: Value, uv2: Value) -> Value:
    """B, the direction in which v grows: N × T, flipped where the texture is mirrored.

    >>> east, north, up = np.eye(3)
    >>> bitangent(up, east, np.array([1.0, 0.0]), np.array([0.0, 1.0])).tolist()
    [0.0, 1.0, 0.0]
    """
    return cross(normal, tangent) * sign(uv_area(uv1, uv2))
