"""GLSL in, verdicts and interfaces out: sources with includes, compile targets, SPIR-V.

`sources` finds and expands shader files, `compile` asks glslang for its verdicts and modules,
`spirv` reads what the modules declare, `harness` does it for many files at once. Importing this
package loads no shared library.
"""

from shaderlab.glsl.compile import ALL_TARGETS, TARGETS, Compiled, compile_program
from shaderlab.glsl.harness import compile_glsl
from shaderlab.glsl.jobs import WORK, FileResult
from shaderlab.glsl.library import versions
from shaderlab.glsl.sources import STAGES, Shaders, Source
from shaderlab.glsl.spirv import (
    Block,
    Interface,
    Member,
    SpecConstant,
    Variable,
    disassemble,
    reflect,
    validate,
)

__all__ = [
    "ALL_TARGETS",
    "STAGES",
    "TARGETS",
    "WORK",
    "Block",
    "Compiled",
    "FileResult",
    "Interface",
    "Member",
    "Shaders",
    "Source",
    "SpecConstant",
    "Variable",
    "compile_glsl",
    "compile_program",
    "disassemble",
    "reflect",
    "validate",
    "versions",
]
