"""A module's constants as values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shaderlab.bands import Integer, Truth
from shaderlab.compiler.reflection import Op

from .instructions import HANDLERS
from .memory import Pointer, World
from .program import Instruction
from .values import Value, composed, null, undefined

if TYPE_CHECKING:
    from .running import Run

_TRUE, _FALSE = (41, 48), (42, 49)
_SCALAR, _COMPOSITE, _NULL, _OPERATION = (43, 50), (44, 51), 46, 52


def value(run: Run, id_: int) -> Value:
    """What a constant, or a global variable's name, stands for."""
    program = run.program
    if id_ in program.variables:
        return Pointer(id_)
    declared = program.module.values[id_]
    op, words = declared.op, declared.words
    type_ = program.types[words[0]]
    if op in _TRUE or op in _FALSE:
        return Truth.known(np.full((1, 1), op in _TRUE))
    if op in _SCALAR:
        word = np.array([[words[2]]], np.uint32)
        if type_.kind == "float":
            return run.arithmetic.literal(float(word.view(np.float32)[0, 0]))
        number = word.view(np.int32) if type_.signed else word
        return Integer(number, unsigned=not type_.signed, rules=run.arithmetic.rules)
    if op in _COMPOSITE:
        return composed(type_, run.values(words[2:]))
    if op == _NULL:
        return null(type_, run.arithmetic)
    if op == Op.UNDEFINED:
        return undefined(type_, run.arithmetic)
    handler = HANDLERS.get(words[2]) if op == _OPERATION else None
    if handler is None:
        raise program.not_interpreted(f"a constant of SPIR-V's opcode {op}", 0)
    everywhere = World(np.ones(run.count, np.bool_), {})
    return handler(run, Instruction(words[2], words[0], id_, words[3:], 0), everywhere)
