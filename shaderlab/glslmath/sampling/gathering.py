"""GLSL's texture gathers and queries (GLSL 4.60, 8.9.1 and 8.9.4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer
from shaderlab.bands.quads import difference
from shaderlab.errors import FormulaError

from . import reading
from .filters import WEIGHT
from .functions import Offset, compared, reference_of, value_of
from .lookups import level_of
from .reading import Sampler
from .spans import Span, component, hull, require_narrow, span_of, widened

# The texels of a footprint, counterclockwise from the upper left (GLSL 4.60, 8.9.4).
_FOOTPRINT: tuple[Offset, ...] = ((0, 1), (1, 1), (1, 0), (0, 0))


def textureGather(sampler: Sampler, p: Any, comp: int = 0) -> Any:
    """GLSL's `textureGather`: component `comp` of the four texels that LINEAR would mix, or the
    four comparisons of a shadow sampler, whose value to compare is p's last coordinate.

    A band holds the texels of both footprints where the place may lie in either.
    """
    return _gathered(sampler, p, comp, _FOOTPRINT)


def textureGatherOffset(sampler: Sampler, p: Any, offset: Offset, comp: int = 0) -> Any:
    """GLSL's `textureGatherOffset`."""
    moved = [(x + offset[0], y + offset[1]) for x, y in _FOOTPRINT]
    return _gathered(sampler, p, comp, moved)


def textureGatherOffsets(sampler: Sampler, p: Any, offsets: Sequence[Offset], comp: int = 0) -> Any:
    """GLSL's `textureGatherOffsets`: the lower left texel of the footprint at each offset."""
    if len(offsets) != 4:
        raise FormulaError(f"textureGatherOffsets() takes 4 offsets, not {len(offsets)}")
    return _gathered(sampler, p, comp, offsets)


def textureQueryLod(sampler: Sampler, p: Any, frag_coord: Any) -> Any:
    """GLSL's `textureQueryLod`: the level that would be read, and the level of detail that the
    derivatives of p over a quad give, (count, 2).

    GLSL takes the derivatives implicitly; here they follow from `frag_coord`, the pixels of p.
    """
    dx, dy = (difference(p, frag_coord, direction, own=False) for direction in "xy")
    low, high = level_of(sampler, dx, dy)
    between = sampler.texels.filter[0].partition("_mipmap_")[2]
    last = len(sampler.texels.smaller) if between else 0
    read = [np.clip(np.clip(end, *sampler.texels.lod), 0.0, last) for end in (low, high)]
    if between == "nearest":
        read = [np.ceil(read[0] - 0.5), np.floor(read[1] + 0.5)]
    ends = [np.stack([r, end], axis=-1) for r, end in zip(read, (low, high), strict=True)]
    if sampler.rules is None:
        return ends[0]
    band = Band.between(ends[0], ends[1], sampler.rules)
    unknown = dx.vacuous.any(axis=-1) | dy.vacuous.any(axis=-1)
    return band.made(band.lo, band.hi, anything=unknown[:, None])


def textureSamples(sampler: Sampler) -> Integer:
    """GLSL's `textureSamples`: how many samples a multisampled texture has."""
    if sampler.texels.kind != "2DMS":
        raise FormulaError(f"textureSamples(): a sampler{sampler.texels.kind} has no samples")
    return Integer(reading.level_values(sampler, 0).shape[0], rules=sampler.rules)


def _gathered(sampler: Sampler, p: Any, comp: int, offsets: Sequence[Offset]) -> Any:
    if sampler.texels.kind != "2D":
        raise FormulaError(f"textureGather() of a sampler{sampler.texels.kind} is not known")
    reference = reference_of(sampler, p)
    height, width = reading.level_values(sampler, 0).shape[1:3]
    place = span_of(p)
    ends = []
    for k, size in ((0, width), (1, height)):
        low, high = component(place, k)
        if sampler.rules is None:
            ends.append([np.floor(low * size - 0.5)])
            continue
        span = widened((low * size - 0.5, high * size - 0.5), WEIGHT)
        require_narrow(span, "textureGather()")
        ends.append([np.floor(end) for end in span])
    parts: list[Span] = []
    for column in ends[0]:
        for row in ends[1]:
            found = [_texel(sampler, reference, column + x, row + y, comp) for x, y in offsets]
            low, high = (np.concatenate(bounds, axis=-1) for bounds in zip(*found, strict=True))
            parts.append((low, high))
    return value_of(sampler, hull(parts))


def _texel(sampler: Sampler, reference: Span | None, column: Any, row: Any, comp: int) -> Span:
    layer = np.zeros(column.shape, np.int64)
    found = compared(sampler, reference, reading.wrapped(sampler, 0, column, row, layer), ...)
    if reference is not None:
        return found
    return found[0][..., comp : comp + 1], found[1][..., comp : comp + 1]
