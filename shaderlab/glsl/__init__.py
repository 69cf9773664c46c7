"""GLSL in, verdicts and interfaces out: sources with includes, compile targets, SPIR-V.

`sources` finds and expands shader files, `compile` asks glslang for its verdicts and modules,
`spirv` reads what the modules declare. Importing this package loads no shared library.
"""

from shaderlab.glsl.compile import TARGETS, Compiled, compile_program
from shaderlab.glsl.library import versions
from shaderlab.glsl.sources import STAGES, Shaders, Source
from shaderlab.glsl.spirv import (
    Block,
    Interface,
    Member,
    Variable,
    disassemble,
    reflect,
    validate,
)

__all__ = [
    "STAGES",
    "TARGETS",
    "Block",
    "Compiled",
    "Interface",
    "Member",
    "Shaders",
    "Source",
    "Variable",
    "compile_program",
    "disassemble",
    "reflect",
    "validate",
    "versions",
]
