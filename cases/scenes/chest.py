"""A wooden chest with iron bands: what colour it has, and where it shines.

Each map is a float32 array (height, width, 4) in 0…1, linear light, row 0 at the bottom.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt

from .painted_textures import crate

Array = npt.NDArray[Any]

_BAND = 0.14


def chest_diffuse(size: int = 256) -> Array:
    """The colour of wood, and of the dark iron around it. RGBA.

    >>> chest_diffuse(64).shape
    (64, 64, 4)
    """
    wood = _wood(size) ** 1.6
    iron, rivet, edge = _iron(size)
    grey = 0.055 + 0.03 * rivet - 0.03 * edge
    color = np.where(iron[..., None], grey[..., None] * np.array([0.95, 1.0, 1.1]), wood)
    return _rgba(color)


def chest_specular(size: int = 256) -> Array:
    """How much of the light is mirrored: most on iron and rivets, nearly nothing on wood. RGBA.

    >>> shine = chest_specular(64)[..., 0]
    >>> bool(shine[20, 32] < 0.1 < shine[32, 32])
    True
    """
    wood = _wood(size)
    iron, rivet, edge = _iron(size)
    t, s = _coordinates(size)
    scratches = 0.5 + 0.5 * np.sin(260.0 * s + 3.0 * np.sin(41.0 * t))
    scratches *= 0.5 + 0.5 * np.sin(230.0 * t + 4.0 * np.sin(37.0 * s))
    shine = 0.62 + 0.22 * scratches + 0.25 * rivet - 0.45 * edge
    dull = 0.05 * wood.mean(axis=-1)
    return _rgba(np.where(iron, shine, dull)[..., None] * np.ones(3))


@functools.lru_cache(maxsize=1)
def _wood(size: int) -> Array:
    return np.asarray(crate(size)[..., :3], float)


@functools.lru_cache(maxsize=1)
def _iron(size: int) -> tuple[Array, Array, Array]:
    """Where there is iron (bool), rivets (0…1) and the shadow along its edges (0…1)."""
    t, s = _coordinates(size)
    rim = np.minimum(np.minimum(s, 1.0 - s), np.minimum(t, 1.0 - t))
    across = np.abs(t - 0.5)
    iron = (rim < _BAND) | (across < 0.07)
    inside = np.where(rim < _BAND, np.minimum(_BAND - rim, rim), 0.07 - across)
    edge = np.clip(1.0 - inside / 0.012, 0.0, 1.0) * iron
    u, v = np.abs(s * 6.0 % 1.0 - 0.5) / 6.0, np.abs(t * 6.0 % 1.0 - 0.5) / 6.0
    middle = 0.5 * _BAND
    on_rim = np.minimum(
        np.hypot(u, np.minimum(np.abs(t - middle), np.abs(t - 1.0 + middle))),
        np.hypot(v, np.minimum(np.abs(s - middle), np.abs(s - 1.0 + middle))),
    )
    away = np.minimum(on_rim, np.hypot(u, across))
    return iron, np.clip(1.5 - away / 0.014, 0.0, 1.0) * iron, edge


def _coordinates(size: int) -> tuple[Array, Array]:
    t, s = np.mgrid[0:size, 0:size]
    return (t + 0.5) / size, (s + 0.5) / size


def _rgba(image: Array) -> Array:
    opaque = np.ones((*image.shape[:2], 1))
    return np.concatenate([np.clip(image, 0.0, 1.0), opaque], -1).astype(np.float32)
