"""GLSL's derivatives (GLSL 4.60, 8.14.1): differences over a quad of 2 × 2 pixels.

A reference has the values of all pixels at once and no screen, so these functions take where the
pixels are as well: `dFdx(TexCoord, frag_coord)`. A band allows the difference along either row
(or column) of the quad, the `Fine` functions that of the pixel's own. Next to what the draw does
not cover nothing is known, and anything is allowed. All pixels have to be of one primitive: on an
edge between two, a device continues each of them beyond it. Where it cuts one itself, that is off
by 4 ULP of the largest value of p at most.
"""

from __future__ import annotations

from shaderlab.bands.quads import difference
from shaderlab.glslmath.dispatch import Value
from shaderlab.glslmath.scalar import abs


def dFdx(p: Value, frag_coord: Value) -> Value:
    """How much p grows from one pixel to the next on the right.

    >>> import numpy as np
    >>> places = np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5], [1.5, 1.5]])
    >>> dFdx(np.array([[1.0], [4.0], [1.0], [4.0]]), places).ravel().tolist()
    [3.0, 3.0, 3.0, 3.0]
    """
    return difference(p, frag_coord, "x", own=False)


def dFdy(p: Value, frag_coord: Value) -> Value:
    """How much p grows from one pixel to the next one up."""
    return difference(p, frag_coord, "y", own=False)


def fwidth(p: Value, frag_coord: Value) -> Value:
    """|dFdx(p)| + |dFdy(p)|."""
    return abs(dFdx(p, frag_coord)) + abs(dFdy(p, frag_coord))


def dFdxFine(p: Value, frag_coord: Value) -> Value:
    """`dFdx` along the pixel's own row."""
    return difference(p, frag_coord, "x", own=True)


def dFdyFine(p: Value, frag_coord: Value) -> Value:
    """`dFdy` along the pixel's own column."""
    return difference(p, frag_coord, "y", own=True)


def fwidthFine(p: Value, frag_coord: Value) -> Value:
    """|dFdxFine(p)| + |dFdyFine(p)|."""
    return abs(dFdxFine(p, frag_coord)) + abs(dFdyFine(p, frag_coord))


def dFdxCoarse(p: Value, frag_coord: Value) -> Value:
    """`dFdx`, which may be the same for all of a quad."""
    return dFdx(p, frag_coord)


def dFdyCoarse(p: Value, frag_coord: Value) -> Value:
    """`dFdy`, which may be the same for all of a quad."""
    return dFdy(p, frag_coord)


def fwidthCoarse(p: Value, frag_coord: Value) -> Value:
    """|dFdxCoarse(p)| + |dFdyCoarse(p)|."""
    return fwidth(p, frag_coord)
