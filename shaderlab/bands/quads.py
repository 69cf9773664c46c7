"""Differences between the pixels of a 2 × 2 quad, of which derivatives are made.

Source: the OpenGL Shading Language 4.60 (Khronos), 8.14.1 "Derivative Functions"; the Vulkan
specification (Khronos), "Derivative Operations": quads begin at even window coordinates.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands.arithmetic import add
from shaderlab.bands.band import Band
from shaderlab.bands.exact import negative, union
from shaderlab.errors import FormulaError

# A device that cuts a triangle in two, as llvmpipe does with those that reach beyond the target,
# continues each part beyond the cut: an input is then off by its interpolation's roundings, of the
# largest value that it takes.
CONTINUED = 4 * 2.0**-23
# The pixels to subtract, as y · 2 + x within the quad: by direction, and row or column.
_PAIRS = {"x": ((0, 1), (2, 3)), "y": ((0, 2), (1, 3))}


def difference(p: Any, frag_coord: Any, direction: str, *, own: bool) -> Any:
    """How much `p` grows by one pixel in x or y, as a device may find it.

    Args:
        p: (count, n), a value for each pixel; what is the same for all has differences of 0.
        frag_coord: (count, 2 or more), where the pixels are.
        direction: "x" or "y".
        own: whether the pixel's own row (or column) of the quad is meant; else either is legal.

    Returns:
        (count, n). Where a pixel of the quad was not drawn, anything is allowed, and NaN is the
        float64 value.

    Raises:
        FormulaError: there are other numbers of values than of places.
    """
    place = frag_coord.lo if isinstance(frag_coord, Band) else np.asarray(frag_coord, np.float64)
    if not hasattr(p, "shape") or p.ndim < 2 or p.shape[0] == 1:
        return p - p
    if p.shape[0] != place.shape[0]:
        raise FormulaError(f"differences of {p.shape[0]} values at {place.shape[0]} pixels")
    members, mine = _quads(place, direction)
    differences: list[Any] = []
    missing: list[Any] = []
    for first, second in _PAIRS[direction]:
        at, beside = members[:, first], members[:, second]
        missing.append(((at < 0) | (beside < 0))[:, None])
        if isinstance(p, Band):
            differences.append(add(p[beside].opaque(), negative(p[at].opaque())))
        else:
            differences.append(np.where(missing[-1], np.nan, p[beside] - p[at]))
    nearest, lost = _own(differences, missing, mine)
    if not isinstance(p, Band):
        return nearest.view(type(p))
    result = nearest if own else union(differences[0], differences[1])
    unknown = lost if own else missing[0] | missing[1]
    largest = np.where(np.isfinite(p.mag), p.mag, 0.0).max(axis=0)
    give = CONTINUED * largest
    return result.made(result.lo - give, result.hi + give, anything=unknown)


def _own(values: list[Any], missing: list[Any], second: Any) -> tuple[Any, Any]:
    """Of the two rows or columns, each pixel's own."""
    lost = np.where(second, missing[1], missing[0])
    if not isinstance(values[0], Band):
        return np.where(second, values[1], values[0]), lost
    a, b = values
    lo, hi = np.where(second, b.lo, a.lo), np.where(second, b.hi, a.hi)
    return a.kept(lo, hi, b), lost


def _quads(place: Any, direction: str) -> tuple[Any, Any]:
    """For each pixel the numbers of its quad's four, -1 for those that are missing; and whether
    the second row (or column) is its own, (count, 1)."""
    x, y = (np.floor(place[:, k]).astype(np.int64) for k in (0, 1))
    _, quad = np.unique((y >> 1) * (int(x.max(initial=0)) + 2) + (x >> 1), return_inverse=True)
    members = np.full((int(quad.max(initial=-1)) + 1, 4), -1, np.int64)
    members[quad, (y & 1) * 2 + (x & 1)] = np.arange(len(x))
    second = (y if direction == "x" else x) & 1 == 1
    return members[quad], second[:, None]
