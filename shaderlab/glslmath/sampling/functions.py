"""GLSL's texture functions (GLSL 4.60, 8.9), under their own names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer
from shaderlab.bands.bounds import Vector
from shaderlab.errors import FormulaError
from shaderlab.glslmath.derivatives import difference
from shaderlab.model.frame import Array

from . import reading
from .reading import (
    WEIGHT,
    Integers,
    Sampler,
    Span,
    component,
    components,
    hull,
    map_span,
    require_narrow,
    to_span,
    widen,
)

__all__ = [
    "imageLoad", "imageSize", "texelFetch", "texelFetchOffset", "texture", "textureGather",
    "textureGatherOffset", "textureGatherOffsets", "textureGrad", "textureGradOffset",
    "textureLod", "textureLodOffset", "textureOffset", "textureProj", "textureProjGrad",
    "textureProjGradOffset", "textureProjLod", "textureProjLodOffset", "textureProjOffset",
    "textureQueryLevels", "textureQueryLod", "textureSamples", "textureSize",
]  # fmt: skip

Offset = tuple[int, int]
COORDINATES = {"2D": 2, "2DArray": 3, "3D": 3, "Cube": 3}
"""How many coordinates place a sample, by the sampler's kind."""


def texture(sampler: Sampler, p: Any, lod: Any = None) -> Any:
    """GLSL's `texture`: a filtered sample at the point `p`.

    Args:
        sampler: a texture; a shadow sampler answers with one component, how much of the four
            texels around (the nearest one, with NEAREST) passes the comparison. A band allows
            anything where the four disagree (OpenGL 4.5, §8.23.1, leaves it to the driver).
        p: coordinates (count, n) or (n,), as an array or a band: s, t; then r of three dimensions
            or the layer of an array; of a cube the direction; last the value that a shadow sampler
            compares.
        lod: the mipmap level that the derivatives give, where the filters depend on it.

    Returns (count, 4), or (count, 1) of a shadow sampler. Raises FormulaError: `p` has another
    number of components, the filters need a level and none is given, or a band reaches over several
    texels."""
    return sample(sampler, p, _to_level(lod))


def sample(sampler: Sampler, p: Any, level: Span | None, offset: Offset = (0, 0)) -> Any:
    """`texture` at a mipmap level, at a position moved by `offset` texels of each level read."""
    texels = sampler.texels
    wanted = COORDINATES.get(texels.kind, 0) + (texels.compare is not None)
    if texels.kind not in COORDINATES:
        raise FormulaError(f"texture(): a sampler{texels.kind} is read by texelFetch() alone")
    given = components(to_span(p))
    if given != wanted:
        shadow = "Shadow" * (texels.compare is not None)
        raise FormulaError(
            f"texture(): a sampler{texels.kind}{shadow} takes {wanted} coordinates, not {given}"
        )
    if texels.kind in ("2D", "2DArray"):
        return make_value(sampler, _sample_plane(sampler, p, level, offset))
    if offset != (0, 0):
        raise FormulaError(
            f"offsets of a sampler{texels.kind} are not known; GLSL has none on cubes"
        )
    if texels.kind == "3D":
        return make_value(sampler, reading.sample_volume(sampler, p))
    return make_value(sampler, _sample_cube(sampler, p, level))


def textureLod(sampler: Sampler, p: Any, lod: Any) -> Any:
    """GLSL's `textureLod`: a sample of an explicit mipmap level; else as `texture`."""
    return texture(sampler, p, lod)


