"""GLSL's texture functions (GLSL 4.60, 8.9), under their own names."""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer
from shaderlab.bands.swizzles import Vector
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array

from . import cube, filters, levels, reading, volume
from .reading import Integers, Sampler
from .spans import Span, component, components, hull, span_of

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

    Returns:
        (count, 4), or (count, 1) of a shadow sampler.

    Raises:
        FormulaError: `p` has another number of components, the filters need a level and none is
            given, or a band reaches over several texels.
    """
    return sampled(sampler, p, None if lod is None else component(span_of(lod), 0))


def sampled(sampler: Sampler, p: Any, level: Span | None, offset: Offset = (0, 0)) -> Any:
    """`texture` at a mipmap level, at a position moved by `offset` texels of each level read."""
    texels = sampler.texels
    wanted = COORDINATES.get(texels.kind, 0) + (texels.compare is not None)
    if texels.kind not in COORDINATES:
        raise FormulaError(f"texture(): a sampler{texels.kind} is read by texelFetch() alone")
    given = components(span_of(p))
    if given != wanted:
        shadow = "Shadow" * (texels.compare is not None)
        raise FormulaError(
            f"texture(): a sampler{texels.kind}{shadow} takes {wanted} coordinates, not {given}"
        )
    if texels.kind in ("2D", "2DArray"):
        return value_of(sampler, _of_plane(sampler, p, level, offset))
    if offset != (0, 0):
        raise FormulaError(
            f"offsets of a sampler{texels.kind} are not known; GLSL has none on cubes"
        )
    if texels.kind == "3D":
        return value_of(sampler, volume.sampled(sampler, p))
    return value_of(sampler, _of_cube(sampler, p, level))


def textureLod(sampler: Sampler, p: Any, lod: Any) -> Any:
    """GLSL's `textureLod`: a sample of an explicit mipmap level; else as `texture`."""
    return texture(sampler, p, lod)


def texelFetch(sampler: Sampler, p: Any, lod: Any = 0) -> Any:
    """GLSL's `texelFetch`: the texel at integer column and row (and layer), unfiltered.

    Args:
        sampler: any texture but a cube.
        p: integers (count, 2), of an array or three dimensions (count, 3).
        lod: the level; of a multisampled texture the sample's number. One for all.

    Raises:
        FormulaError: a texel or level is asked for that the texture does not have, which GLSL
            leaves undefined.
    """
    texels = sampler.texels
    if texels.kind == "Cube":
        raise FormulaError("texelFetch(): GLSL fetches no texels of cubes")
    low, high = span_of(p)
    place = np.rint(low).astype(np.int64)
    if low is not high and not np.array_equal(place, np.rint(high)):
        raise FormulaError("texelFetch(): a band holds several texels")
    number = int(span_of(lod)[0].flat[0])
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
    return value_of(sampler, reading.stored(sampler, level, *places))


def textureSize(sampler: Sampler, lod: Any = 0) -> Integer:
    """GLSL's `textureSize`: (width, height) of a level in texels, then the layers of an array or
    the depth in three dimensions.

    >>> from shaderlab.model.frame import Texels
    >>> image = Texels(np.zeros((2, 4, 1)), ("nearest",) * 2, ("repeat",) * 2, (0.0,) * 4)
    >>> textureSize(Sampler(image))
    Integer(int, [4, 2] … [4, 2])
    """
    count, height, width, _ = reading.level_values(sampler, int(span_of(lod)[0].flat[0])).shape
    deep = sampler.texels.kind in ("2DArray", "3D")
    size = (width, height, count) if deep else (width, height)
    return Integer(np.array(size), rules=sampler.rules)


def textureQueryLevels(sampler: Sampler) -> int:
    """GLSL's `textureQueryLevels`: how many mipmap levels there are."""
    return 1 + len(sampler.texels.smaller)


