"""What each instruction does, by opcode; a family of them a file.

A handler takes the run, the instruction and the world, and returns the result. The numbers are
those of Khronos, SPIR-V Specification 1.6, section 3.
"""

from __future__ import annotations

from collections.abc import Mapping

from .arithmetic import COMPOSITES, DERIVATIVES, EXTENDED, FLOATS, INTEGERS, LOGIC, Handler
from .textures import TEXTURES
from .variables import STAGES, VARIABLES

HANDLERS: Mapping[int, Handler] = {
    **VARIABLES,
    **COMPOSITES,
    **FLOATS,
    **INTEGERS,
    **LOGIC,
    **DERIVATIVES,
    **TEXTURES,
    **EXTENDED,
    **STAGES,
}

NAMES: Mapping[int, str] = {
    60: "an atomic operation on an image",
    63: "CopyMemory",
    115: "a double",
    98: "imageLoad",
    99: "imageStore",
    **dict.fromkeys(range(227, 243), "an atomic operation"),
    220: "EmitStreamVertex",
    221: "EndStreamPrimitive",
}
"""What GLSL calls those that have no handler."""
