"""GLSL's texture functions for reference formulas, over float64 arrays and bands.

Every filter and every wrap mode, mipmap levels, arrays, cubes, multisampled textures and shadow
samplers. A band holds every result that a conforming driver may return: a coordinate that may lie
on either side of a texel's edge selects both texels, and weights have the precision
`filters.WEIGHT`.
"""

from .functions import (
    imageLoad,
    imageSize,
    texelFetch,
    texelFetchOffset,
    texture,
    textureGather,
    textureGatherOffset,
    textureGatherOffsets,
    textureGrad,
    textureGradOffset,
    textureLod,
    textureLodOffset,
    textureOffset,
    textureProj,
    textureProjGrad,
    textureProjGradOffset,
    textureProjLod,
    textureProjLodOffset,
    textureProjOffset,
    textureQueryLevels,
    textureQueryLod,
    textureSamples,
    textureSize,
)
from .reading import Sampler, cube_face, wrap_index

__all__ = [
    "Sampler",
    "cube_face",
    "imageLoad",
    "imageSize",
    "texelFetch",
    "texelFetchOffset",
    "texture",
    "textureGather",
    "textureGatherOffset",
    "textureGatherOffsets",
    "textureGrad",
    "textureGradOffset",
    "textureLod",
    "textureLodOffset",
    "textureOffset",
    "textureProj",
    "textureProjGrad",
    "textureProjGradOffset",
    "textureProjLod",
    "textureProjLodOffset",
    "textureProjOffset",
    "textureQueryLevels",
    "textureQueryLod",
    "textureSamples",
    "textureSize",
    "wrap_index",
]
