"""Coordinates as pairs of bounds, of numbers and bands alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Band, Integer, Rules
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array, Texels

__all__ = ["Sampler", "cube_face", "wrap_index"]

Span = tuple[Array, Array]
"""The least and the greatest value; for a number both are the same array."""


def to_span(value: Any) -> Span:
    """The bounds of a coordinate, (count, components) or (components,), as float64."""
    if isinstance(value, Band):
        low, high = value.apply_slack()
        return (low, low) if value.lo is value.hi and low is value.lo else (low, high)
    if isinstance(value, Integer):
        low = value.lo.astype(np.float64)
        return (low, low) if value.known else (low, value.hi.astype(np.float64))
    number = np.atleast_1d(np.asarray(value, np.float64))
    return number, number


def map_span(function: Callable[[Array], Array], span: Span) -> Span:
    """A function of both bounds, called once where they are the same."""
    low = function(span[0])
    return low, low if span[0] is span[1] else function(span[1])


def component(span: Span, index: int) -> Span:
    """One component of a coordinate, without the last axis."""
    return map_span(lambda bound: bound[..., index], span)


def components(span: Span) -> int:
    """How many components a coordinate has."""
    return int(span[0].shape[-1])


def widen(span: Span, amount: Any) -> Span:
    """The span extended by `amount` on both sides."""
    return span[0] - amount, span[1] + amount


def hull(parts: list[Span]) -> Span:
    """The least span that holds all of them."""
    if len(parts) == 1:
        return parts[0]
    lows, highs = zip(*parts, strict=True)
    return np.minimum.reduce(lows), np.maximum.reduce(highs)


def require_narrow(span: Span, what: str) -> None:
    """Raise FormulaError if a span, in texels or levels, is wider than 1."""
    low, high = span
    if low is not high and not (high - low <= 1.0).all():
        raise FormulaError(
            f"{what}: a coordinate's band spans more than two texels",
            remedy="judge the coordinate by itself, and the sample of captured coordinates",
        )


Integers = npt.NDArray[np.int64]

LARGEST = {"depth16": 2.0**16 - 1.0, "depth24": 2.0**24 - 1.0}
# A code is turned into a float by a division, which may be off by 2.5 ULP.
CODE_PRECISION = 2.5 * 2.0**-23

# What the 256 codes are, and the bounds of what a device may read: 0 and 1 are floats, so that only
# the others are rounded.
_CODES = np.arange(256.0) / 255.0
_GIVE = np.where((_CODES == 0.0) | (_CODES == 1.0), 0.0, CODE_PRECISION * _CODES)
_LOWEST, _HIGHEST = _CODES - _GIVE, _CODES + _GIVE

_MIRRORED = {"greater": "less", "gequal": "lequal"}


@dataclass(frozen=True)
class Sampler:
    """A bound texture; `rules` are those of the bands it returns, None for float64 arrays."""

    texels: Texels
    rules: Rules | None = None


def level_values(sampler: Sampler, level: int) -> Array:
    """One mipmap level as (layers, height, width, channels); a plain texture has one layer."""
    texels = sampler.texels
    values = texels.values if level == 0 else texels.smaller[level - 1]
    return values[None] if values.ndim == 3 else values


def wrap_index(index: Integers, size: int, mode: str) -> Integers:
    """The texel that an index outside 0…size−1 stands for; −1 means the border.

    >>> [int(wrap_index(np.array([i]), 4, "mirrored_repeat")[0]) for i in (-2, -1, 0, 4, 5)]
    [1, 0, 0, 3, 2]
    """
    if mode == "repeat":
        return np.mod(index, size) if size & (size - 1) else index & (size - 1)  # which is faster
    if mode == "mirrored_repeat":
        folded = np.mod(index, 2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded)
    if mode == "clamp_to_edge":
        return np.minimum(np.maximum(index, 0), size - 1)
    return np.where((index < 0) | (index >= size), -1, index)


@lru_cache(maxsize=64)
def _border(color: tuple[float, ...], fixed: bool) -> Array:
    given = np.array(color, np.float32).astype(np.float64)
    return _complete((np.clip(given, 0.0, 1.0) if fixed else given,) * 2)[0]


def fetch(sampler: Sampler, level: int, x: Integers, y: Integers, layer: Integers) -> Span:
    """Texels of a level, by column, row and layer, (count, 4): absent components are 0, alpha 1."""
    _, height, width, _ = level_values(sampler, level).shape
    return _fetch_numbered(sampler, level, (layer * height + y) * width + x)


def _fetch_numbered(sampler: Sampler, level: int, place: Integers) -> Span:
    values = level_values(sampler, level)
    found = values.reshape(-1, values.shape[-1]).take(place, axis=0)
    return _complete(_decode(sampler, found))


def read_texels(
    sampler: Sampler, level: int, x: Array, y: Array, layer: Integers, edge: str | None = None
) -> Span:
    """Texels at any integer column and row, and layer of three dimensions, by the sampler's wrap
    modes or `edge` for both; (count, 4). The border where a layer is -1, too."""
    depth, height, width, channels = level_values(sampler, level).shape
    modes = (edge,) * 2 if edge else sampler.texels.wrap
    if sampler.texels.kind == "3D":
        layer = wrap_index(layer, depth, modes[2])
    column = wrap_index(x.astype(np.int64), width, modes[0])
    row = wrap_index(y.astype(np.int64), height, modes[1])
    outside = (column < 0) | (row < 0) | (layer < 0)
    if not outside.any():
        return fetch(sampler, level, column, row, layer)
    found = fetch(sampler, level, *(np.where(outside, 0, n) for n in (column, row, layer)))
    texels = sampler.texels
    fixed = texels.values.dtype == np.uint8 or texels.format in LARGEST
    border = _border(tuple(texels.border[:channels]), fixed)
    return map_span(lambda bound: np.where(outside[..., None], border, bound), found)


def compare(function: str, reference: Span, texel: Span) -> Span:
    """A shadow sampler's answer for one texel: 1 where `reference function texel` holds, else 0;
    both where that depends on the last bits."""
    if function in _MIRRORED:
        return compare(_MIRRORED[function], texel, reference)
    (r_low, r_high), (t_low, t_high) = reference, texel
    sure: Any
    may: Any
    if function in ("less", "lequal"):
        holds = np.less if function == "less" else np.less_equal
        sure, may = holds(r_high, t_low), holds(r_low, t_high)
    elif function in ("equal", "notequal"):
        may = (r_low <= t_high) & (t_low <= r_high)
        sure = may & (r_low == r_high) & (t_low == t_high)
        if function == "notequal":
            sure, may = ~may, ~sure
    else:
        sure = may = np.full(np.broadcast_shapes(r_low.shape, t_low.shape), function == "always")
    return sure.astype(np.float64), may.astype(np.float64)


def _decode(sampler: Sampler, values: Array) -> Span:
    """Stored values as the shader reads them: codes, or numbers with a relative error of depths
    that are neither 0 nor 1. Raises FormulaError for sRGB."""
    texels, exact = sampler.texels, sampler.rules is None
    if texels.format.startswith("srgb"):
        raise FormulaError(
            "texture(): how precisely an sRGB texel is decoded differs from driver to driver",
            remedy='use a float format, such as Texture(format="rgba32f")',
        )
    if texels.values.dtype == np.uint8:
        low = (_CODES if exact else _LOWEST).take(values)
        return low, low if exact else _HIGHEST.take(values)
    numbers = values.astype(np.float64)
    if exact or texels.format[:7] not in LARGEST:
        return numbers, numbers
    give = np.where((numbers == 0.0) | (numbers == 1.0), 0.0, CODE_PRECISION * numbers)
    return numbers - give, numbers + give


def _complete(span: Span) -> Span:
    *count, channels = span[0].shape
    if channels == 4:
        return span
    filler = np.broadcast_to(np.array([0.0, 0.0, 0.0, 1.0])[channels:], (*count, 4 - channels))
    return map_span(lambda bound: np.concatenate([bound, filler], axis=-1), span)


Flags = npt.NDArray[np.bool_]

# By face: the major axis; then the axis and the sign of s and of t (table 8.19).
_TABLE = (
    (0, (2, -1), (1, -1)),
    (0, (2, 1), (1, -1)),
    (1, (0, 1), (2, 1)),
    (1, (0, 1), (2, -1)),
    (2, (0, 1), (1, -1)),
    (2, (0, -1), (1, -1)),
)
# What dividing by the major axis may lose, of 1: a division and the sum before it.
_ROUNDING = 4 * 2.0**-23


def cube_face(direction: Any) -> tuple[Integers, Array, Array]:
    """The face that a direction meets (0…5 for +X, −X, +Y, −Y, +Z, −Z), and s and t on it;
    the direction is (…, 3), of any length but 0.

    >>> face, s, t = cube_face(np.array([2.0, 0.5, -1.0]))
    >>> int(face), float(s), float(t)
    (0, 0.75, 0.375)
    """
    given = np.asarray(direction, np.float64)
    axis = np.argmax(np.abs(given), axis=-1)
    major = np.take_along_axis(given, axis[..., None], -1)[..., 0]
    face = 2 * axis + (major < 0.0)
    table = np.array([[s[0], s[1], t[0], t[1]] for _, s, t in _TABLE])[face]
    s, t = (np.take_along_axis(given, table[..., k, None], -1)[..., 0] for k in (0, 2))
    s, t = s * table[..., 1], t * table[..., 3]
    return face, 0.5 * s / np.abs(major) + 0.5, 0.5 * t / np.abs(major) + 0.5


def find_faces(direction: Span, exact: bool) -> Iterator[tuple[int, Flags, Span, Span]]:
    """Each face that some directions may select: its number, which directions, and their s and t.

    `exact` for float64 directions, which select one face even if two components are equal.
    """
    axes = [component(direction, k) for k in range(3)]
    if exact:
        face, s, t = cube_face(direction[0])
        for number in np.unique(face):
            on = face == number
            yield int(number), on, (s[on],) * 2, (t[on],) * 2
        return
    sizes = [absolute(axis) for axis in axes]
    for number, (axis, s_axis, t_axis) in enumerate(_TABLE):
        low, high = axes[axis] if number % 2 == 0 else (-axes[axis][1], -axes[axis][0])
        others = np.maximum.reduce([sizes[k][0] for k in range(3) if k != axis])
        may = (high > 0.0) & (high >= others)
        if not may.any():
            continue
        # Where this face is met, the major axis is no smaller than the others.
        least = np.maximum(np.maximum(low[may], others[may]), np.finfo(np.float64).tiny)
        major = (least, np.maximum(high[may], least))
        of_s, of_t = (
            _on_face((axes[axis][0][may], axes[axis][1][may]), sign, major)
            for axis, sign in (s_axis, t_axis)
        )
        yield number, may, of_s, of_t


def read_across_edges(sampler: Sampler, level: int, x: Array, y: Array, face: Integers) -> Span:
    """Texels of a face or beyond its edges: of the adjacent face where filtering is
    seamless, else by the wrap modes."""
    if not sampler.texels.seamless:
        return read_texels(sampler, level, x, y, face)
    size = level_values(sampler, level).shape[1]
    column, row = x.astype(np.int64), y.astype(np.int64)
    inside_x, inside_y = (np.minimum(np.maximum(at, 0), size - 1) for at in (column, row))
    out_x, out_y = column != inside_x, row != inside_y
    place = (face * size + inside_y) * size + inside_x
    corner = out_x & out_y
    own = place[corner]
    for side, out, at, along in ((0, out_x, column, inside_y), (2, out_y, row, inside_x)):
        # Few texels lie beyond an edge. At a corner this ends with the neighbour above or below.
        few = out.nonzero()
        place[few] = _find_neighbours(size)[face[few], side + (at[few] > 0), along[few]]
    low, high = _fetch_numbered(sampler, level, place)
    if not corner.any():
        return low, high
    beside = _find_neighbours(size)[face[corner], (column[corner] > 0) + 0, inside_y[corner]]
    three = [_fetch_numbered(sampler, level, places) for places in (own, beside, place[corner])]
    if sampler.rules is None:
        low[corner] = sum(one for one, _ in three) / 3.0
        return low, low
    high = high.copy() if high is low else high
    low[corner], high[corner] = hull(three)
    return low, high


@lru_cache(maxsize=16)
def _find_neighbours(size: int) -> Integers:
    """Where the texels of adjacent faces lie, (6, 4, size): by face, then beyond its left, right,
    lower and upper edge, along that edge."""
    along = 2.0 * (np.arange(size) + 0.5) / size - 1.0
    outside = 2.0 * (size + 0.5) / size - 1.0
    found = np.empty((6, 4, size), np.int64)
    for face, (axis, s_axis, t_axis) in enumerate(_TABLE):
        for side in range(4):
            direction = np.empty((size, 3))
            ends = np.full(size, outside if side % 2 else -outside)
            s, t = (ends, along) if side < 2 else (along, ends)
            direction[:, axis] = 1.0 - 2.0 * (face % 2)
            direction[:, s_axis[0]], direction[:, t_axis[0]] = s * s_axis[1], t * t_axis[1]
            other, u, v = cube_face(direction)
            x, y = (np.clip(np.floor(at * size).astype(np.int64), 0, size - 1) for at in (u, v))
            found[face, side] = (other * size + y) * size + x
    return found


def absolute(span: Span) -> Span:
    """The bounds of a number's absolute value."""
    low, high = np.abs(span[0]), np.abs(span[1])
    least = np.where((span[0] < 0.0) & (span[1] > 0.0), 0.0, np.minimum(low, high))
    return least, np.maximum(low, high)