def texelFetch(sampler: Sampler, p: Any, lod: Any = 0) -> Any:
    """GLSL's `texelFetch`: the texel at integer column and row (and layer), unfiltered.

    Args:
        sampler: any texture but a reading.
        p: integers (count, 2), of an array or three dimensions (count, 3).
        lod: the level; of a multisampled texture the sample's number. One for all.

    Raises FormulaError: a texel or level is asked for that the texture does not have, which GLSL
    leaves undefined."""
    texels = sampler.texels
    if texels.kind == "Cube":
        raise FormulaError("texelFetch(): GLSL fetches no texels of cubes")
    low, high = to_span(p)
    place = np.rint(low).astype(np.int64)
    if low is not high and not np.array_equal(place, np.rint(high)):
        raise FormulaError("texelFetch(): a band holds several texels")
    number = int(to_span(lod)[0].flat[0])
    level, layer = (0, number) if texels.kind == "2DMS" else (number, 0)
    if not 0 <= level <= len(texels.smaller):
        raise FormulaError(f"texelFetch(): there is no level {level}")
    layers: Integers = np.full(place.shape[:-1], layer, np.int64)
    if texels.kind in ("2DArray", "3D"):
        layers = place[..., 2]
    count, height, width, _ = reading.level_values(sampler, level).shape
    places, sizes = (place[..., 0], place[..., 1], layers), (width, height, count)
    if any(((n < 0) | (n >= size)).any() for n, size in zip(places, sizes, strict=True)):
        raise FormulaError(
            f"texelFetch(): a texel outside {width} × {height}"
            + (f" × {count}" if count > 1 else "")
        )
    return make_value(sampler, reading.fetch(sampler, level, *places))


def textureSize(sampler: Sampler, lod: Any = 0) -> Integer:
    """GLSL's `textureSize`: (width, height) of a level in texels, then the layers of an array or
    the depth in three dimensions.

    >>> from shaderlab.model.frame import Texels
    >>> image = Texels(np.zeros((2, 4, 1)), ("nearest",) * 2, ("repeat",) * 2, (0.0,) * 4)
    >>> textureSize(Sampler(image))
    Integer(int, [4, 2] … [4, 2])
    """
    count, height, width, _ = reading.level_values(sampler, int(to_span(lod)[0].flat[0])).shape
    deep = sampler.texels.kind in ("2DArray", "3D")
    size = (width, height, count) if deep else (width, height)
    return Integer(np.array(size), rules=sampler.rules)


def textureQueryLevels(sampler: Sampler) -> int:
    """GLSL's `textureQueryLevels`: how many mipmap levels there are."""
    return 1 + len(sampler.texels.smaller)


def _sample_plane(sampler: Sampler, p: Any, lod: Span | None, offset: Offset) -> Span:
    texels = sampler.texels
    reference = find_reference(sampler, p)
    layers: list[Integers] = [np.zeros(to_span(p)[0].shape[:-1], np.int64)]
    if texels.kind == "2DArray":
        count = reading.level_values(sampler, 0).shape[0]
        ends = reading.ends_of(component(to_span(p), 2))
        layers = [np.clip(np.floor(end + 0.5), 0, count - 1).astype(np.int64) for end in ends]

    def filtered(level: int, word: str) -> Span:
        height, width = reading.level_values(sampler, level).shape[1:3]
        uv = p[..., 0:2] if isinstance(p, Band) else np.asarray(p, np.float64)[..., 0:2]
        place = to_span(uv * np.array([width, height], np.float64))
        x, y = component(place, 0), component(place, 1)
        found = []
        for number in layers:

            def texel(column: Array, row: Array, at: Any, number: Integers = number) -> Span:
                column, row = column + offset[0], row + offset[1]
                found = reading.read_texels(sampler, level, column, row, number[at])
                return _compare(sampler, reference, found, at)

            found.append(_filter(sampler, word, texel, x, y))
        return hull(found)

    return reading.filter_at_level(sampler, filtered, lod)


def _sample_cube(sampler: Sampler, p: Any, lod: Span | None) -> Span:
    reference = find_reference(sampler, p)
    direction = map_span(lambda bound: bound[..., :3], to_span(p))
    faces = list(reading.find_faces(direction, sampler.rules is None))

    def filtered(level: int, word: str) -> Span:
        size = reading.level_values(sampler, level).shape[1]
        low: Any = None
        high: Any = None
        for face, may, s, t in faces:
            depths = None if reference is None else (reference[0][may], reference[1][may])

            def texel(
                column: Array, row: Array, at: Any, face: int = face, depths: Any = depths
            ) -> Span:
                number = np.full(column.shape, face, np.int64)
                if word == "nearest":
                    found = reading.read_texels(
                        sampler, level, column, row, number, "clamp_to_edge"
                    )
                else:
                    found = reading.read_across_edges(sampler, level, column, row, number)
                return _compare(sampler, depths, found, at)

            x, y = (map_span(lambda bound: bound * size, each) for each in (s, t))
            part = _filter(sampler, word, texel, x, y)
            if low is None:
                shape = (*may.shape, part[0].shape[-1])
                low, high = np.full(shape, np.inf), np.full(shape, -np.inf)
            low[may], high[may] = np.minimum(low[may], part[0]), np.maximum(high[may], part[1])
        return low, high

    return reading.filter_at_level(sampler, filtered, lod)


