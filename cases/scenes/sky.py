"""A sky all around: six images of a cube map, made by one formula of the direction."""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import CubeTexture

Array = npt.NDArray[Any]

SUN = np.array([0.48, 0.52, -0.70]) / np.linalg.norm([0.48, 0.52, -0.70])
# By face (OpenGL 4.5, table 8.19, the other way round): x, y, z as rows, over s, t and 1.
_TOWARDS = np.array(
    [
        [(0, 0, 1), (0, -1, 0), (-1, 0, 0)], [(0, 0, -1), (0, -1, 0), (1, 0, 0)],
        [(1, 0, 0), (0, 0, 1), (0, 1, 0)], [(1, 0, 0), (0, 0, -1), (0, -1, 0)],
        [(1, 0, 0), (0, -1, 0), (0, 0, 1)], [(-1, 0, 0), (0, -1, 0), (0, 0, -1)],
    ],
    float,
)  # fmt: skip


def sky_face(number: int, size: int = 192, seed: int = 21) -> Array:
    """Morning over hills, one face for `CubeTexture`: 0…5 for +X, −X, +Y, −Y, +Z, −Z. RGBA.

    Row 0 is t = 0, as a cube map wants it: the upper edge of the four faces around.

    >>> sky_face(2, 4).shape
    (4, 4, 4)
    """
    return _with_alpha(_colour(directions(number, size), seed))


def directions(number: int, size: int) -> Array:
    """Unit vectors to the texels of one face, in the order of `sky_face`.

    >>> directions(4, 1).tolist()
    [[[0.0, 0.0, 1.0]]]
    """
    place = (np.arange(size) + 0.5) / size * 2.0 - 1.0
    t, s = np.meshgrid(place, place, indexing="ij")
    direction = np.stack([s, t, np.ones_like(s)], -1) @ _TOWARDS[number].T
    return np.asarray(direction / np.linalg.norm(direction, axis=-1, keepdims=True))


def sky_light(number: int, size: int, sun: float = 40.0) -> Array:
    """The light of that morning, without an upper end: `sky_face` decoded, brighter, with a sun.

    Args:
        sun: how much brighter than white its middle is; it is 18° wide.

    >>> bool(sky_light(5, 4).max() > 1.0)
    True
    """
    direction = directions(number, size)
    aside = np.clip(1.0 - (direction * SUN).sum(-1), 0.0, 2.0)[..., None]
    glow = sun * np.exp(-aside / 0.006) * np.array([1.0, 0.82, 0.55])
    return _with_alpha(1.6 * _colour(direction, 21) ** 2.2 + glow)


def _with_alpha(color: Array) -> Array:
    return np.concatenate([color, np.ones((*color.shape[:2], 1))], -1).astype(np.float32)


def _colour(direction: Array, seed: int) -> Array:
    height = direction[..., 1]
    up = np.clip(height, 0.0, 1.0)[..., None]
    air = (1.0 - up**0.6) * np.array([0.93, 0.80, 0.66]) + up**0.6 * np.array([0.17, 0.36, 0.66])
    toward = np.clip((direction * SUN).sum(-1), 0.0, 1.0)[..., None]
    air = air + toward**8 * np.array([0.30, 0.19, 0.06]) + toward**900 * 1.2
    cloud = np.clip(_noise(direction * (3.0, 9.0, 3.0), seed) * 2.4 - 1.15, 0.0, 1.0)[..., None]
    air = air + cloud * np.clip(up * 4.0, 0.0, 1.0) * (0.96 - air) * 0.8
    azimuth = np.arctan2(direction[..., 0], direction[..., 2])
    color = air
    for layer, (rise, tone) in enumerate(((0.13, 0.72), (0.05, 0.42), (-0.02, 0.22))):
        ridge = rise + sum(
            0.05 / wave * np.sin(wave * azimuth + phase)
            for wave, phase in zip((2, 5, 11, 17), np.arange(4) * (1.7 + layer), strict=True)
        )
        hill = np.clip((ridge - height) * 60.0, 0.0, 1.0)[..., None]
        color = color + hill * (tone * np.array([0.62, 0.72, 0.80]) + 0.05 - color)
    meadow = np.clip(-(height + 0.10) * 12.0, 0.0, 1.0)[..., None]
    grain = 0.8 + 0.4 * _noise(direction * 14.0, seed + 1)[..., None]
    color = color + meadow * (grain * np.array([0.19, 0.27, 0.14]) - color)
    return np.asarray(np.clip(color, 0.0, 1.0))


def _noise(place: Array, seed: int) -> Array:
    """Smooth value noise in space, three octaves, in 0…1."""
    lattice = np.random.default_rng(seed).random((32, 32, 32)).astype(np.float32)
    total = np.zeros(place.shape[:-1], np.float32)
    place = place.astype(np.float32)
    for octave in range(3):
        point = place * 2.0**octave + 13.7 * octave
        low = np.floor(point).astype(int)
        part = point - low
        part = part * part * (3.0 - 2.0 * part)
        # Along each axis both neighbours: where in the lattice, and how much of them.
        near = [
            [((low[..., k] + side) % 32 * step, abs(1 - side - part[..., k])) for side in (0, 1)]
            for k, step in enumerate((32 * 32, 32, 1))
        ]
        for (i, x), (j, y) in product(*near[:2]):
            row, share = i + j, x * y
            for k, z in near[2]:
                total += share * z * lattice.take(row + k) * 0.5 ** (octave + 1)
    return np.asarray(total / 0.875)


# The same functions for all, so that what they make is made once.
_MORNING = [partial(sky_face, k) for k in range(6)]


def skies(seed: int) -> tuple[CubeTexture, CubeTexture]:
    """The sky of a morning for people, and random texels for the checks; both filtered linearly.

    >>> skies(1)[1].filter
    ('linear', 'linear')
    """
    smooth = ("linear", "linear")
    random = np.random.default_rng(seed).random((6, 8, 8, 4))
    return (
        CubeTexture(faces=_MORNING, filter=smooth),
        CubeTexture(faces=list(random), filter=smooth),
    )