def _on_face(along: Span, sign: int, major: Span) -> Span:
    """0.5·(±along / major) + 0.5, in 0…1."""
    ends = [sign * a / m for a in along for m in major]
    low, high = np.minimum.reduce(ends), np.maximum.reduce(ends)
    low, high = 0.5 * low + 0.5 - _ROUNDING, 0.5 * high + 0.5 + _ROUNDING
    return np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)


Filtered = Callable[[int, str], Span]
"""A sample of one level, filtered "nearest" or "linear"."""


def filter_at_level(sampler: Sampler, filtered: Filtered, lod: Span | None) -> Span:
    """A sample at a level of detail: magnified, minified from one level, or a mix of two levels.
    Raises FormulaError: the filters depend on a level, and it is None."""
    texels = sampler.texels
    minify, magnify = texels.filter
    within, _, between = minify.partition("_mipmap_")
    if minify == magnify:
        return filtered(0, magnify)
    if lod is None:
        raise FormulaError(
            f"texture(): with the filters {texels.filter} a sample depends on the mipmap level",
            remedy="give it as lod= (the logarithm of texels a pixel), or sample with textureLod",
        )
    low, high = (np.clip(bound, *texels.lod) for bound in lod)
    latest = 0.0
    if sampler.rules is not None and between and within == "nearest" and magnify == "linear":
        latest = 0.5
    magnified, minified = low <= latest, high > 0.0
    parts: list[tuple[Any, Span]] = []
    if magnified.any():
        parts.append((magnified, filtered(0, magnify)))
    if minified.any():
        parts.append((minified, _minify(sampler, filtered, within, between, (low, high))))
    result_low: Any = np.inf
    result_high: Any = -np.inf
    if len(parts) == 1 and parts[0][0].all():
        result_low, result_high = parts.pop()[1]
    for may, (part_low, part_high) in parts:
        result_low = np.where(may[..., None], np.minimum(result_low, part_low), result_low)
        result_high = np.where(may[..., None], np.maximum(result_high, part_high), result_high)
    if sampler.rules is not None and "linear" in {within, magnify}:
        return widen((result_low, result_high), ROUNDING * _find_largest(sampler))
    return result_low, result_high


