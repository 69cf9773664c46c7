"""Acceptance intervals for 32-bit shader arithmetic: what a conforming device may answer.

A formula evaluated on bands gives, for every value, the interval of results that the precision
tables of GLSL and Vulkan allow. A measured value outside is a failure on any conforming device;
inside, no device can be blamed. GLSL's functions for bands are in `shaderlab.glslmath`.
"""

from shaderlab.bands.band import Band, Literal
from shaderlab.bands.bounds import Allowed
from shaderlab.bands.exact import TriBool
from shaderlab.bands.integer import Integer
from shaderlab.bands.rounding import Rules

__all__ = ["Allowed", "Band", "Integer", "Literal", "Rules", "TriBool"]
