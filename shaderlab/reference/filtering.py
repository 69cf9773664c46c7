"""Texture filtering: which texels are interpolated, with which weights.

Source: "The OpenGL Graphics System: A Specification", version 4.5 core (M. Segal, K. Akeley,
2017), section 8.14.2, equations 8.13 to 8.17 (nearest and linear filtering) and 8.14.4 (mipmaps).
The specification leaves open how precise weights are; hardware keeps them in fixed point: 8 bits
in Direct3D 11.3, section 7.18.8 ("Texture Addressing and LOD Precision"), at least 4 in Vulkan
(the limit subTexelPrecisionBits).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..bands import Band
from ..glslmath import Value, clamp, floor, fract, mix

Array = npt.NDArray[Any]


def nearest_texel(coordinate: Value, size: Value) -> Value:
    """The texel that holds a coordinate, before wrapping: ⌊u·size⌋ (equation 8.13).

    >>> float(nearest_texel(0.3, 4.0))
    1.0
    """
    return floor(coordinate * size)


def first_texel(coordinate: Value, size: Value) -> Value:
    """The lower of the two texels that linear filtering interpolates: ⌊u·size − ½⌋ (equation 8.15).

    Args:
        coordinate: u, 1 across the texture.
        size: its number of texels along u.

    >>> float(first_texel(0.3, 4.0)), float(first_texel(0.1, 4.0))
    (0.0, -1.0)
    """
    return floor(coordinate * size - 0.5)


def weight(coordinate: Value, size: Value, bits: int = 8) -> Value:
    """The upper texel's weight in linear filtering: fract(u·size − ½), 0…1.

    Args:
        coordinate, size: as in `first_texel`.
        bits: the weight's fixed-point precision; a band is widened by a code either way, and
            holds 0 and 1 where the weight may wrap round.

    >>> print(f"{weight(0.3, 4.0).item():.6f}")
    0.700000
    """
    exact = fract(coordinate * size - 0.5)
    if not isinstance(exact, Band):
        return exact
    code = 2.0**-bits
    return clamp(Band.between(exact.lo - code, exact.hi + code, exact.rules), 0.0, 1.0)


def bilinear(
    lower_left: Value,
    lower_right: Value,
    upper_left: Value,
    upper_right: Value,
    across: Value,
    up: Value,
) -> Value:
    """Four texels, interpolated along u and then along v (equation 8.17).

    Args:
        lower_left, lower_right, upper_left, upper_right: texels, (…, channels).
        across, up: `weight` along u and v, (…, 1).

    Returns (…, channels), within the four texels' range.

    >>> print(f"{bilinear(10.0, 20.0, 30.0, 40.0, 0.25, 0.5).item():.6f}")
    22.500000
    """
    lower = mix(lower_left, lower_right, across)
    upper = mix(upper_left, upper_right, across)
    return mix(lower, upper, up)


def box(lower_left: Value, lower_right: Value, upper_left: Value, upper_right: Value) -> Value:
    """A texel of the next mipmap level: the mean of the four below it.

    >>> float(box(1.0, 2.0, 3.0, 6.0))
    3.0
    """
    return (lower_left + lower_right + upper_left + upper_right) * 0.25


def wrapped_texel(index: Array, size: int, mode: str) -> Array:
    """The texel that an index outside 0…size − 1 wraps to (table 8.20); −1 is the border.

    >>> wrapped_texel(np.array([-2, -1, 0, 3, 4, 5]), 4, "mirrored_repeat").tolist()
    [1, 0, 0, 3, 3, 2]
    """

    def mirror(a: Array) -> Array:
        return np.where(a >= 0, a, -(1 + a))

    rules: dict[str, Callable[[Array], Array]] = {
        "repeat": lambda i: i % size,
        "mirrored_repeat": lambda i: (size - 1) - mirror((i % (2 * size)) - size),
        "clamp_to_edge": lambda i: np.clip(i, 0, size - 1),
        "clamp_to_border": lambda i: np.where((i < 0) | (i >= size), -1, i),
    }
    return rules[mode](index)


def linear_sample(image: Any, TexCoords: Array) -> Array:
    """A sample with LINEAR in plain NumPy, from the equations above, with the texture's own wrap
    modes and border: (count, 4).

    Args:
        image: a `shaderlab.glslmath.sampling.Sampler` of four channels.
        TexCoords: (count, 2).

    >>> from types import SimpleNamespace as Of
    >>> row = np.array([[10.0, 20.0, 30.0, 40.0]])[..., None] * np.ones(4)
    >>> modes = Of(values=row, wrap=("clamp_to_border", "repeat"), border=(1.0,) * 4)
    >>> linear_sample(Of(texels=modes), np.array([[-0.05, 0.5]])).round(9).tolist()
    [[3.7, 3.7, 3.7, 3.7]]
    """
    texels = image.texels
    height, width = texels.values.shape[:2]
    padded = np.pad(texels.values.astype(np.float64), ((0, 1), (0, 1), (0, 0)))
    padded[-1], padded[:, -1] = texels.border, texels.border  # what the index −1 finds
    u, v = TexCoords[:, 0], TexCoords[:, 1]
    left, low = first_texel(u, width).astype(int), first_texel(v, height).astype(int)

    def texel(i: int, j: int) -> Array:
        column = wrapped_texel(left + i, width, texels.wrap[0])
        row = wrapped_texel(low + j, height, texels.wrap[1])
        found: Array = padded[row, column]
        return found

    across, up = weight(u, width)[:, None], weight(v, height)[:, None]
    mixed: Array = bilinear(texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1), across, up)
    return mixed


def level_count(width: int, height: int) -> int:
    """The number of a texture's mipmap levels: ⌊log₂ max(width, height)⌋ + 1 (§8.14.3).

    >>> level_count(256, 256), level_count(5, 3)
    (9, 3)
    """
    return int(max(width, height)).bit_length()


def texel_count(width: int, height: int) -> int:
    """The number of texels in all levels; each level halves width and height, rounding down.

    >>> texel_count(256, 256)
    87381
    """
    return sum(max(width >> n, 1) * max(height >> n, 1) for n in range(level_count(width, height)))