def _filter(sampler: Sampler, word: str, texel: reading.Texel, x: Span, y: Span) -> Span:
    if word == "nearest":
        return reading.nearest(texel, x, y)
    texels, exact = sampler.texels, sampler.rules is None
    layered = texels.filter[0].endswith("_mipmap_linear")
    return reading.linear(texel, x, y, exact, texels.compare is not None, layered)


def find_reference(sampler: Sampler, p: Any) -> Span | None:
    """What a shadow sampler compares with, (count, 1); clamped as fixed-point depths are."""
    if sampler.texels.compare is None:
        return None
    span = to_span(p)
    last = components(span) - 1
    if sampler.texels.format[:7] in reading.LARGEST:
        return map_span(lambda bound: np.clip(bound[..., last:], 0.0, 1.0), span)
    return map_span(lambda bound: bound[..., last:], span)


def _compare(sampler: Sampler, reference: Span | None, found: Span, at: Any) -> Span:
    """What a shadow sampler answers for the texels found at an index into all places."""
    if reference is None or sampler.texels.compare is None:
        return found
    depth = (found[0][..., 0:1], found[1][..., 0:1])
    return reading.compare(sampler.texels.compare, (reference[0][at], reference[1][at]), depth)


def make_value(sampler: Sampler, span: Span) -> Any:
    """The result of a sampler: a band, float64 values, or integers."""
    integers = np.dtype(sampler.texels.values.dtype).kind in "iu" and "32" in sampler.texels.format
    if integers:
        unsigned = sampler.texels.format.endswith("ui")
        return Integer(*map(np.rint, span), unsigned=unsigned, rules=sampler.rules)
    if sampler.rules is None:
        return span[0].view(Vector)
    return Band.between(span[0], span[1], sampler.rules)


# The texels of a footprint, counterclockwise from the upper left (GLSL 4.60, 8.9.4).
_FOOTPRINT: tuple[Offset, ...] = ((0, 1), (1, 1), (1, 0), (0, 0))


def textureGather(sampler: Sampler, p: Any, comp: int = 0) -> Any:
    """GLSL's `textureGather`: component `comp` of the four texels that LINEAR would mix, or the
    four comparisons of a shadow sampler, whose value to compare is p's last coordinate.

    A band holds the texels of both footprints where the place may lie in either.
    """
    return _gather(sampler, p, comp, _FOOTPRINT)


def textureGatherOffset(sampler: Sampler, p: Any, offset: Offset, comp: int = 0) -> Any:
    """GLSL's `textureGatherOffset`."""
    moved = [(x + offset[0], y + offset[1]) for x, y in _FOOTPRINT]
    return _gather(sampler, p, comp, moved)


def textureGatherOffsets(sampler: Sampler, p: Any, offsets: Sequence[Offset], comp: int = 0) -> Any:
    """GLSL's `textureGatherOffsets`: the lower left texel of the footprint at each offset."""
    if len(offsets) != 4:
        raise FormulaError(f"textureGatherOffsets() takes 4 offsets, not {len(offsets)}")
    return _gather(sampler, p, comp, offsets)


def textureQueryLod(sampler: Sampler, p: Any, frag_coord: Any) -> Any:
    """GLSL's `textureQueryLod`: the level that would be read, and the level of detail that the
    derivatives of p over a quad give, (count, 2).

    GLSL takes the derivatives implicitly; here they follow from `frag_coord`, the pixels of p.
    """
    dx, dy = (difference(p, frag_coord, direction, own=False) for direction in "xy")
    low, high = compute_level(sampler, dx, dy)
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
    return band.derive(band.lo, band.hi, anything=unknown[:, None])