def _find_largest(sampler: Sampler) -> float:
    """The greatest number that a sample can mix. Where the filter changes from pixel to pixel,
    drivers run NEAREST as a mix, too, with weights of 0 and 1 (llvmpipe does): its roundings stay.
    """
    texels = sampler.texels
    if texels.compare is not None or texels.values.dtype == np.uint8:
        return 1.0
    numbers = [np.abs(level).max() for level in (texels.values, *texels.smaller)]
    return float(max(*numbers, *(abs(value) for value in texels.border)))


def _minify(sampler: Sampler, filtered: Filtered, within: str, between: str, lod: Span) -> Span:
    last = len(sampler.texels.smaller)
    if not between:
        return filtered(0, within)
    lod = np.clip(lod[0], 0.0, last), np.clip(lod[1], 0.0, last)
    if between == "nearest":
        # Between two levels either: the specification's rounding, or the floor of one half more.
        ends = [np.ceil(lod[0] + 0.5) - 1.0, np.floor(lod[1] + 0.5)]
        chosen = [np.clip(end, 0, last) for end in ends[: 1 if sampler.rules is None else 2]]
        require_narrow((chosen[0], chosen[-1]), "texture(), the level")
        known = _sample_levels(filtered, within, chosen)
        return hull([_pick(known, number) for number in chosen])
    exact = sampler.rules is None
    place = lod if exact else widen(lod, WEIGHT)
    require_narrow(place, "texture(), the level")
    low, high = np.clip(place[0], 0, last), np.clip(place[1], 0, last)
    ends = [low] if exact else corners((low, high))
    below = [np.minimum(np.floor(end), max(last - 1, 0)) for end in ends]
    above = [np.minimum(number + 1, last) for number in below]
    known = _sample_levels(filtered, within, [*below, *above])
    found = []
    for one, other, end in zip(below, above, ends, strict=True):
        part = np.clip(end - one, 0.0, 1.0)
        found.append(_mix_layers(_pick(known, one), _pick(known, other), part, exact))
    return hull(found)


