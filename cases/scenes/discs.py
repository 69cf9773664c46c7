"""The light of discs, added up pixel by pixel: what blended points must show."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def add_discs(picture: Array, places: Array, hues: Array, clip: Array, scale: float) -> None:
    """Add the light of discs to a picture: 1 in the middle, 0 on the rim, falling as 1 − r².

    A disc whose middle is not in the picture is not drawn, as OpenGL clips points.

    Args:
        picture: (height, width, 3), row 0 below; it is changed.
        places: the discs' middles in the world, (n, 3).
        hues: the light in their middles, (n, 3).
        clip: projection · view.
        scale: a disc's diameter in pixels where clip w is 1.

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
        radius = 0.5 * scale / w
        middle = np.array([(x / w + 1.0) * width, (y / w + 1.0) * height]) / 2.0
        low = np.maximum(np.floor(middle - radius).astype(int), 0)
        high = np.minimum(np.ceil(middle + radius).astype(int), (width, height))
        across, up = (np.arange(*ends) + 0.5 for ends in zip(low, high, strict=True))
        off = ((across - middle[0]) ** 2 + (up[:, None] - middle[1]) ** 2) / radius**2
        picture[low[1] : high[1], low[0] : high[0]] += np.maximum(1.0 - off, 0.0)[..., None] * hue
