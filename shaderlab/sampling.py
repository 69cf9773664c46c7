"""Textures as references read them: NEAREST sampling with every wrap mode, for numbers and bands.

Source: OpenGL 4.5 core profile specification, §8.14.2 (wrap modes, equations 8.14 and 8.15).
Float textures only: what an 8-bit texel reads as is rounded differently from driver to driver.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Band, Rules
from shaderlab.errors import FormulaError
from shaderlab.frame import Array, Texels

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Sampler:
    """A bound texture; `rules` are those of the bands it returns, None for float64 arrays."""

    texels: Texels
    rules: Rules | None = None


def texture(sampler: Sampler, uv: Any) -> Any:
    """GLSL's `texture` with NEAREST filters: the texel that holds the point `uv`.

    Args:
        sampler: a float texture.
        uv: coordinates (count, 2) or (2,), as an array or a band. A band that reaches over a
            texel's edge gives the hull of the texels on both sides.

    Raises:
        FormulaError: the texture filters linearly, or is not a float texture.
    """
    _require_nearest(sampler)
    height, width = sampler.texels.values.shape[:2]
    size = np.array([width, height], np.float64)
    if isinstance(uv, Band):
        scaled = uv * size
        low, high = np.floor(scaled.lo), np.floor(scaled.hi)
    else:
        low = high = np.floor(np.asarray(uv, np.float64) * size)
    if np.any(high - low > 1):
        raise FormulaError("texture(): a coordinate's band spans more than two texels")
    corners = [
        _fetch(sampler.texels, np.stack([x[..., 0], y[..., 1]], axis=-1))
        for x in (low, high)
        for y in (low, high)
    ]
    if sampler.rules is None:
        return corners[0]
    return Band.between(np.minimum.reduce(corners), np.maximum.reduce(corners), sampler.rules)


def texelFetch(sampler: Sampler, texel: Any, lod: int = 0) -> Any:
    """GLSL's `texelFetch` at level 0: the texel at integer coordinates (count, 2)."""
    _require_float(sampler)
    if lod != 0:
        raise FormulaError("texelFetch(): only level 0 is known to references")
    values = _fetch(sampler.texels, np.asarray(texel, np.float64))
    return values if sampler.rules is None else Band.exact(values, sampler.rules)


def wrap_index(index: Integers, size: int, mode: str) -> Integers:
    """The texel that an index outside 0…size−1 stands for; −1 means the border.

    >>> [int(wrap_index(np.array([i]), 4, "mirrored_repeat")[0]) for i in (-2, -1, 0, 4, 5)]
    [1, 0, 0, 3, 2]
    """
    if mode == "repeat":
        return np.mod(index, size)
    if mode == "mirrored_repeat":
        folded = np.mod(index, 2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded)
    if mode == "clamp_to_edge":
        return np.clip(index, 0, size - 1)
    return np.where((index < 0) | (index >= size), -1, index)


def _fetch(texels: Texels, index: Array) -> Array:
    height, width, channels = texels.values.shape
    x = wrap_index(index[..., 0].astype(np.int64), width, texels.wrap[0])
    y = wrap_index(index[..., 1].astype(np.int64), height, texels.wrap[1])
    found = texels.values[np.maximum(y, 0), np.maximum(x, 0)].astype(np.float64)
    border = np.asarray(texels.border[:channels], np.float64)
    found = np.where(((x < 0) | (y < 0))[..., None], border, found)
    # GLSL reads four components: absent ones are 0, absent alpha is 1.
    filler = np.broadcast_to(
        np.array([0.0, 0.0, 0.0, 1.0])[channels:], (*found.shape[:-1], 4 - channels)
    )
    return np.concatenate([found, filler], axis=-1)


def _require_nearest(sampler: Sampler) -> None:
    _require_float(sampler)
    if sampler.texels.filter != ("nearest", "nearest"):
        raise FormulaError(
            f"texture(): references sample with NEAREST, this texture has {sampler.texels.filter}",
            remedy='Texture(filter=("nearest", "nearest")), or judge what is made of the sample',
        )


def _require_float(sampler: Sampler) -> None:
    if sampler.texels.values.dtype.kind != "f":
        raise FormulaError(
            "texture(): what an 8-bit texel reads as differs from driver to driver",
            remedy='use a float format, such as Texture(format="rgba32f")',
        )