def textureSamples(sampler: Sampler) -> Integer:
    """GLSL's `textureSamples`: how many samples a multisampled texture has."""
    if sampler.texels.kind != "2DMS":
        raise FormulaError(f"textureSamples(): a sampler{sampler.texels.kind} has no samples")
    return Integer(reading.level_values(sampler, 0).shape[0], rules=sampler.rules)


def _gather(sampler: Sampler, p: Any, comp: int, offsets: Sequence[Offset]) -> Any:
    if sampler.texels.kind != "2D":
        raise FormulaError(f"textureGather() of a sampler{sampler.texels.kind} is not known")
    reference = find_reference(sampler, p)
    height, width = reading.level_values(sampler, 0).shape[1:3]
    place = to_span(p)
    ends = []
    for k, size in ((0, width), (1, height)):
        low, high = component(place, k)
        if sampler.rules is None:
            ends.append([np.floor(low * size - 0.5)])
            continue
        span = widen((low * size - 0.5, high * size - 0.5), WEIGHT)
        require_narrow(span, "textureGather()")
        ends.append([np.floor(end) for end in span])
    parts: list[Span] = []
    for column in ends[0]:
        for row in ends[1]:
            found = [_read_texel(sampler, reference, column + x, row + y, comp) for x, y in offsets]
            low, high = (np.concatenate(bounds, axis=-1) for bounds in zip(*found, strict=True))
            parts.append((low, high))
    return make_value(sampler, hull(parts))


def _read_texel(sampler: Sampler, reference: Span | None, column: Any, row: Any, comp: int) -> Span:
    layer = np.zeros(column.shape, np.int64)
    found = _compare(sampler, reference, reading.read_texels(sampler, 0, column, row, layer), ...)
    if reference is not None:
        return found
    return found[0][..., comp : comp + 1], found[1][..., comp : comp + 1]


def imageLoad(image: Sampler, p: Any) -> Any:
    """GLSL's `imageLoad`: the texel at integer column and row (and layer); 0 outside of the image.

    Source: OpenGL 4.5 core profile specification, §8.26 (invalid image loads return zero).

    Args:
        image: what it held before the dispatch.
        p: integers (count, 2), of an image2DArray or image3D (count, 3).

    Returns (count, 4); components that the format lacks are 0, alpha is 1. Raises FormulaError: `p`
    has another number of components, or a band holds several texels."""
    low, high = to_span(p)
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
    ends = reading.fetch(image, 0, x, y, layer[0] if layer else np.zeros_like(x))
    inside = [np.where(outside, 0.0, end) for end in ends]
    return make_value(image, (inside[0], inside[1]))


def imageSize(image: Sampler) -> Integer:
    """GLSL's `imageSize`: (width, height) in texels, then the layers of an array or the depth of an
    image3D."""
    return textureSize(image)


# How far log2(m) lies above m - 1 for m in 1…2, at most (where m = 1 / ln 2).
LINEAR_LOGARITHM = 0.0861


def textureOffset(sampler: Sampler, p: Any, offset: Offset, lod: Any = None) -> Any:
    """GLSL's `textureOffset`; `lod` as for `texture`."""
    return sample(sampler, p, _to_level(lod), offset)


def textureLodOffset(sampler: Sampler, p: Any, lod: Any, offset: Offset) -> Any:
    """GLSL's `textureLodOffset`."""
    return sample(sampler, p, _to_level(lod), offset)


def texelFetchOffset(sampler: Sampler, p: Any, lod: Any, offset: Offset) -> Any:
    """GLSL's `texelFetchOffset`: the texel at p + `offset`; undefined outside the texture."""
    low, high = to_span(p)
    if not np.array_equal(np.rint(low), np.rint(high)):
        raise FormulaError("texelFetchOffset(): a band holds several texels")
    step = np.zeros(low.shape[-1])
    step[:2] = offset
    return texelFetch(sampler, np.rint(low) + step, lod)


def textureProj(sampler: Sampler, p: Any, lod: Any = None) -> Any:
    """GLSL's `textureProj`: p's coordinates are divided by its last one."""
    return sample(sampler, _project(sampler, p), _to_level(lod))


