"""GLSL in, verdicts and interfaces out: sources with includes, compile targets, SPIR-V.

`sources` finds and expands shader files, `compile` returns the compilers' verdicts and modules,
`reflection` reads what the modules declare, `harness` compiles many files at once. Importing this
package loads no shared library.
"""

from .compile import Compiled as Compiled, compile_program as compile_program
from .glslang import ALL_TARGETS as ALL_TARGETS, disassemble as disassemble, validate as validate
from .reflection import Block as Block, Interface as Interface
from .sources import Shaders as Shaders, Source as Source
