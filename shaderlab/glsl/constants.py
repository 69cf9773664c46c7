"""Specialisation constants out of a module: `layout (constant_id = 3) const int LIGHTS = 4;`."""

from __future__ import annotations

import struct
from collections.abc import Iterator

from shaderlab.glsl.interface import SpecConstant
from shaderlab.glsl.module import Decoration, Module, Op
from shaderlab.glsl.types import type_name

_FORMATS = {"int": "<i", "uint": "<I", "float": "<f", "double": "<d"}


def spec_constants(module: Module) -> Iterator[SpecConstant]:
    """The constants that can be given a value when the module is used, each with its default."""
    for id_, instruction in module.specials.items():
        number = module.number(id_, Decoration.SPEC_ID)
        if number is None:
            continue  # computed from others
        type_, _, *words = instruction.words
        name = type_name(module, type_)
        default: int | float | bool = instruction.op == Op.SPEC_CONSTANT_TRUE
        if instruction.op == Op.SPEC_CONSTANT:
            data = struct.pack(f"<{len(words)}I", *words)
            default = struct.unpack(_FORMATS[name], data)[0]
        yield SpecConstant(
            name=module.names.get(id_, ""), type=name, constant_id=number, default=default
        )
