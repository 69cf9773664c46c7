"""Real spherical harmonics up to the second order, and diffuse light by them.

Source: R. Ramamoorthi, P. Hanrahan, "An Efficient Representation for Irradiance Environment Maps",
SIGGRAPH 2001, equations 3 (the harmonics), 8 and 9 (what a cosine makes of each order) and 11.

Directions are (…, 3) of unit length; light is (…, 3).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.glslmath import Value, swizzle

from .sky import Array, directions

ORDERS = (0, 1, 1, 1, 2, 2, 2, 2, 2)
SMOOTHING = tuple((math.pi, 2.0 * math.pi / 3.0, math.pi / 4.0)[order] for order in ORDERS)


def harmonics(d: Value) -> list[Value]:
    """The nine functions of a direction: (0, 0), (1, −1) … (1, 1), (2, −2) … (2, 2).

    >>> [round(float(np.ravel(y)[0]), 6) for y in harmonics(np.array([0.0, 0.0, 1.0]))][:4]
    [0.282095, 0.0, 0.488603, 0.0]
    """
    x, y, z = (swizzle(d, axis) for axis in "xyz")
    first = [0.488603 * y, 0.488603 * z, 0.488603 * x]
    second = [1.092548 * (x * y), 1.092548 * (y * z), 0.315392 * (3.0 * z * z - 1.0)]
    return [0.282095, *first, *second, 1.092548 * (x * z), 0.546274 * (x * x - y * y)]


def irradiance(normal: Value, coefficients: Sequence[Value]) -> Value:
    """E(n): the light that falls on a surface, of nine coefficients of the light around it.

    >>> white = [np.full(3, 3.544908), *[np.zeros(3)] * 8]
    >>> irradiance(np.array([0.0, 0.6, 0.8]), white).round(4).tolist()
    [3.1416, 3.1416, 3.1416]
    """
    total: Value = 0.0
    for factor, y, light in zip(SMOOTHING, harmonics(normal), coefficients, strict=True):
        total = total + factor * y * light
    return total


def smoothing_of(order: int) -> float:
    """What a cosine makes of an order, by its definition: 2π ∫ x P(x) dx over 0…1.

    >>> round(smoothing_of(0), 6)
    3.141593
    """
    x, weights = np.polynomial.legendre.leggauss(16)
    x, weights = 0.5 * (x + 1.0), 0.5 * weights
    legendre = np.polynomial.legendre.Legendre.basis(order)(x)
    return float(2.0 * math.pi * np.sum(weights * x * legendre))


def texels_of(face: Any, size: int) -> tuple[Array, Array, Array]:
    """All texels of a sky: unit vectors (n, 3), solid angles (n) and light (n, 3).

    The solid angles are exact, by the arc tangents of a texel's corners.

    >>> direction, area, light = texels_of(lambda k, size: np.ones((size, size, 4)), 5)
    >>> round(float(area.sum()) / math.pi, 12)
    4.0
    """
    edges = np.linspace(-1.0, 1.0, size + 1)
    x, y = np.meshgrid(edges, edges)
    corner = np.arctan2(x * y, np.sqrt(x * x + y * y + 1.0))
    area = corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1]
    toward = np.concatenate([directions(k, size).reshape(-1, 3) for k in range(6)])
    light = np.concatenate([face(k, size)[..., :3].reshape(-1, 3) for k in range(6)])
    return toward, np.tile(area.ravel(), 6), light.astype(float)
