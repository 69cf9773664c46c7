"""GLSL's texture functions for reference formulas, over float64 arrays and bands.

Every filter and every wrap mode, mipmap levels, arrays, cubes, multisampled textures and shadow
samplers. A band holds every result that a conforming driver may return: a coordinate that may lie
on either side of a texel's edge selects both texels, and weights have the precision
`reading.WEIGHT`.
"""

# ruff: noqa: F403 (each module lists its functions in __all__)
from shaderlab.glslmath.sampling.functions import *
from shaderlab.glslmath.sampling.reading import *
