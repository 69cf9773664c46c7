"""The light of discs, added up pixel by pixel: what blended points must show."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def round_down(steps: float, size: float) -> float:
    """A size rounded down, where a pixel has so many steps.

    >>> round_down(32.0, 2.0) == round_down(32.0, 2.03) == 2.0
    True
    """
    return float(np.floor(size * steps)) / steps


def round_near(steps: float, size: float) -> float:
    """The nearest size where a pixel has so many steps.

    >>> round_near(32.0, 2.02)
    2.03125
    """
    return round_down(steps, size + 0.5 / steps)


SUPPORTED: tuple[Callable[[float], float], ...] = (
    float,
    partial(round_down, 32.0),
    partial(round_near, 16.0),
    partial(round_near, 8.0),
)
"""The sizes that drivers have for a point's diameter: the same, or a multiple of a step.

OpenGL and Vulkan leave the step to the driver (GL_POINT_SIZE_GRANULARITY, pointSizeGranularity).
NVIDIA's calls it 1/8 pixel in OpenGL and 1/16 in Vulkan, and rounds down to 1/32 in both.
"""


def add_discs(
    picture: Array,
    places: Array,
    hues: Array,
    clip: Array,
    scale: float,
    supported: Callable[[float], float] = float,
    shift: float = 0.0,
) -> None:
    """Add the light of discs to a picture: 1 in the middle, 0 on the rim, falling as 1 − r².

    A disc whose middle is not in the picture is not drawn, as OpenGL clips points.

    Args:
        picture: (height, width, 3), row 0 below; it is changed.
        places: the discs' middles in the world, (n, 3).
        hues: the light in their middles, (n, 3).
        clip: projection · view.
        scale: a disc's diameter in pixels where clip w is 1.
        supported: the size that the driver has for a diameter; see `SUPPORTED`.
        shift: by how many pixels middles are moved away from every pixel, or towards it if it is
            negative: the least and the most light that a driver may show which moves middles.

    >>> picture = np.zeros((1, 3, 3))
    >>> add_discs(picture, np.zeros((1, 3)), np.ones((1, 3)), np.eye(4), 2.0)
    >>> picture[0, :, 0].tolist()
    [0.0, 1.0, 0.0]
    """
    height, width, _ = picture.shape
    clip_places = np.column_stack([places, np.ones(len(places))]) @ clip.T
    for (x, y, z, w), hue in zip(clip_places, hues, strict=True):
        if np.max(np.abs((x, y, z))) > w:
            continue
        radius = 0.5 * supported(scale / w)
        middle = np.array([(x / w + 1.0) * width, (y / w + 1.0) * height]) / 2.0
        reach = max(radius - shift, 0.0)
        low = np.maximum(np.floor(middle - reach).astype(int), 0)
        high = np.minimum(np.ceil(middle + reach).astype(int), (width, height))
        across, up = (np.arange(*ends) + 0.5 for ends in zip(low, high, strict=True))
        away = np.hypot(across - middle[0], up[:, None] - middle[1]) + shift
        light = np.maximum(1.0 - (np.maximum(away, 0.0) / radius) ** 2, 0.0)
        picture[low[1] : high[1], low[0] : high[0]] += light[..., None] * hue
