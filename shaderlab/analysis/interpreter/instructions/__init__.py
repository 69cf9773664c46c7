"""What each instruction does, by opcode; a family of them a file.

A handler takes the run, the instruction and the world, and returns the result. The numbers are
those of Khronos, SPIR-V Specification 1.6, section 3.
"""

from __future__ import annotations

from collections.abc import Mapping

from shaderlab.compiler.spirv import Op

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
    Op.ImageTexelPointer: "an atomic operation on an image",
    Op.CopyMemory: "CopyMemory",
    Op.FConvert: "a double",
    Op.ImageRead: "imageLoad",
    Op.ImageWrite: "imageStore",
    **dict.fromkeys(range(Op.AtomicLoad, Op.AtomicXor + 1), "an atomic operation"),
    Op.EmitStreamVertex: "EmitStreamVertex",
    Op.EndStreamPrimitive: "EndStreamPrimitive",
}
"""What GLSL calls those that have no handler."""
