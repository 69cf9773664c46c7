"""Pictures of where two drivers' outputs differ, and by how much."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numpy as np

from shaderlab.errors import AssetError
from shaderlab.model import pictures
from shaderlab.model.frame import Array
from shaderlab.model.records import Disagreement

_MOST = 2.0**24
_SIDE = 320
_BAND = np.array([[255, 255, 255], [198, 219, 239], [107, 174, 214], [33, 113, 181], [8, 48, 107]])
_OUTSIDE = np.array([[255, 255, 255], [252, 187, 161], [251, 106, 74], [203, 24, 29], [103, 0, 13]])


def shades(apart: Array) -> Array:
    """How dark each pixel of a picture is, 0 (equal) to 4, uint8 (height, width).

    On a logarithmic scale to 2^24 units in the last place; of a large output each square of pixels
    gets the shade of the one that is furthest apart.

    Args:
        apart: by how much each pixel differs, (height, width).
    """
    apart = _reduced(apart, -(-max(apart.shape) // _SIDE))
    share = np.minimum(np.log2(1.0 + np.minimum(apart, _MOST)) / np.log2(1.0 + _MOST), 1.0)
    found: Array = np.where(apart > 0, 1 + np.minimum(share * 4.0, 3.0).astype(int), 0)
    return found.astype(np.uint8)


def write_picture(folder: Path, found: Disagreement, shades: Array) -> str:
    """Write a picture into a run's folder; returns its path in there, "" where it can't be written.

    Equal pixels are white; blue are those where both lie in their bands, red where a driver leaves
    one.
    """
    table = _OUTSIDE if found.verdict == "outside" else _BAND
    words = "\0".join((found.id, found.variant, found.output, *found.drivers))
    name = hashlib.blake2s(os.fsencode(words), digest_size=8).hexdigest()
    relative = f"images/apart-{name}.png"
    path = folder / relative
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        pictures.save_png(path, shades, min_side=1, palette=table.astype(np.uint8))
    except (AssetError, OSError):
        return ""
    return relative


def _reduced(apart: Array, factor: int) -> Array:
    """The largest value of each square of `factor` × `factor`; those at the ends are smaller."""
    rows, columns = (range(0, length, factor) for length in apart.shape)
    found: Array = np.maximum.reduceat(np.maximum.reduceat(apart, rows, axis=0), columns, axis=1)
    return found
