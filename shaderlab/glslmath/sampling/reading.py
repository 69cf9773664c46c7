"""Single texels: wrap modes, the border, absent components, formats, depth comparison.

Source: OpenGL 4.5 core profile specification, §8.14.2 (wrap modes, table 8.20), §8.15 (the
border), §8.16 (absent components), §8.23.1 (depth comparison), §2.3.5.1 (normalised integers).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Rules
from shaderlab.bands.compiled import compiled
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array, Texels

from .spans import Span

Integers = npt.NDArray[np.int64]

LARGEST = {"depth16": 2.0**16 - 1.0, "depth24": 2.0**24 - 1.0}
# A code is turned into a float by a division, which may be off by 2.5 ULP.
CODE_PRECISION = 2.5 * 2.0**-23

# What the 256 codes are, and the bounds of what a device may read: 0 and 1 are floats, so that only
# the others are rounded.
_CODES = np.arange(256.0) / 255.0
_GIVE = np.where((_CODES == 0.0) | (_CODES == 1.0), 0.0, CODE_PRECISION * _CODES)
_LOWEST, _HIGHEST = _CODES - _GIVE, _CODES + _GIVE

EDGE = "clamp_to_edge"
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
        return _modulo(index, size)
    if mode == "mirrored_repeat":
        folded = _modulo(index, 2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded)
    if mode == "clamp_to_edge":
        return np.minimum(np.maximum(index, 0), size - 1)
    return np.where((index < 0) | (index >= size), -1, index)


def _modulo(index: Integers, size: int) -> Integers:
    """The index in 0…size−1; of a power of two its last bits, which a division takes far longer
    to find."""
    return np.mod(index, size) if size & (size - 1) else index & (size - 1)


@dataclass(frozen=True, eq=False)
class Decoding:
    """How stored values are read: codes by tables of the least and the greatest that each may be,
    numbers as they are, but for a relative error of those that are neither 0 nor 1."""

    lowest: Array | None = None
    highest: Array | None = None
    error: float = 0.0


_NUMBERS = Decoding()
_DEPTHS = Decoding(error=CODE_PRECISION)
_EXACT_CODES = Decoding(_CODES, _CODES)
_READ_CODES = Decoding(_LOWEST, _HIGHEST)


def decoding(sampler: Sampler) -> Decoding:
    """How a sampler's stored values are read. Raises FormulaError for sRGB."""
    texels = sampler.texels
    if texels.format.startswith("srgb"):
        raise FormulaError(
            "texture(): how precisely an sRGB texel is decoded differs from driver to driver",
            remedy='use a float format, such as Texture(format="rgba32f")',
        )
    if texels.values.dtype == np.uint8:
        return _EXACT_CODES if sampler.rules is None else _READ_CODES
    return _DEPTHS if texels.format[:7] in LARGEST and sampler.rules is not None else _NUMBERS


def lookup(sampler: Sampler, level: int, layer: Integers, *wrap: str) -> tuple[Any, ...]:
    """What `texels_at` takes besides whole numbers: a level, where in it, and how it is read."""
    texels, how = sampler.texels, decoding(sampler)
    fixed = texels.values.dtype == np.uint8 or texels.format in LARGEST
    border = _border(tuple(texels.border[: texels.values.shape[-1]]), fixed)
    modes = wrap or texels.wrap[:2]
    return (
        level_values(sampler, level), layer, *modes, how.lowest, how.highest, how.error, border
    )  # fmt: skip


@lru_cache(maxsize=64)
def _border(color: tuple[float, ...], fixed: bool) -> Array:
    """What a border's four components are, of texels that are fixed-point numbers or floats."""
    given = np.array(color, np.float32).astype(np.float64)
    return _completed((np.clip(given, 0.0, 1.0) if fixed else given,) * 2)[0]


@compiled
def texels_at(
    x: Array,
    y: Array,
    values: Array,
    layer: Integers,
    across: str,
    up: str,
    lowest: Array | None,
    highest: Array | None,
    error: float,
    border: Array,
) -> Span:
    """Texels at whole numbers of any size in (layers, height, width, channels), decoded, as
    (count, 4): absent components are 0, absent alpha is 1; the border where a layer is -1, too."""
    _, height, width, channels = values.shape
    column = wrap_index(x.astype(np.int64), width, across)
    row = wrap_index(y.astype(np.int64), height, up)
    outside = (column < 0) | (row < 0) | (layer < 0)
    place = np.where(outside, 0, (layer * height + row) * width + column)
    found = values.reshape(-1, channels).take(place, axis=0)
    low, high = _completed(_decoded(found, Decoding(lowest, highest, error)))
    if not outside.any():
        return low, high
    same, outside = low is high, outside[..., None]
    low = np.where(outside, border, low)
    return low, low if same else np.where(outside, border, high)


def stored(sampler: Sampler, level: int, x: Integers, y: Integers, layer: Integers) -> Span:
    """Texels inside a level, by column, row and layer, as (count, 4): absent components are 0,
    absent alpha is 1."""
    values = level_values(sampler, level)
    count, height, width, _ = values.shape
    if values.flags.c_contiguous:
        place = y * width + x if count == 1 else (layer * height + y) * width + x
        return stored_at(sampler, level, place)
    return _completed(_decoded(values[layer, y, x], decoding(sampler)))


def stored_at(sampler: Sampler, level: int, place: Integers) -> Span:
    """`stored` by the number of a texel, counted row by row and layer by layer."""
    values = level_values(sampler, level)
    found = values.reshape(-1, values.shape[-1]).take(place, axis=0)
    return _completed(_decoded(found, decoding(sampler)))


def wrapped(sampler: Sampler, level: int, x: Array, y: Array, layer: Integers) -> Span:
    """Texels at any integer column and row, and layer of three dimensions, by the sampler's wrap
    modes; (count, 4)."""
    if sampler.texels.kind == "3D":
        depth = level_values(sampler, level).shape[0]
        layer = wrap_index(layer, depth, sampler.texels.wrap[2])
    return texels_at(x, y, *lookup(sampler, level, layer))


def compared(function: str, reference: Span, texel: Span) -> Span:
    """A shadow sampler's answer for one texel: 1 where `reference function texel` holds, else 0;
    both where that depends on the last bits."""
    if function in _MIRRORED:
        return compared(_MIRRORED[function], texel, reference)
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


def _decoded(values: Array, how: Decoding) -> Span:
    """Stored values as the shader reads them."""
    if how.lowest is not None and how.highest is not None:
        low = how.lowest.take(values)
        return low, low if how.lowest is how.highest else how.highest.take(values)
    numbers = values.astype(np.float64)
    if not how.error:
        return numbers, numbers
    give = np.where((numbers == 0.0) | (numbers == 1.0), 0.0, how.error * numbers)
    return numbers - give, numbers + give


def _completed(span: Span) -> Span:
    low, high = span
    channels = low.shape[-1]
    if channels == 4:
        return span
    filler = np.broadcast_to(
        np.array([0.0, 0.0, 0.0, 1.0])[channels:], (*low.shape[:-1], 4 - channels)
    )
    whole = np.concatenate([low, filler], axis=-1)
    return whole, whole if low is high else np.concatenate([high, filler], axis=-1)
