"""Sampler objects: a texture's filters, wraps and comparison, apart from its images, so that one
attachment can be sampled in several ways; and which sampler of GLSL a texture fits."""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.gl import formats
from shaderlab.glsl.spirv import Variable
from shaderlab.model import CubeTexture, Output, TextureArray, TextureSource
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
        from OpenGL import GL

        key = (sampling.filter, sampling.wrap, sampling.border, sampling.compare, sampling.lod)
        if key not in self._made:
            self._made[key] = _made(sampling)
        GL.glBindSampler(unit, self._made[key])

    def release(self) -> None:
        """Give them all back."""
        from OpenGL import GL

        if self._made:
            GL.glDeleteSamplers(len(self._made), list(self._made.values()))
        self._made.clear()


def kind_of(source: TextureSource, declared: str, samples: int) -> str:
    """The kind that a texture is when it is read by a sampler of the type `declared`.

    Args:
        source: the texture.
        declared: the sampler's type: the output of a multisampled target is "2DMS" to a
            sampler2DMS, and "2D", its samples averaged, to all others.
        samples: how many samples the target has that `source` is an output of; 0 for one.
    """
    if isinstance(source, CubeTexture):
        return "Cube"
    if isinstance(source, TextureArray):
        return "2DArray"
    return "2DMS" if samples and "2DMS" in declared and isinstance(source, Output) else "2D"


def check_sampler(
    program: str, variable: Variable, source: TextureSource, kind: str, format: str
) -> None:
    """Check that a sampler's type is that of its texture.

    Raises:
        CaseError: it is another; names the sampler's type and the texture's.
    """
    scalar = "" if format in formats.DEPTH else formats.COLOR[format].scalar
    shadow = source.compare is not None
    fitting = f"{scalar}sampler{kind}{'Shadow' * shadow}"
    if variable.type == fitting:
        return
    what = type(source).__name__
    described = f"{what}(compare={source.compare!r})" if shadow else what
    remedy = f"declare it {fitting}"
    if variable.type.endswith("Shadow") and not shadow:
        remedy = 'give the texture compare="lequal", or declare it ' + fitting
    elif shadow and variable.type == fitting.removesuffix("Shadow"):
        remedy = f"declare it {fitting}, or leave compare= out"
    raise CaseError(
        f"{program}: {variable.name!r} is a {variable.type}, but the {described} given for it, "
        f"{format}, is read by a {fitting}",
        remedy=remedy,
    )


def _made(sampling: Sampling) -> int:
    from OpenGL import GL

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