def _sample_levels(filtered: Filtered, within: str, numbers: list[Array]) -> dict[int, Span]:
    wanted = sorted({int(n) for number in numbers for n in np.unique(number)})
    return {number: filtered(number, within) for number in wanted}


def _pick(known: dict[int, Span], number: Array) -> Span:
    low: Any = np.nan
    high: Any = np.nan
    for level, (one, other) in known.items():
        here = (number == level)[..., None]
        low, high = np.where(here, one, low), np.where(here, other, high)
    return low, high


def _mix_layers(near: Span, far: Span, part: Array, exact: bool) -> Span:
    """Two levels or two layers, mixed. It is linear in `part`, so that its ends bound it."""
    share = part[..., None]
    low, high = (a * (1.0 - share) + b * share for a, b in zip(near, far, strict=True))
    if exact:
        return low, high
    # A product of three weights is rounded whatever the third is: what rounding adds to either
    # layer counts in full. It is half of the layer's width at most.
    mixed = (share > 0.0) & (share < 1.0)
    halves = [0.5 * (end - start) for start, end in (near, far)]
    give = np.where(mixed, share * halves[0] + (1.0 - share) * halves[1], 0.0)
    give += ROUNDING * np.maximum.reduce([np.abs(bound) for bound in (*near, *far)])
    return low - give, high + give


