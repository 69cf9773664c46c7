"""Putting arrays and bands one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.bands.band import Band
from shaderlab.bands.terms import combined


def joined(parts: Sequence[Band], axis: int) -> Band:
    """Bands of the same rules along a negative axis, the other axes broadcast."""
    lo = concatenated([part.lo for part in parts], axis)
    exact = all(part.lo is part.hi for part in parts)
    hi = lo if exact else concatenated([part.hi for part in parts], axis)
    flags = tuple(
        concatenated([np.broadcast_to(part.flags[i], part.shape) for part in parts], axis)
        if any(part.flags[i].ndim for part in parts)
        else parts[0].flags[i]
        for i in range(3)
    )
    terms = combined([(part.mag, part.terms) for part in parts], lambda a: concatenated(a, axis))
    return Band(lo, hi, parts[0].rules, (flags[0], flags[1], flags[2]), terms)


def concatenated(arrays: Sequence[Any], axis: int) -> Any:
    """NumPy's concatenate, along a negative axis, the axes other than that one broadcast."""
    ndim = max(max(array.ndim for array in arrays), -axis)
    shapes = [(1,) * (ndim - array.ndim) + array.shape for array in arrays]
    along = ndim + axis
    common = np.broadcast_shapes(*((*s[:along], 1, *s[along + 1 :]) for s in shapes))
    wide = [
        np.broadcast_to(array, (*common[:along], shape[along], *common[along + 1 :]))
        for array, shape in zip(arrays, shapes, strict=True)
    ]
    return np.concatenate(wide, axis=along)
