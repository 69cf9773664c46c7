"""GLSL functions in tests: `from shaderlab import glsl`, `glsl.load("shaders/lighting.glsl")`."""

from shaderlab.functions.function import Function as Function
from shaderlab.functions.library import Library as Library, load as load
