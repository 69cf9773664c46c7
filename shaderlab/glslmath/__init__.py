"""GLSL's built-in functions over Python numbers, float64 arrays and bands alike.

A reference formula that is written with these runs on all three. Shapes: the last axis is the
vector's components, always present in arrays, so that a per-pixel float (N, 1) and a uniform
float (1,) broadcast against a per-pixel vec3 (N, 3); matrices are (…, row, column).

Source: the OpenGL Shading Language 4.60 (Khronos), chapter 8 "Built-In Functions".
"""

from shaderlab.glslmath.arrays import array as array
from shaderlab.glslmath.choice import (
    all as all,
    any as any,
    either as either,
    equal as equal,
    greaterThan as greaterThan,
    greaterThanEqual as greaterThanEqual,
    isinf as isinf,
    isnan as isnan,
    lessThan as lessThan,
    lessThanEqual as lessThanEqual,
    not_ as not_,
    notEqual as notEqual,
    where as where,
)
from shaderlab.glslmath.derivatives import (
    dFdx as dFdx,
    dFdxCoarse as dFdxCoarse,
    dFdxFine as dFdxFine,
    dFdy as dFdy,
    dFdyCoarse as dFdyCoarse,
    dFdyFine as dFdyFine,
    fwidth as fwidth,
    fwidthCoarse as fwidthCoarse,
    fwidthFine as fwidthFine,
)
from shaderlab.glslmath.dispatch import Condition as Condition, Value as Value
from shaderlab.glslmath.integer import (
    float as float,
    int as int,
    ivec2 as ivec2,
    ivec3 as ivec3,
    ivec4 as ivec4,
    uint as uint,
    uvec2 as uvec2,
    uvec3 as uvec3,
    uvec4 as uvec4,
)
from shaderlab.glslmath.packing import (
    packHalf2x16 as packHalf2x16,
    packSnorm2x16 as packSnorm2x16,
    packSnorm4x8 as packSnorm4x8,
    packUnorm2x16 as packUnorm2x16,
    packUnorm4x8 as packUnorm4x8,
    unpackHalf2x16 as unpackHalf2x16,
    unpackSnorm2x16 as unpackSnorm2x16,
    unpackSnorm4x8 as unpackSnorm4x8,
    unpackUnorm2x16 as unpackUnorm2x16,
    unpackUnorm4x8 as unpackUnorm4x8,
)
from shaderlab.glslmath.scalar import (
    abs as abs,
    acos as acos,
    asin as asin,
    atan as atan,
    ceil as ceil,
    clamp as clamp,
    cos as cos,
    degrees as degrees,
    exp as exp,
    exp2 as exp2,
    floor as floor,
    fma as fma,
    fract as fract,
    inversesqrt as inversesqrt,
    log as log,
    log2 as log2,
    max as max,
    min as min,
    mix as mix,
    mod as mod,
    pow as pow,
    radians as radians,
    round as round,
    roundEven as roundEven,
    sign as sign,
    sin as sin,
    smoothstep as smoothstep,
    sqrt as sqrt,
    step as step,
    tan as tan,
    trunc as trunc,
)
from shaderlab.glslmath.vector import (
    cross as cross,
    distance as distance,
    dot as dot,
    faceforward as faceforward,
    length as length,
    normalize as normalize,
    reflect as reflect,
    refract as refract,
)

from .arrays import (
    floatBitsToInt as floatBitsToInt,
    floatBitsToUint as floatBitsToUint,
    frexp as frexp,
    intBitsToFloat as intBitsToFloat,
    ldexp as ldexp,
    mat2 as mat2,
    mat3 as mat3,
    mat4 as mat4,
    modf as modf,
    swizzle as swizzle,
    uintBitsToFloat as uintBitsToFloat,
    vec2 as vec2,
    vec3 as vec3,
    vec4 as vec4,
)
from .integer import (
    bitCount as bitCount,
    bitfieldExtract as bitfieldExtract,
    bitfieldInsert as bitfieldInsert,
    bitfieldReverse as bitfieldReverse,
    findLSB as findLSB,
    findMSB as findMSB,
    imulExtended as imulExtended,
    uaddCarry as uaddCarry,
    umulExtended as umulExtended,
    usubBorrow as usubBorrow,
)
from .scalar import (
    acosh as acosh,
    asinh as asinh,
    atanh as atanh,
    cosh as cosh,
    sinh as sinh,
    tanh as tanh,
)
from .vector import (
    determinant as determinant,
    inverse as inverse,
    matmul as matmul,
    matrixCompMult as matrixCompMult,
    mul as mul,
    outerProduct as outerProduct,
    transpose as transpose,
)
