"""GLSL's built-in functions over Python numbers, float64 arrays and bands alike.

A reference formula that is written with these runs on all three. Shapes: the last axis is the
vector's components, always present in arrays, so that a per-pixel float (N, 1) and a uniform
float (1,) broadcast against a per-pixel vec3 (N, 3); matrices are (…, row, column).

Source: the OpenGL Shading Language 4.60 (Khronos), chapter 8 "Built-In Functions".
"""

from shaderlab.glslmath.choice import all as all
from shaderlab.glslmath.choice import any as any
from shaderlab.glslmath.choice import either as either
from shaderlab.glslmath.choice import equal as equal
from shaderlab.glslmath.choice import greaterThan as greaterThan
from shaderlab.glslmath.choice import greaterThanEqual as greaterThanEqual
from shaderlab.glslmath.choice import isinf as isinf
from shaderlab.glslmath.choice import isnan as isnan
from shaderlab.glslmath.choice import lessThan as lessThan
from shaderlab.glslmath.choice import lessThanEqual as lessThanEqual
from shaderlab.glslmath.choice import not_ as not_
from shaderlab.glslmath.choice import notEqual as notEqual
from shaderlab.glslmath.choice import where as where
from shaderlab.glslmath.dispatch import Condition as Condition
from shaderlab.glslmath.dispatch import Value as Value
from shaderlab.glslmath.matrix import determinant as determinant
from shaderlab.glslmath.matrix import inverse as inverse
from shaderlab.glslmath.matrix import matmul as matmul
from shaderlab.glslmath.matrix import matrixCompMult as matrixCompMult
from shaderlab.glslmath.matrix import mul as mul
from shaderlab.glslmath.matrix import outerProduct as outerProduct
from shaderlab.glslmath.matrix import transpose as transpose
from shaderlab.glslmath.scalar import abs as abs
from shaderlab.glslmath.scalar import acos as acos
from shaderlab.glslmath.scalar import asin as asin
from shaderlab.glslmath.scalar import atan as atan
from shaderlab.glslmath.scalar import ceil as ceil
from shaderlab.glslmath.scalar import clamp as clamp
from shaderlab.glslmath.scalar import cos as cos
from shaderlab.glslmath.scalar import degrees as degrees
from shaderlab.glslmath.scalar import exp as exp
from shaderlab.glslmath.scalar import exp2 as exp2
from shaderlab.glslmath.scalar import floor as floor
from shaderlab.glslmath.scalar import fma as fma
from shaderlab.glslmath.scalar import fract as fract
from shaderlab.glslmath.scalar import inversesqrt as inversesqrt
from shaderlab.glslmath.scalar import log as log
from shaderlab.glslmath.scalar import log2 as log2
from shaderlab.glslmath.scalar import max as max
from shaderlab.glslmath.scalar import min as min
from shaderlab.glslmath.scalar import mix as mix
from shaderlab.glslmath.scalar import mod as mod
from shaderlab.glslmath.scalar import pow as pow
from shaderlab.glslmath.scalar import radians as radians
from shaderlab.glslmath.scalar import round as round
from shaderlab.glslmath.scalar import roundEven as roundEven
from shaderlab.glslmath.scalar import sign as sign
from shaderlab.glslmath.scalar import sin as sin
from shaderlab.glslmath.scalar import smoothstep as smoothstep
from shaderlab.glslmath.scalar import sqrt as sqrt
from shaderlab.glslmath.scalar import step as step
from shaderlab.glslmath.scalar import tan as tan
from shaderlab.glslmath.scalar import trunc as trunc
from shaderlab.glslmath.shape import mat2 as mat2
from shaderlab.glslmath.shape import mat3 as mat3
from shaderlab.glslmath.shape import mat4 as mat4
from shaderlab.glslmath.shape import swizzle as swizzle
from shaderlab.glslmath.shape import vec2 as vec2
from shaderlab.glslmath.shape import vec3 as vec3
from shaderlab.glslmath.shape import vec4 as vec4
from shaderlab.glslmath.vector import cross as cross
from shaderlab.glslmath.vector import distance as distance
from shaderlab.glslmath.vector import dot as dot
from shaderlab.glslmath.vector import faceforward as faceforward
from shaderlab.glslmath.vector import length as length
from shaderlab.glslmath.vector import normalize as normalize
from shaderlab.glslmath.vector import reflect as reflect
from shaderlab.glslmath.vector import refract as refract
