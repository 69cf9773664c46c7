"""GLSL's geometric functions (GLSL 4.60, 8.5). Vectors lie along the last axis, which `dot`,
`length` and `distance` keep with size 1.
"""

from __future__ import annotations

import numpy as np

from shaderlab.bands import Band, arithmetic, exact, functions, sums
from shaderlab.bands.compiled import compiled
from shaderlab.bands.rounding import SMALLEST_NORMAL
from shaderlab.errors import FormulaError
from shaderlab.glslmath.choice import where
from shaderlab.glslmath.dispatch import Value, applied, number, undefined
from shaderlab.glslmath.scalar import clamp, max, sqrt

# What rounding may add to a component of a unit vector, in both of its expansions.
_BEYOND_UNIT = 1.0 + 16 * 2.0**-23


def dot(a: Value, b: Value) -> Value:
    """a·b: the sum of the products, in any order; of one value with itself not negative.

    >>> dot(np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]))
    array([32.])
    """

    def plain(a: Value, b: Value) -> Value:
        return np.sum(np.atleast_1d(a * b), axis=-1, keepdims=True)

    return applied(plain, sums.dot, a, b)


def length(v: Value) -> Value:
    """√(v·v).

    >>> length(np.array([3.0, 4.0]))
    array([5.])
    """
    return sqrt(dot(v, v))


def distance(a: Value, b: Value) -> Value:
    """length(a - b)."""
    return length(number(a) - number(b))


def normalize(v: Value) -> Value:
    """v / length(v), or v · inversesqrt(v·v): bands allow both; undefined for length 0.

    >>> normalize(np.array([3.0, 4.0]))
    array([0.6, 0.8])
    """

    def plain(v: Value) -> Value:
        return v / length(v)

    def banded(v: Band) -> Band:
        if v.direction is None:
            v.direction = direction(v.opaque())
        return v.direction.again()

    return applied(plain, banded, v)


@compiled
def direction(v: Band) -> Band:
    """The unit vector of a band that is no sum."""
    squared = sums.sum_last(arithmetic.square(v))
    quotient = arithmetic.divide(v, functions.sqrt(squared))
    product = arithmetic.multiply(v, functions.inversesqrt(squared))
    either: Band = clamp(exact.union(quotient, product), -_BEYOND_UNIT, _BEYOND_UNIT)
    return undefined(either, squared.lo < SMALLEST_NORMAL)


def cross(a: Value, b: Value) -> Value:
    """a × b of three-component vectors.

    >>> cross(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    array([0., 0., 1.])
    """
    a, b = number(a), number(b)
    if a.shape[-1:] != (3,) or b.shape[-1:] != (3,):
        raise FormulaError(f"cross takes vectors of three components, not {a.shape}, {b.shape}")
    yzx, zxy = [1, 2, 0], [2, 0, 1]
    return a[..., yzx] * b[..., zxy] - a[..., zxy] * b[..., yzx]


def faceforward(n: Value, incident: Value, reference: Value) -> Value:
    """n if reference·incident < 0, else -n."""
    n = number(n)
    return where(dot(reference, incident) < 0.0, n, -n)


def reflect(incident: Value, n: Value) -> Value:
    """incident - 2·(n·incident)·n, for a unit vector n."""
    incident, n = number(incident), number(n)
    return incident - 2.0 * dot(n, incident) * n


def refract(incident: Value, n: Value, eta: Value) -> Value:
    """The refracted unit vector by Snell's law with ratio of indices eta, or 0 (total reflection).

    k = 1 - eta²·(1 - (n·i)²); k < 0 gives 0, else eta·i - (eta·(n·i) + √k)·n.
    """
    incident, n, eta = number(incident), number(n), number(eta)
    cos_theta = dot(n, incident)
    k = 1.0 - eta * eta * (1.0 - cos_theta * cos_theta)
    through = eta * incident - (eta * cos_theta + sqrt(max(k, 0.0))) * n
    return where(k < 0.0, 0.0, through)
