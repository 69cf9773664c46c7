"""GLSL's built-in functions over Python numbers, float64 arrays and bands alike.

A reference formula that is written with these runs on all three. Shapes: the last axis is the
vector's components, always present in arrays, so that a per-pixel float (N, 1) and a uniform
float (1,) broadcast against a per-pixel vec3 (N, 3); matrices are (…, row, column).

Source: the OpenGL Shading Language 4.60 (Khronos), chapter 8 "Built-In Functions".
"""

# ruff: noqa: F403 (each module lists its functions in __all__)
from shaderlab.glslmath.bits import *
from shaderlab.glslmath.choice import *
from shaderlab.glslmath.derivatives import *
from shaderlab.glslmath.dispatch import *
from shaderlab.glslmath.integer import *
from shaderlab.glslmath.scalar import *
from shaderlab.glslmath.vector import *