WEIGHT = 2.0**-8
"""How far a place may be off, in texels, before LINEAR mixes; and a level, in levels."""
ROUNDING = 8 * 2.0**-23
"""What mixing four texels in float32 may lose, of the largest of them: eight roundings."""
_PRODUCT = 0.5 * WEIGHT
"""How far the product of two weights may be off: hardware rounds it to a code as well, and keeps
the weights along each axis and their sum (measured on an NVIDIA H200)."""

Texel = Callable[[Array, Array, Any], Span]
"""Gives the texels at integer columns and rows, inside or outside, of some of the places: those
at an index into all of them."""

EVERYWHERE = ...
"""The index that leaves no place out."""


def nearest(texel: Texel, x: Span, y: Span) -> Span:
    """The texel that contains a position (in texels, 0 at the edge), or both candidates."""
    require_narrow(x, "texture()")
    require_narrow(y, "texture()")
    columns, rows = [np.floor(end) for end in ends_of(x)], [np.floor(end) for end in ends_of(y)]
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


def linear(
    texel: Texel, x: Span, y: Span, exact: bool, compared: bool = False, layered: bool = False
) -> Span:
    """The weighted mean of the four texels around a position; `exact` for float64 positions, and
    `layered` where it is to be mixed with that of another layer or level.

    Where `compared` texels, each 0 or 1, differ, a driver may return anything in between: OpenGL
    leaves open whether it compares one of them, all four, or (like softpipe) their mean.
    """
    if exact:
        column, row = x[0] - 0.5, y[0] - 0.5
        return _mix_cell(texel, (column, column), (row, row), EVERYWHERE)
    x, y = (x[0] - 0.5, x[1] - 0.5), (y[0] - 0.5, y[1] - 0.5)
    x, y = widen(x, WEIGHT), widen(y, WEIGHT)
    require_narrow(x, "texture()")
    require_narrow(y, "texture()")
    low, high = _mix_cell(texel, x, y, EVERYWHERE, layered)
    crossing = (np.floor(x[0]) < np.floor(x[1])) | (np.floor(y[0]) < np.floor(y[1]))
    if crossing.any():
        # Few places cross a texel centre's row or column: only those are split into pieces.
        x, y = ((start[crossing], end[crossing]) for start, end in (x, y))
        across, up = _split_at_integer(x), _split_at_integer(y)
        pieces = [_mix_cell(texel, a, b, crossing, layered) for a in across for b in up]
        low[crossing], high[crossing] = hull(pieces)
    if compared:
        # Weights of sum 1 give or take a last bit, and _mix_cell's own give.
        some = 2.0 * ROUNDING
        return np.where(low < 1.0 - some, 0.0, 1.0), np.where(high > some, 1.0, 0.0)
    return low, high


