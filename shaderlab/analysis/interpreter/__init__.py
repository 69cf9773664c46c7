"""Shaders read as arithmetic: a SPIR-V module run over arrays of invocations, in any arithmetic.

    program = load(source)                                  # or read(bytes of a module)
    result = interpret(program, {"TexCoord": uv, "gl_FragCoord": places}, bindings, Bands())
    result.outputs["FragColor"]                             # a Band (count, 4)

An arithmetic is `FLOAT16`, `FLOAT32`, `FLOAT64` (NumPy arrays, each operation rounded) or
`Bands(rules)` (what the precision rules allow each instruction). What the interpreter does not know
raises `NotInterpretedError`: "not interpreted: NAME at line N".
"""

from .arithmetic import (
    FLOAT16 as FLOAT16,
    FLOAT32 as FLOAT32,
    FLOAT64 as FLOAT64,
    Arithmetic as Arithmetic,
    Bands as Bands,
    Numbers as Numbers,
)
from .interpret import Interpreted as Interpreted, interpret as interpret
from .program import (
    Program as Program,
    adopt_names as adopt_names,
    load as load,
    read as read,
    read_file as read_file,
)
from .running import Stored as Stored
