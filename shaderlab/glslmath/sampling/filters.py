"""NEAREST and LINEAR filtering: which texels contribute to a sample, and with what weights.

A sample with LINEAR is a continuous, piecewise bilinear function of the position, whatever the wrap
mode. So if a position is only known to lie in a small box, the result is the hull of the function's
values at the box's corners and where rows and columns of texel centres cross the box.

Source: OpenGL 4.5 core profile specification, §8.14.2, equations 8.13 to 8.17. It leaves open how
precise the weights are. Direct3D 11.3 (functional specification, §7.18.8) asks for 8 bits of
fraction in texture coordinates after scaling, and Vulkan names the number a device has
(subTexelPrecisionBits: at least 4, 8 on desktop hardware).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from shaderlab.bands.compiled import compiled
from shaderlab.model.frame import Array

from .reading import Integers, texels_at
from .spans import Span, hull, require_narrow, widened

WEIGHT = 2.0**-8
"""How far a place may be off, in texels, before LINEAR mixes; and a level, in levels."""
ROUNDING = 8 * 2.0**-23
"""What mixing four texels in float32 may lose, of the largest of them: eight roundings."""

Texel = Callable[[Array, Array, Any], Span]
"""Gives the texels at integer columns and rows, inside or outside, of some of the places: those
at an index into all of them."""

EVERYWHERE = ...
"""The index that leaves no place out."""


def nearest(texel: Texel, x: Span, y: Span) -> Span:
    """The texel that contains a position (in texels, 0 at the edge), or both candidates."""
    require_narrow(x, "texture()")
    require_narrow(y, "texture()")
    columns, rows = [np.floor(end) for end in _ends(x)], [np.floor(end) for end in _ends(y)]
    found = texel(columns[0], rows[0], EVERYWHERE)
    crossing = (columns[0] != columns[-1]) | (rows[0] != rows[-1])
    if not crossing.any():
        return found
    # Few places lie next to an edge of their texel: only those have several candidates.
    columns, rows = ([end[crossing] for end in ends] for ends in (columns, rows))
    low, high = found[0].copy(), found[1].copy()
    candidates = [texel(column, row, crossing) for column in columns for row in rows]
    low[crossing], high[crossing] = hull(candidates)
    return low, high


@compiled
def nearest_texels(
    x_low: Array, x_high: Array, y_low: Array, y_high: Array,
    values: Array, layer: Integers, *how: Any,
) -> Span:  # fmt: skip
    """`nearest` of texels that `texels_at` finds."""

    def texel(column: Array, row: Array, at: Any) -> Span:
        return texels_at(column, row, values, layer[at], *how)

    return nearest(texel, (x_low, x_high), (y_low, y_high))


def linear(texel: Texel, x: Span, y: Span, exact: bool, compared: bool = False) -> Span:
    """The weighted mean of the four texels around a position; `exact` for float64 positions.

    Where `compared` texels, each 0 or 1, differ, a driver may return anything in between: OpenGL
    leaves open whether it compares one of them, all four, or (like softpipe) their mean.
    """
    if exact:
        column, row = x[0] - 0.5, y[0] - 0.5
        return _within_cell(texel, (column, column), (row, row), EVERYWHERE)
    x, y = (x[0] - 0.5, x[1] - 0.5), (y[0] - 0.5, y[1] - 0.5)
    x, y = widened(x, WEIGHT), widened(y, WEIGHT)
    require_narrow(x, "texture()")
    require_narrow(y, "texture()")
    low, high = _within_cell(texel, x, y, EVERYWHERE)
    crossing = (np.floor(x[0]) < np.floor(x[1])) | (np.floor(y[0]) < np.floor(y[1]))
    if crossing.any():
        # Few places cross a texel centre's row or column: only those are split into pieces.
        x, y = ((start[crossing], end[crossing]) for start, end in (x, y))
        pieces = [_within_cell(texel, a, b, crossing) for a in _pieces(x) for b in _pieces(y)]
        low[crossing], high[crossing] = hull(pieces)
    if compared:
        # Weights of sum 1 give or take a last bit, and _within_cell's own give.
        some = 2.0 * ROUNDING
        return np.where(low < 1.0 - some, 0.0, 1.0), np.where(high > some, 1.0, 0.0)
    return low, high


def corners(span: Span) -> list[Array]:
    """Where a function that is linear between integers takes its extremes in a span."""
    low, high = span
    if low is high:
        return [low]
    return [low, np.clip(np.ceil(low), low, high), high]


def _pieces(span: Span) -> list[Span]:
    """A span of at most 1, split at the integer in it."""
    low, middle, high = corners(span)
    return [(low, middle), (middle, high)]


def _ends(span: Span) -> list[Array]:
    return [span[0]] if span[0] is span[1] else [span[0], span[1]]


def _within_cell(texel: Texel, x: Span, y: Span, places: Any) -> Span:
    """The bounds of a mean of four texels over a box between their centres: those at its corners.

    Numbers, whose bounds are one array, have one corner and no rounding.
    """
    left, low = np.floor(x[0]), np.floor(y[0])
    across = [(end - left)[..., None] for end in _ends(x)]
    up = [(end - low)[..., None] for end in _ends(y)]
    spans = [texel(left + i, low + j, places) for j in (0, 1) for i in (0, 1)]
    lows, highs = ([span[k] for span in spans] for k in (0, 1))
    if x[0] is x[1] and y[0] is y[1]:
        mean = _at_corners(lows, across, up)[0]
        return mean, mean
    return mixed_texels(*lows, *highs, across[0], across[-1], up[0], up[-1])


@compiled
def mixed_texels(*given: Array) -> Span:
    """The bounds of a mean of four texels: of the lowest that each may be, the highest, and the
    ends of both weights."""
    lows, highs, across, up = (list(given[a:b]) for a, b in ((0, 4), (4, 8), (8, 10), (10, 12)))
    give = ROUNDING * np.maximum.reduce([np.abs(bound) for bound in (*lows, *highs)])
    return (
        np.minimum.reduce(_at_corners(lows, across, up)) - give,
        np.maximum.reduce(_at_corners(highs, across, up)) + give,
    )


def _at_corners(texels: list[Array], across: list[Array], up: list[Array]) -> list[Array]:
    """Four texels mixed with each pair of weights; equation 8.16."""
    found = []
    for a in across:
        parts = [texel * (a if k % 2 else 1.0 - a) for k, texel in enumerate(texels)]
        for b in up:
            one, two, three, four = (
                part * (b if k // 2 else 1.0 - b) for k, part in enumerate(parts)
            )
            found.append(one + two + three + four)
    return found
