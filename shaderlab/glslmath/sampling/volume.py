"""Textures in three dimensions: the filters of a plane, and the same once more between layers.

Source: OpenGL 4.5 core profile specification, §8.14.2, equation 8.15 and the text around it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.model.frame import Array

from . import filters, reading
from .filters import ROUNDING, WEIGHT
from .reading import Sampler
from .spans import Span, component, hull, require_narrow, span_of, widened


def sampled(sampler: Sampler, p: Any) -> Span:
    """A sample at s, t and r, by the filter that minifying and magnifying share.

    Args:
        sampler: of the kind "3D".
        p: coordinates (count, 3) or (3,), as an array or a band.
    """
    exact = sampler.rules is None
    depth, height, width, _ = reading.level_values(sampler, 0).shape
    uvw = p if isinstance(p, Band) else np.asarray(p, np.float64)
    place = span_of(uvw * np.array([width, height, depth], np.float64))
    x, y, z = (component(place, axis) for axis in range(3))
    if sampler.texels.filter[1] == "nearest":
        require_narrow(z, "texture()")
        layers = [np.floor(end) for end in (z[:1] if exact else z)]
        return hull([filters.nearest(_layer(sampler, layer), x, y) for layer in layers])
    z = (z[0] - 0.5, z[1] - 0.5)
    if exact:
        return _between(sampler, x, y, z[0], exact=True)
    z = widened(z, WEIGHT)
    require_narrow(z, "texture()")
    low, high = hull([_between(sampler, x, y, end, exact=False) for end in filters.corners(z)])
    give = ROUNDING * np.maximum(np.abs(low), np.abs(high))
    return low - give, high + give


def _between(sampler: Sampler, x: Span, y: Span, z: Array, *, exact: bool) -> Span:
    """Two layers mixed. It is linear in z between their centres, so that the ends of z bound it."""
    below = np.floor(z)
    near, far = (filters.linear(_layer(sampler, below + k), x, y, exact=exact) for k in (0.0, 1.0))
    share = (z - below)[..., None]
    low, high = (a * (1.0 - share) + b * share for a, b in zip(near, far, strict=True))
    return low, high


def _layer(sampler: Sampler, number: Array) -> filters.Texel:
    """The texels of a layer, which may differ from place to place."""

    def texel(column: Array, row: Array, at: Any) -> Span:
        return reading.wrapped(sampler, 0, column, row, number.astype(np.int64)[at])

    return texel