def textureProjOffset(sampler: Sampler, p: Any, offset: Offset, lod: Any = None) -> Any:
    """GLSL's `textureProjOffset`."""
    return sample(sampler, _project(sampler, p), _to_level(lod), offset)


def textureProjLod(sampler: Sampler, p: Any, lod: Any) -> Any:
    """GLSL's `textureProjLod`."""
    return sample(sampler, _project(sampler, p), _to_level(lod))


def textureProjLodOffset(sampler: Sampler, p: Any, lod: Any, offset: Offset) -> Any:
    """GLSL's `textureProjLodOffset`."""
    return sample(sampler, _project(sampler, p), _to_level(lod), offset)


def textureGrad(sampler: Sampler, p: Any, dPdx: Any, dPdy: Any) -> Any:
    """GLSL's `textureGrad`: the level follows from these derivatives of p, (…, 2)."""
    return sample(sampler, p, compute_level(sampler, dPdx, dPdy))


def textureGradOffset(sampler: Sampler, p: Any, dPdx: Any, dPdy: Any, offset: Offset) -> Any:
    """GLSL's `textureGradOffset`."""
    return sample(sampler, p, compute_level(sampler, dPdx, dPdy), offset)


def textureProjGrad(sampler: Sampler, p: Any, dPdx: Any, dPdy: Any) -> Any:
    """GLSL's `textureProjGrad`: the derivatives are those of the projected coordinates."""
    return sample(sampler, _project(sampler, p), compute_level(sampler, dPdx, dPdy))


def textureProjGradOffset(sampler: Sampler, p: Any, dPdx: Any, dPdy: Any, offset: Offset) -> Any:
    """GLSL's `textureProjGradOffset`."""
    return sample(sampler, _project(sampler, p), compute_level(sampler, dPdx, dPdy), offset)


def compute_level(sampler: Sampler, dPdx: Any, dPdy: Any) -> Span:
    """The level of detail λ that derivatives of s and t give, before it is clamped.

    A device may take any scale between the larger of mᵤ and mᵥ and their sum, where mᵤ is the
    larger of |∂u/∂x| and |∂u/∂y| (OpenGL 4.5, §8.14, equations 8.7 to 8.10). It leaves open how
    precise the logarithm is; llvmpipe's is linear between powers of two.
    """
    if sampler.texels.kind == "Cube":
        raise FormulaError("derivatives on cubes are not known; give the level to textureLod()")
    height, width = reading.level_values(sampler, 0).shape[1:3]
    du_dx, du_dy, dv_dx, dv_dy = (
        reading.absolute(component(to_span(d), k)) for k in (0, 1) for d in (dPdx, dPdy)
    )
    with np.errstate(divide="ignore"):
        if sampler.rules is None:
            by_x = np.hypot(du_dx[0] * width, dv_dx[0] * height)
            by_y = np.hypot(du_dy[0] * width, dv_dy[0] * height)
            level = np.log2(np.maximum(by_x, by_y))
            return level, level
        m_u = [np.maximum(a, b) * width for a, b in zip(du_dx, du_dy, strict=True)]
        m_v = [np.maximum(a, b) * height for a, b in zip(dv_dx, dv_dy, strict=True)]
        least, most = np.log2(np.maximum(m_u[0], m_v[0])), np.log2(m_u[1] + m_v[1])
    return widen((least - LINEAR_LOGARITHM, most), WEIGHT)


def _to_level(lod: Any) -> Span | None:
    return None if lod is None else component(to_span(lod), 0)


def _project(sampler: Sampler, p: Any) -> Any:
    """(s, t)/q, or (s, t, r)/q of a shadow sampler; otherwise the third of four is unused."""
    if sampler.texels.kind != "2D":
        raise FormulaError(f"GLSL projects onto no sampler{sampler.texels.kind}")
    shadow = sampler.texels.compare is not None
    given = components(to_span(p))
    if given not in ((4,) if shadow else (3, 4)):
        raise FormulaError(f"textureProj() takes 4 coordinates, or 3 without shadow, not {given}")
    p = p if isinstance(p, Band) else np.asarray(p, np.float64)
    return p[..., : 3 if shadow else 2] / p[..., given - 1 :]
