"""GLSL in, verdicts and interfaces out: sources with includes, compile targets, SPIR-V.

`sources` finds and expands shader files, `compile` returns the compilers' verdicts and modules,
`reflection` reads what the modules declare, `harness` compiles many files at once. Importing this
package loads no shared library.
"""

from .sources import Shaders as Shaders, Source as Source
