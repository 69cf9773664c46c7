"""NEAREST and LINEAR: which texels a place mixes, and how.

A sample with LINEAR is a continuous, piecewise bilinear function of the place, whatever the wrap
mode, so a place that is known to lie in a small box gives the hull of the function's values at
the box's corners and at the texel centres' rows and columns that cross it.

Source: OpenGL 4.5 core profile specification, §8.14.2, equations 8.13 to 8.17. It leaves open how
precise the weights are. Direct3D 11.3 (functional specification, §7.18.8) asks for 8 bits of
fraction in texture coordinates after scaling, and Vulkan names the number a device has
(subTexelPrecisionBits: at least 4, 8 on desktop hardware).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shaderlab.frame import Array
from shaderlab.sampling.spans import Span, hull, require_narrow, widened

WEIGHT = 2.0**-8
"""How far a place may be off, in texels, before LINEAR mixes; and a level, in levels."""
ROUNDING = 8 * 2.0**-23
"""What mixing four texels in float32 may lose, of the largest of them: eight roundings."""

Texel = Callable[[Array, Array], Span]
"""Gives the texels at integer columns and rows, inside or outside."""


def nearest(texel: Texel, x: Span, y: Span) -> Span:
    """The texel that holds a place (in texels, 0 at the edge); both where it may be either."""
    require_narrow(x, "texture()")
    require_narrow(y, "texture()")
    return hull([texel(np.floor(a), np.floor(b)) for a in _ends(x) for b in _ends(y)])


def linear(texel: Texel, x: Span, y: Span, exact: bool, compared: bool = False) -> Span:
    """The four texels around a place, mixed; `exact` for numbers, whose weights are as given.

    Where `compared` texels, each 0 or 1, do not agree, a driver may answer anything in between:
    OpenGL leaves open whether it compares one of them, all four, or (as softpipe) their mix.
    """
    x, y = (x[0] - 0.5, x[1] - 0.5), (y[0] - 0.5, y[1] - 0.5)
    if exact:
        return _mixed(texel, x[0], y[0], exact)
    x, y = widened(x, WEIGHT), widened(y, WEIGHT)
    require_narrow(x, "texture()")
    require_narrow(y, "texture()")
    low, high = hull([_mixed(texel, a, b, exact) for a in corners(x) for b in corners(y)])
    if compared:
        return np.where(low < 1.0 - ROUNDING, 0.0, 1.0), np.where(high > ROUNDING, 1.0, 0.0)
    return low, high


def corners(span: Span) -> list[Array]:
    """Where a function that is linear between integers takes its extremes in a span."""
    low, high = span
    if low is high:
        return [low]
    return [low, np.clip(np.ceil(low), low, high), high]


def _ends(span: Span) -> list[Array]:
    return [span[0]] if span[0] is span[1] else [span[0], span[1]]


def _mixed(texel: Texel, x: Array, y: Array, exact: bool) -> Span:
    left, low = np.floor(x), np.floor(y)
    across, up = (x - left)[..., None], (y - low)[..., None]
    total: list[Array] = []
    size = np.zeros(())
    spans = [(texel(left + i, low + j), i, j) for j in (0, 1) for i in (0, 1)]
    for bound in (0, 1) if not exact else (0,):
        parts = [
            span[bound] * (across if i else 1.0 - across) * (up if j else 1.0 - up)
            for span, i, j in spans
        ]
        total.append(parts[0] + parts[1] + parts[2] + parts[3])
    if exact:
        return total[0], total[0]
    for span, _, _ in spans:
        size = np.maximum(size, np.maximum(np.abs(span[0]), np.abs(span[1])))
    return total[0] - ROUNDING * size, total[1] + ROUNDING * size
