"""A program's interface out of its SPIR-V modules, and SPIRV-Tools' view of a module."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace

from shaderlab.errors import ShaderError
from shaderlab.glsl.blocks import blocks as block_declarations
from shaderlab.glsl.constants import spec_constants
from shaderlab.glsl.interface import Block, Interface, Member, SpecConstant, Variable
from shaderlab.glsl.module import Module, Storage, parse
from shaderlab.glsl.tools import disassemble, validate
from shaderlab.glsl.variables import stage_variables, uniform_variables

__all__ = [
    "Block",
    "Interface",
    "Member",
    "SpecConstant",
    "Variable",
    "disassemble",
    "instruction_count",
    "reflect",
    "validate",
]

_LOCAL_SIZE = 17  # execution mode


def instruction_count(module: bytes) -> int:
    """How many instructions a module has.

    Raises:
        ShaderError: the bytes are not a SPIR-V module.
    """
    if len(module) < 20 or len(module) % 4:
        raise ShaderError(f"not a SPIR-V module: {len(module)} bytes")
    # An instruction's first word has its length in the upper half; a list is read fastest.
    upper = 1 if sys.byteorder == "little" else 0
    lengths = memoryview(module).cast("H")[upper::2].tolist()
    at, end = 5, len(lengths)
    for count in range(end):
        if at >= end:
            return count
        at += lengths[at]
    # An instruction without a length: the loop stood still at it.
    raise ShaderError(f"not a SPIR-V module: broken instruction at word {at}")


def reflect(modules: Mapping[str, bytes]) -> Interface:
    """The interface of a program, from one module a stage (made for OpenGL).

    Raises:
        ShaderError: bytes that are not a SPIR-V module.
    """
    parsed = {stage: parse(data) for stage, data in modules.items()}
    none = Module(())
    vertex, fragment = parsed.get("vertex", none), parsed.get("fragment", none)
    last = next((parsed[s] for s in ("geometry", "tess_evaluation", "vertex") if s in parsed), none)
    uniforms: dict[str, Variable] = {}
    blocks: dict[str, Block] = {}
    for module in parsed.values():
        for uniform in uniform_variables(module):
            before = uniforms.setdefault(uniform.name, uniform)
            uniforms[uniform.name] = replace(before, used=before.used or uniform.used)
        for block in block_declarations(module):
            known = blocks.setdefault(block.name, block)
            blocks[block.name] = replace(known, used=known.used or block.used)
    size = parsed["compute"].modes.get(_LOCAL_SIZE) if "compute" in parsed else None
    return Interface(
        attributes={v.name: v for v in stage_variables(vertex, Storage.INPUT)},
        varyings={v.name: v for v in stage_variables(fragment, Storage.INPUT)},
        vertex_outputs={v.name: v for v in stage_variables(last, Storage.OUTPUT)},
        outputs={v.name: v for v in stage_variables(fragment, Storage.OUTPUT)},
        uniforms=uniforms,
        blocks=blocks,
        constants={c.name: c for module in parsed.values() for c in spec_constants(module)},
        local_size=(size[0], size[1], size[2]) if size else None,
    )
