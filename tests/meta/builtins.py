"""The built-in functions of GLSL 4.50, as chapter 8 of its specification lists them, and why
references do without some of them.

Source: The OpenGL Shading Language 4.50 (Khronos, revision 7), chapter 8 "Built-In Functions", 8.1
to 8.18. Functions of the compatibility profile (`ftransform`, `texture2D`, …) are left out.
"""

from __future__ import annotations

CHAPTER_8: dict[str, str] = {
    "8.1 Angle and trigonometry": (
        "radians degrees sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh"
    ),
    "8.2 Exponential": "pow exp log exp2 log2 sqrt inversesqrt",
    "8.3 Common": (
        "abs sign floor trunc round roundEven ceil fract mod modf min max clamp mix step "
        "smoothstep isnan isinf floatBitsToInt floatBitsToUint intBitsToFloat uintBitsToFloat "
        "fma frexp ldexp"
    ),
    "8.4 Floating-point pack and unpack": (
        "packUnorm2x16 packSnorm2x16 packUnorm4x8 packSnorm4x8 unpackUnorm2x16 "
        "unpackSnorm2x16 unpackUnorm4x8 unpackSnorm4x8 packHalf2x16 unpackHalf2x16 "
        "packDouble2x32 unpackDouble2x32"
    ),
    "8.5 Geometric": "length distance dot cross normalize faceforward reflect refract",
    "8.6 Matrix": "matrixCompMult outerProduct transpose determinant inverse",
    "8.7 Vector relational": (
        "lessThan lessThanEqual greaterThan greaterThanEqual equal notEqual any all not"
    ),
    "8.8 Integer": (
        "uaddCarry usubBorrow umulExtended imulExtended bitfieldExtract bitfieldInsert "
        "bitfieldReverse bitCount findLSB findMSB"
    ),
    "8.9.1 Texture query": "textureSize textureQueryLod textureQueryLevels textureSamples",
    "8.9.2 Texel lookup": (
        "texture textureProj textureLod textureOffset texelFetch texelFetchOffset "
        "textureProjOffset textureLodOffset textureProjLod textureProjLodOffset textureGrad "
        "textureGradOffset textureProjGrad textureProjGradOffset"
    ),
    "8.9.3 Texture gather": "textureGather textureGatherOffset textureGatherOffsets",
    "8.10 Atomic counter": "atomicCounterIncrement atomicCounterDecrement atomicCounter",
    "8.11 Atomic memory": (
        "atomicAdd atomicMin atomicMax atomicAnd atomicOr atomicXor atomicExchange atomicCompSwap"
    ),
    "8.12 Image": (
        "imageSize imageSamples imageLoad imageStore imageAtomicAdd imageAtomicMin "
        "imageAtomicMax imageAtomicAnd imageAtomicOr imageAtomicXor imageAtomicExchange "
        "imageAtomicCompSwap"
    ),
    "8.13.1 Derivative": (
        "dFdx dFdy dFdxFine dFdyFine dFdxCoarse dFdyCoarse fwidth fwidthFine fwidthCoarse"
    ),
    "8.13.2 Interpolation": "interpolateAtCentroid interpolateAtSample interpolateAtOffset",
    "8.14 Noise": "noise1 noise2 noise3 noise4",
    "8.15 Geometry shader": "EmitStreamVertex EndStreamPrimitive EmitVertex EndPrimitive",
    "8.16 Shader invocation control": "barrier",
    "8.17 Shader memory control": (
        "memoryBarrier memoryBarrierAtomicCounter memoryBarrierBuffer memoryBarrierShared "
        "memoryBarrierImage groupMemoryBarrier"
    ),
}

_ATOMIC = "the result depends on the order of invocations"
_NOTHING = "returns nothing"

WHY_NOT: dict[str, str] = {
    "packDouble2x32": "bands are of 32-bit floats",
    "unpackDouble2x32": "bands are of 32-bit floats",
    **dict.fromkeys(CHAPTER_8["8.10 Atomic counter"].split(), _ATOMIC),
    **dict.fromkeys(CHAPTER_8["8.11 Atomic memory"].split(), _ATOMIC),
    "imageSamples": "the lab has no multisampled images",
    "imageStore": _NOTHING,
    **dict.fromkeys(
        [name for name in CHAPTER_8["8.12 Image"].split() if "Atomic" in name], _ATOMIC
    ),
    **dict.fromkeys(
        CHAPTER_8["8.13.2 Interpolation"].split(),
        "write the result to an output, and judge that",
    ),
    **dict.fromkeys(CHAPTER_8["8.14 Noise"].split(), "deprecated, and different on each driver"),
    **dict.fromkeys(CHAPTER_8["8.15 Geometry shader"].split(), _NOTHING),
    "barrier": _NOTHING,
    **dict.fromkeys(CHAPTER_8["8.17 Shader memory control"].split(), _NOTHING),
}
# What Python has another word for.
SPELT = {"not": "not_"}