def corners(span: Span) -> list[Array]:
    """Where a function that is linear between integers takes its extremes in a span."""
    low, high = span
    if low is high:
        return [low]
    return [low, np.clip(np.ceil(low), low, high), high]


def _split_at_integer(span: Span) -> list[Span]:
    low, middle, high = corners(span)
    return [(low, middle), (middle, high)]


def ends_of(span: Span) -> list[Array]:
    """Both bounds, or the only one."""
    return [span[0]] if span[0] is span[1] else [span[0], span[1]]


def _mix_cell(texel: Texel, x: Span, y: Span, places: Any, layered: bool = False) -> Span:
    """The bounds of a mean of four texels over a box between their centres: those at its corners.

    Numbers, whose bounds are one array, have one corner and no rounding.
    """
    left, low = np.floor(x[0]), np.floor(y[0])
    across = [(end - left)[..., None] for end in ends_of(x)]
    up = [(end - low)[..., None] for end in ends_of(y)]
    texels = [texel(left + i, low + j, places) for j in (0, 1) for i in (0, 1)]
    if x[0] is x[1] and y[0] is y[1]:
        mean = _at_corners([lowest for lowest, _ in texels], across, up)[0]
        return mean, mean
    return _mix_texels(texels, across, up, layered)


def _mix_texels(texels: list[Span], across: list[Array], up: list[Array], layered: bool) -> Span:
    """The bounds of a mean of four texels, at the ends of both weights."""
    lows, highs = ([texel[k] for texel in texels] for k in (0, 1))
    give = ROUNDING * np.maximum.reduce([np.abs(bound) for bound in (*lows, *highs)])
    give += _PRODUCT * _weigh_rounding(texels, layered)
    return (
        np.minimum.reduce(_at_corners(lows, across, up)) - give,
        np.maximum.reduce(_at_corners(highs, across, up)) + give,
    )


def _weigh_rounding(texels: list[Span], layered: bool) -> Array:
    """How much a mean of four texels changes as products of weights are off by 1.

    Where both weights stay as they are, one number is free: that of the texels' second difference.
    Layers are mixed along one axis first, and then along the other: each edge counts then.
    """
    one, two, three, four = texels
    if not layered:
        diagonals = ((a[0] + b[0], a[1] + b[1]) for a, b in ((one, four), (two, three)))
        return _find_distance(*diagonals)
    sides = _find_distance(one, two), _find_distance(three, four)
    rises = _find_distance(one, three), _find_distance(two, four)
    orders = [a + b + np.maximum(c, d) for (a, b), (c, d) in ((sides, rises), (rises, sides))]
    found: Array = np.maximum.reduce(orders)
    return found


def _find_distance(one: Span, other: Span) -> Array:
    """The largest difference of two numbers."""
    found: Array = np.maximum(one[1] - other[0], other[1] - one[0])
    return found


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


def sample_volume(sampler: Sampler, p: Any) -> Span:
    """A sample of a "3D" texture at s, t and r, (count, 3) or (3,), an array or a band."""
    exact = sampler.rules is None
    depth, height, width, _ = level_values(sampler, 0).shape
    uvw = p if isinstance(p, Band) else np.asarray(p, np.float64)
    place = to_span(uvw * np.array([width, height, depth], np.float64))
    x, y, z = (component(place, axis) for axis in range(3))
    if sampler.texels.filter[1] == "nearest":
        require_narrow(z, "texture()")
        layers = [np.floor(end) for end in (z[:1] if exact else z)]
        return hull([nearest(_make_layer_reader(sampler, layer), x, y) for layer in layers])
    z = (z[0] - 0.5, z[1] - 0.5)
    if not exact:
        z = widen(z, WEIGHT)
        require_narrow(z, "texture()")

    def mixed(end: Array) -> Span:
        below = np.floor(end)
        texels = (_make_layer_reader(sampler, below + k) for k in (0.0, 1.0))
        near, far = (linear(texel, x, y, exact=exact, layered=True) for texel in texels)
        return _mix_layers(near, far, end - below, exact)

    return hull([mixed(end) for end in ([z[0]] if exact else corners(z))])


def _make_layer_reader(sampler: Sampler, number: Array) -> Texel:
    """The texels of a layer, which may differ from place to place."""

    def texel(column: Array, row: Array, at: Any) -> Span:
        return read_texels(sampler, 0, column, row, number.astype(np.int64)[at])

    return texel