def _of_plane(sampler: Sampler, p: Any, lod: Span | None, offset: Offset) -> Span:
    texels = sampler.texels
    reference = reference_of(sampler, p)
    layers: list[Integers] = [np.zeros(span_of(p)[0].shape[:-1], np.int64)]
    if texels.kind == "2DArray":
        count = reading.level_values(sampler, 0).shape[0]
        low, high = component(span_of(p), 2)
        ends = [low] if low is high else [low, high]
        layers = [np.clip(np.floor(end + 0.5), 0, count - 1).astype(np.int64) for end in ends]

    def filtered(level: int, word: str) -> Span:
        height, width = reading.level_values(sampler, level).shape[1:3]
        uv = p[..., 0:2] if isinstance(p, Band) else np.asarray(p, np.float64)[..., 0:2]
        place = span_of(uv * np.array([width, height], np.float64))
        x, y = component(place, 0), component(place, 1)
        found = []
        for number in layers:

            def texel(column: Array, row: Array, at: Any, number: Integers = number) -> Span:
                column, row = column + offset[0], row + offset[1]
                found = reading.wrapped(sampler, level, column, row, number[at])
                return compared(sampler, reference, found, at)

            whole = None
            if word == "nearest" and reference is None and offset == (0, 0):
                whole = reading.lookup(sampler, level, number)
            found.append(_filtered(sampler, word, texel, x, y, whole))
        return hull(found)

    return levels.at_level(sampler, filtered, lod)


def _of_cube(sampler: Sampler, p: Any, lod: Span | None) -> Span:
    reference = reference_of(sampler, p)
    bounds = span_of(p)
    shorter = bounds[0][..., :3]
    direction = (shorter,) * 2 if bounds[0] is bounds[1] else (shorter, bounds[1][..., :3])
    faces = list(cube.met_faces(direction, sampler.rules is None))

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
                    how = reading.lookup(sampler, level, number, reading.EDGE, reading.EDGE)
                    found = reading.texels_at(column, row, *how)
                else:
                    found = cube.across_edges(sampler, level, column, row, number)
                return compared(sampler, depths, found, at)

            x, y = (
                (e[0] * size,) * 2 if e[0] is e[1] else (e[0] * size, e[1] * size) for e in (s, t)
            )
            whole = None
            if word == "nearest" and depths is None:
                number = np.full(x[0].shape, face, np.int64)
                whole = reading.lookup(sampler, level, number, reading.EDGE, reading.EDGE)
            part = _filtered(sampler, word, texel, x, y, whole)
            if low is None:
                shape = (*may.shape, part[0].shape[-1])
                low, high = np.full(shape, np.inf), np.full(shape, -np.inf)
            low[may], high[may] = np.minimum(low[may], part[0]), np.maximum(high[may], part[1])
        return low, high

    return levels.at_level(sampler, filtered, lod)


def _filtered(
    sampler: Sampler, word: str, texel: filters.Texel, x: Span, y: Span, whole: Any = None
) -> Span:
    """A sample by the filter `word`; `whole` is the lookup of texels that nothing compares, which
    NEAREST finds in one pass."""
    if whole is not None:
        return filters.nearest_texels(*x, *y, *whole)
    if word == "nearest":
        return filters.nearest(texel, x, y)
    compared = sampler.texels.compare is not None
    return filters.linear(texel, x, y, exact=sampler.rules is None, compared=compared)


def reference_of(sampler: Sampler, p: Any) -> Span | None:
    """What a shadow sampler compares with, (count, 1); clamped as fixed-point depths are."""
    if sampler.texels.compare is None:
        return None
    span = span_of(p)
    last = components(span) - 1
    bounds = tuple(bound[..., last:] for bound in span)
    if sampler.texels.format[:7] in reading.LARGEST:
        bounds = tuple(np.clip(bound, 0.0, 1.0) for bound in bounds)
    return bounds[0], bounds[1]


def compared(sampler: Sampler, reference: Span | None, found: Span, at: Any) -> Span:
    """What a shadow sampler answers for the texels found at an index into all places."""
    if reference is None or sampler.texels.compare is None:
        return found
    depth = (found[0][..., 0:1], found[1][..., 0:1])
    return reading.compared(sampler.texels.compare, (reference[0][at], reference[1][at]), depth)


def value_of(sampler: Sampler, span: Span) -> Any:
    """The result of a sampler: a band, float64 values, or integers."""
    integers = np.dtype(sampler.texels.values.dtype).kind in "iu" and "32" in sampler.texels.format
    if integers:
        unsigned = sampler.texels.format.endswith("ui")
        return Integer(*map(np.rint, span), unsigned=unsigned, rules=sampler.rules)
    if sampler.rules is None:
        return span[0].view(Vector)
    return Band.between(span[0], span[1], sampler.rules)
