"""GLSL's names for SPIR-V types."""

from __future__ import annotations

import math
from collections.abc import Iterable

from shaderlab.compiler.module import Module, Op

OPAQUE = (Op.TYPE_IMAGE, Op.TYPE_SAMPLER, Op.TYPE_SAMPLED_IMAGE)
# The image formats of SPIR-V 1.6, 3.11, by their numbers from 0 on, as GLSL spells them.
_FORMATS = (
    "", "rgba32f", "rgba16f", "r32f", "rgba8", "rgba8_snorm", "rg32f", "rg16f", "r11f_g11f_b10f",
    "r16f", "rgba16", "rgb10_a2", "rg16", "rg8", "r16", "r8", "rgba16_snorm", "rg16_snorm",
    "rg8_snorm", "r16_snorm", "r8_snorm", "rgba32i", "rgba16i", "rgba8i", "r32i", "rg32i", "rg16i",
    "rg8i", "r16i", "r8i", "rgba32ui", "rgba16ui", "rgba8ui", "r32ui", "rgb10_a2ui", "rg32ui",
    "rg16ui", "rg8ui", "r16ui", "r8ui", "r64ui", "r64i",
)  # fmt: skip
_DIMENSIONS = {0: "1D", 1: "2D", 2: "3D", 3: "Cube", 4: "2DRect", 5: "Buffer"}


def type_name(module: Module, id_: int) -> str:
    """The GLSL name of a type: "vec3", "mat4x3", "sampler2DShadow", a struct's own name.

    Arrays give their element's name; see `unwrap`.
    """
    _, element = unwrap(module, id_)
    instruction = module.types[element]
    op, words = instruction.op, instruction.words
    if op == Op.TYPE_STRUCT:
        return module.names.get(element, "")
    if op == Op.TYPE_VECTOR:
        return f"{_prefix(module, words[0])}vec{words[1]}"
    if op == Op.TYPE_MATRIX:
        column = module.types[words[0]].words
        letter = _prefix(module, column[0])
        shape = f"{words[1]}" if words[1] == column[1] else f"{words[1]}x{column[1]}"
        return f"{letter}mat{shape}"
    if op == Op.TYPE_SAMPLED_IMAGE:
        return _image(module, words[0], "sampler")
    if op == Op.TYPE_IMAGE:
        return _image(module, element, "image")
    if op == Op.TYPE_SAMPLER:
        return "sampler"
    return _scalar(module, element)


def unwrap(module: Module, id_: int) -> tuple[tuple[int, ...], int]:
    """An array type's lengths, outermost first (0 if known at run time only), and its element."""
    lengths = []
    while module.types[id_].op in (Op.TYPE_ARRAY, Op.TYPE_RUNTIME_ARRAY):
        instruction = module.types[id_]
        known = instruction.op == Op.TYPE_ARRAY
        lengths.append(module.constants.get(instruction.words[1], 0) if known else 0)
        id_ = instruction.words[0]
    return tuple(lengths), id_


def component_count(module: Module, id_: int) -> int:
    """The numbers in one element of the type; 0 for structs and opaque types."""
    _, element = unwrap(module, id_)
    op, words = module.types[element].op, module.types[element].words
    if op in (Op.TYPE_BOOL, Op.TYPE_INT, Op.TYPE_FLOAT):
        return 1
    if op == Op.TYPE_VECTOR:
        return words[1]
    if op == Op.TYPE_MATRIX:
        return words[1] * component_count(module, words[0])
    return 0


def slots(module: Module, id_: int) -> int:
    """The locations that a varying of the type takes between shader stages."""
    lengths, element = unwrap(module, id_)
    op, words = module.types[element].op, module.types[element].words
    if op == Op.TYPE_STRUCT:
        one = sum(slots(module, member) for member in words)
    elif op == Op.TYPE_MATRIX:
        one = words[1] * slots(module, words[0])
    elif op == Op.TYPE_VECTOR:
        one = 2 if _scalar(module, words[0]) == "double" and words[1] > 2 else 1
    else:
        one = 1
    return one * elements_of(lengths)


def leaves_count(module: Module, id_: int) -> int:
    """The locations that a uniform of the type takes: one for each number, vector or matrix."""
    lengths, element = unwrap(module, id_)
    count = 1
    if module.types[element].op == Op.TYPE_STRUCT:
        count = sum(leaves_count(module, member) for member in module.types[element].words)
    return count * elements_of(lengths)


def elements_of(lengths: Iterable[int]) -> int:
    """The elements of an array of arrays; a length known at run time only counts as one."""
    return math.prod(max(length, 1) for length in lengths)


def image_format(module: Module, id_: int) -> str:
    """The format that an image's layout names, "" for none and for what is no image."""
    instruction = module.types[unwrap(module, id_)[1]]
    return _FORMATS[instruction.words[6]] if instruction.op == Op.TYPE_IMAGE else ""


def _scalar(module: Module, id_: int) -> str:
    op, words = module.types[id_].op, module.types[id_].words
    if op == Op.TYPE_BOOL:
        return "bool"
    if op == Op.TYPE_INT:
        return {(32, 1): "int", (32, 0): "uint"}.get((words[0], words[1]), f"int{words[0]}")
    if op == Op.TYPE_FLOAT:
        return {32: "float", 64: "double"}.get(words[0], f"float{words[0]}")
    return "void"


def _prefix(module: Module, id_: int) -> str:
    return {"float": "", "int": "i", "uint": "u", "bool": "b", "double": "d"}.get(
        _scalar(module, id_), ""
    )


def _image(module: Module, id_: int, kind: str) -> str:
    """OpTypeImage's operands: sampled type, dimension, depth, arrayed, multisampled, …"""
    sampled, dimension, depth, arrayed, multisampled, *_ = module.types[id_].words
    if dimension == 6:
        return "subpassInput"
    return (
        _prefix(module, sampled)
        + kind
        + _DIMENSIONS.get(dimension, "")
        + ("MS" if multisampled else "")
        + ("Array" if arrayed else "")
        + ("Shadow" if depth == 1 and kind == "sampler" else "")
    )
