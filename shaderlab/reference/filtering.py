"""Texture filtering: which texels are mixed, and how.

Source: "The OpenGL Graphics System: A Specification", version 4.5 core (M. Segal, K. Akeley,
2017), section 8.14.2, equations 8.13 to 8.17 (nearest and linear filtering) and 8.14.4 (mipmaps).
The specification leaves open how precise weights are; hardware keeps them in fixed point: 8 bits
in Direct3D 11.3, section 7.18.8 ("Texture Addressing and LOD Precision"), at least 4 in Vulkan
(the limit subTexelPrecisionBits).
"""

from __future__ import annotations

from ..bands import Band
from ..glslmath import Value, clamp, floor, fract, mix


def nearest_texel(coordinate: Value, size: Value) -> Value:
    """The texel that holds a coordinate, before wrapping: ⌊u·size⌋ (equation 8.13).

    >>> float(nearest_texel(0.3, 4.0))
    1.0
    """
    return floor(coordinate * size)


def first_texel(coordinate: Value, size: Value) -> Value:
    """The lower of the two texels that linear filtering mixes: ⌊u·size − ½⌋ (equation 8.15).

    Args:
        coordinate: u, 1 across the texture.
        size: its number of texels along u.

    >>> float(first_texel(0.3, 4.0)), float(first_texel(0.1, 4.0))
    (0.0, -1.0)
    """
    return floor(coordinate * size - 0.5)


def weight(coordinate: Value, size: Value, bits: int = 8) -> Value:
    """How much of the upper texel linear filtering takes: fract(u·size − ½), 0…1.

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
    lower_left: Value, lower_right: Value, upper_left: Value, upper_right: Value,
    across: Value, up: Value,
) -> Value:  # fmt: skip
    """Four texels, mixed along u and then along v (equation 8.17).

    Args:
        lower_left, lower_right, upper_left, upper_right: texels, (…, channels).
        across, up: `weight` along u and v, (…, 1).

    Returns:
        (…, channels), within the four texels' range.

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
