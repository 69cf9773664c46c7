"""GLSL's image functions that read (GLSL 4.60, 8.12), of what an image held before its dispatch."""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Integer
from shaderlab.errors import FormulaError

from . import reading
from .functions import value_of
from .reading import Sampler
from .spans import components, span_of


def imageLoad(image: Sampler, p: Any) -> Any:
    """GLSL's `imageLoad`: the texel at integer column and row (and layer); 0 outside of the image.

    Source: OpenGL 4.5 core profile specification, §8.26 (invalid image loads return zero).

    Args:
        image: what it held before the dispatch.
        p: integers (count, 2), of an image2DArray or image3D (count, 3).

    Returns:
        (count, 4); components that the format lacks are 0, alpha is 1.

    Raises:
        FormulaError: `p` has another number of components, or a band holds several texels.
    """
    low, high = span_of(p)
    wanted = 2 if image.texels.kind == "2D" else 3
    if components((low, high)) != wanted:
        given = components((low, high))
        raise FormulaError(
            f"imageLoad(): an image{image.texels.kind} takes {wanted} coordinates, not {given}"
        )
    if not np.array_equal(np.rint(low), np.rint(high)):
        raise FormulaError("imageLoad(): a band holds several texels")
    place = np.rint(low).astype(np.int64)
    count, height, width, _ = reading.level_values(image, 0).shape
    size = np.array((width, height, count)[:wanted])
    outside = np.any((place < 0) | (place >= size), axis=-1, keepdims=True)
    x, y, *layer = np.moveaxis(np.clip(place, 0, size - 1), -1, 0)
    ends = reading.stored(image, 0, x, y, layer[0] if layer else np.zeros_like(x))
    inside = [np.where(outside, 0.0, end) for end in ends]
    return value_of(image, (inside[0], inside[1]))


def imageSize(image: Sampler) -> Integer:
    """GLSL's `imageSize`: (width, height) in texels, then the layers of an array or the depth of an
    image3D."""
    count, height, width, _ = reading.level_values(image, 0).shape
    size = (width, height) if image.texels.kind == "2D" else (width, height, count)
    return Integer(np.array(size), rules=image.rules)
