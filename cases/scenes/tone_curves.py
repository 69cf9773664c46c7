"""Tone curves of films and of perception, as lib/tone_curves.glsl has them.

Sources: K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2016; S. Hill, "ACES Fitted" (BakingLab,
2016): a fit of ACES's reference rendering transform; B. Ottosson, "A perceptual color space for
image processing", 2020 (OKLab).

Light is linear sRGB, 0 at least, (…, 3).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.glslmath import Value, max, mul, pow, sqrt, swizzle, vec3

WIDER = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
BACK = [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]
TO_CONES = [
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
]
FROM_CONES = [
    [4.0767416621, -3.3077115913, 0.2309699292],
    [-1.2684380046, 2.6097574011, -0.3413193965],
    [-0.0041960863, -0.7034186147, 1.7076147010],
]
TO_LAB = [
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
]
FROM_LAB = [
    [1.0, 0.3963377774, 0.2158037573],
    [1.0, -0.1055613458, -0.0638541728],
    [1.0, -0.0894841775, -1.2914855480],
]


def filmic(light: Value) -> Value:
    """Narkowicz's fit of ACES; may exceed 1 a little.

    >>> print(f"{filmic(1.0):.6f}")
    0.803797
    """
    return light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14)


def filmic_wide(light: Value) -> Value:
    """Hill's fit of ACES, in a wider space of colours.

    >>> filmic_wide(np.ones(3)).round(4).tolist()
    [0.6191, 0.6191, 0.6191]
    """
    wide = mul(np.array(WIDER), light)
    curve = wide * (wide + 0.0245786) - 0.000090537
    return mul(np.array(BACK), curve / (wide * (0.983729 * wide + 0.4329510) + 0.238081))


def to_oklab(light: Value) -> Value:
    """Lightness and two coordinates of colour, (…, 3).

    >>> to_oklab(np.ones(3)).round(4).tolist()
    [1.0, 0.0, 0.0]
    """
    cones = max(mul(np.array(TO_CONES), light), 1.0e-6)
    return mul(np.array(TO_LAB), pow(cones, 1.0 / 3.0))


def from_oklab(lab: Value) -> Value:
    """Light of OKLab's coordinates.

    >>> from_oklab(np.array([0.5, 0.0, 0.0])).round(4).tolist()
    [0.125, 0.125, 0.125]
    """
    root = mul(np.array(FROM_LAB), lab)
    return mul(np.array(FROM_CONES), root * root * root)


def perceptual(light: Value) -> Value:
    """The curve L / √(1 + L²) on OKLab's lightness; colour fades towards white and keeps its hue.

    >>> perceptual(np.ones(3)).round(4).tolist()
    [0.3536, 0.3536, 0.3536]
    """
    lab = to_oklab(light)
    grey = swizzle(lab, "x")
    lightness = grey / sqrt(1.0 + grey * grey)
    square = lightness * lightness
    fade = lightness / grey * (1.0 - square * square * square)
    return from_oklab(vec3(lightness, fade * swizzle(lab, "yz")))


def hue(light: Any) -> Any:
    """The angle of OKLab's colour in degrees, in float64, (…).

    >>> round(float(hue([1.0, 0.0, 0.0])), 1)
    29.2
    """
    lab = np.asarray(to_oklab(np.asarray(light, float)))
    return np.degrees(np.arctan2(lab[..., 2], lab[..., 1]))
