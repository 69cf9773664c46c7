"""Sampler objects: a texture's filters, wraps and comparison, apart from its images, so that one
attachment can be sampled in several ways."""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.model.textures import Sampling

# OpenGL 4.5 core profile, table 8.15.
_FILTER = {
    "nearest": 0x2600,
    "linear": 0x2601,
    "nearest_mipmap_nearest": 0x2700,
    "linear_mipmap_nearest": 0x2701,
    "nearest_mipmap_linear": 0x2702,
    "linear_mipmap_linear": 0x2703,
}
_WRAP = {
    "repeat": 0x2901,
    "mirrored_repeat": 0x8370,
    "clamp_to_edge": 0x812F,
    "clamp_to_border": 0x812D,
}
_COMPARISON = {
    word: 0x0200 + index
    for index, word in enumerate(
        ("never", "less", "equal", "lequal", "greater", "notequal", "gequal", "always")
    )
}


class Samplers:
    """Sampler objects on the device, each made once."""

    def __init__(self) -> None:
        self._made: dict[tuple[Any, ...], int] = {}

    def bind(self, unit: int, sampling: Sampling) -> None:
        """Sample whatever texture is bound to `unit` in this way."""
        key = (sampling.filter, sampling.wrap, sampling.border, sampling.compare, sampling.lod)
        if key not in self._made:
            self._made[key] = _made(sampling)
        GL.glBindSampler(unit, self._made[key])

    def release(self) -> None:
        """Give them all back."""
        if self._made:
            GL.glDeleteSamplers(len(self._made), list(self._made.values()))
        self._made.clear()


def _made(sampling: Sampling) -> int:
    sampler = np.zeros(1, np.uint32)
    GL.glGenSamplers(1, sampler)
    name = int(sampler[0])
    compare = GL.GL_NONE if sampling.compare is None else GL.GL_COMPARE_REF_TO_TEXTURE
    for what, number in (
        (GL.GL_TEXTURE_MIN_FILTER, _FILTER[sampling.filter[0]]),
        (GL.GL_TEXTURE_MAG_FILTER, _FILTER[sampling.filter[1]]),
        (GL.GL_TEXTURE_WRAP_S, _WRAP[sampling.wrap[0]]),
        (GL.GL_TEXTURE_WRAP_T, _WRAP[sampling.wrap[1]]),
        (GL.GL_TEXTURE_COMPARE_MODE, compare),
        (GL.GL_TEXTURE_COMPARE_FUNC, _COMPARISON[sampling.compare or "lequal"]),
    ):
        GL.glSamplerParameteri(name, what, number)
    for what, level in zip(
        (GL.GL_TEXTURE_MIN_LOD, GL.GL_TEXTURE_MAX_LOD), sampling.lod, strict=True
    ):
        GL.glSamplerParameterf(name, what, level)
    border = np.array(sampling.border, np.float32)
    GL.glSamplerParameterfv(name, GL.GL_TEXTURE_BORDER_COLOR, border)
    return name
