"""GLSL in, verdicts and interfaces out: sources with includes, compile targets, SPIR-V.

`sources` finds and expands shader files, `compile` returns the compilers' verdicts and modules,
`reflection` reads what the modules declare, `harness` compiles many files at once. Importing this
package loads no shared library.
"""

from shaderlab.glsl.compile import Compiled, compile_program
from shaderlab.glsl.harness import compile_glsl
from shaderlab.glsl.interface import Block, Interface, Member, SpecConstant, Variable
from shaderlab.glsl.jobs import WORK, FileResult
from shaderlab.glsl.library import versions
from shaderlab.glsl.reflection import reflect
from shaderlab.glsl.sources import Shaders, Source
from shaderlab.glsl.spirv_tools import disassemble, validate
from shaderlab.glsl.targets import ALL_TARGETS, TARGETS
from shaderlab.glsl.text import STAGES

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
