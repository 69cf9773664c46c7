"""GLSL in, verdicts and interfaces out: sources with includes, compile targets, SPIR-V.

`sources` finds and expands shader files, `compile` returns the compilers' verdicts and modules,
`reflection` reads what the modules declare, `harness` compiles many files at once. Importing this
package loads no shared library.
"""

from shaderlab.glsl.compile import Compiled as Compiled, compile_program as compile_program
from shaderlab.glsl.harness import (
    WORK as WORK,
    FileResult as FileResult,
    compile_glsl as compile_glsl,
)
from shaderlab.glsl.interface import (
    Block as Block,
    Interface as Interface,
    Member as Member,
    SpecConstant as SpecConstant,
    Variable as Variable,
)
from shaderlab.glsl.reflection import reflect as reflect
from shaderlab.glsl.sources import Shaders as Shaders, Source as Source
from shaderlab.glsl.spirv_tools import disassemble as disassemble, validate as validate
from shaderlab.glsl.targets import ALL_TARGETS as ALL_TARGETS, TARGETS as TARGETS
from shaderlab.glsl.text import STAGES as STAGES
