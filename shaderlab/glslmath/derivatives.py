"""GLSL's derivatives (GLSL 4.60, 8.14.1): differences over a quad of 2 × 2 pixels.

A reference has the values of all pixels at once and no screen, so these functions take where the
pixels are as well: `dFdx(TexCoord, frag_coord)`. A band allows the difference along either row
(or column) of the quad, the `Fine` functions that of the pixel's own. Next to what the draw does
not cover nothing is known, and anything is allowed. All pixels have to be of one primitive: on an
edge between two, a device continues each of them beyond it. Where it cuts one itself, that is off
by 4 ULP of the largest value of p at most.

Source: also the Vulkan specification (Khronos), "Derivative Operations": quads begin at even window
coordinates.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.bands.arithmetic import subtract
from shaderlab.bands.exact import union
from shaderlab.errors import FormulaError
from shaderlab.glslmath.dispatch import Value
from shaderlab.glslmath.scalar import abs

__all__ = [
    "dFdx", "dFdxCoarse", "dFdxFine", "dFdy", "dFdyCoarse", "dFdyFine", "fwidth",
    "fwidthCoarse", "fwidthFine",
]  # fmt: skip

# A device that cuts a triangle in two, as llvmpipe does with those that reach beyond the target,
# continues each part beyond the cut: an input is then off by its interpolation's roundings, of the
# largest value that it takes.
CONTINUED = 4 * 2.0**-23
# The pixels to subtract, as y · 2 + x within the quad: by direction, and row or column.
_PAIRS = {"x": ((0, 1), (2, 3)), "y": ((0, 2), (1, 3))}


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


def difference(p: Any, frag_coord: Any, direction: str, *, own: bool) -> Any:
    """How much `p` grows by one pixel in x or y, as a device may find it.

    Args:
        p: (count, n), a value for each pixel; what is the same for all has differences of 0.
        frag_coord: (count, 2 or more), where the pixels are.
        direction: "x" or "y".
        own: whether the pixel's own row (or column) of the quad is meant; else either is legal.

    Returns (count, n). Where a pixel of the quad was not drawn, anything is allowed, and NaN is the
    float64 value. Raises FormulaError: there are other numbers of values than of places."""
    place = frag_coord.lo if isinstance(frag_coord, Band) else np.asarray(frag_coord, np.float64)
    if not hasattr(p, "shape") or p.ndim < 2 or p.shape[0] == 1:
        return p - p
    if p.shape[0] != place.shape[0]:
        raise FormulaError(f"differences of {p.shape[0]} values at {place.shape[0]} pixels")
    members, mine = _find_quads(place, direction)
    differences: list[Any] = []
    missing: list[Any] = []
    for first, second in _PAIRS[direction]:
        at, beside = members[:, first], members[:, second]
        missing.append(((at < 0) | (beside < 0))[:, None])
        if isinstance(p, Band):
            differences.append(subtract(p[beside].without_terms(), p[at].without_terms()))
        else:
            differences.append(np.where(missing[-1], np.nan, p[beside] - p[at]))
    nearest, lost = _choose_own(differences, missing, mine)
    if not isinstance(p, Band):
        return nearest.view(type(p))
    result = nearest if own else union(differences[0], differences[1])
    unknown = lost if own else missing[0] | missing[1]
    largest = np.where(np.isfinite(p.abs_sum), p.abs_sum, 0.0).max(axis=0)
    give = CONTINUED * largest
    return result.derive(result.lo - give, result.hi + give, anything=unknown)


def _choose_own(values: list[Any], missing: list[Any], second: Any) -> tuple[Any, Any]:
    lost = np.where(second, missing[1], missing[0])
    if not isinstance(values[0], Band):
        return np.where(second, values[1], values[0]), lost
    a, b = values
    lo, hi = np.where(second, b.lo, a.lo), np.where(second, b.hi, a.hi)
    return a.derive_exact(lo, hi, b), lost


def _find_quads(place: Any, direction: str) -> tuple[Any, Any]:
    """For each pixel the numbers of its quad's four, -1 for those that are missing; and whether
    the second row (or column) is its own, (count, 1)."""
    x, y = (np.floor(place[:, k]).astype(np.int64) for k in (0, 1))
    _, quad = np.unique((y >> 1) * (int(x.max(initial=0)) + 2) + (x >> 1), return_inverse=True)
    members = np.full((int(quad.max(initial=-1)) + 1, 4), -1, np.int64)
    members[quad, (y & 1) * 2 + (x & 1)] = np.arange(len(x))
    second = (y if direction == "x" else x) & 1 == 1
    return members[quad], second[:, None]
