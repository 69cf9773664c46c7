"""Textures as references read them: GLSL's texture functions for numbers and bands.

Every filter and every wrap mode, mipmap levels, arrays, cubes, multisampled textures and shadow
samplers. A band holds what a conforming driver may answer: a coordinate that may lie on either
side of a texel's edge gives both texels, and weights are as precise as `filters.WEIGHT` says.
"""

from shaderlab.sampling.cube import cube_face
from shaderlab.sampling.functions import (
    texelFetch,
    texture,
    textureLod,
    textureQueryLevels,
    textureSize,
)
from shaderlab.sampling.reading import Sampler, wrap_index

__all__ = [
    "Sampler",
    "cube_face",
    "texelFetch",
    "texture",
    "textureLod",
    "textureQueryLevels",
    "textureSize",
    "wrap_index",
]
