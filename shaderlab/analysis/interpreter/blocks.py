"""What a block does: its instructions with their handlers, looked up once for all of its runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shaderlab.compiler.reflection import Op
from shaderlab.errors import NotInterpretedError

from .branches import BRANCHES, Branch
from .instructions import HANDLERS, NAMES
from .instructions.handler import Handler
from .memory import World
from .program import Instruction
from .values import Value

if TYPE_CHECKING:
    from .running import Run

Steps = tuple[list[tuple[Handler, Instruction, bool]], Branch, Instruction]
"""A block's instructions, each with its handler and whether it is a call; and how it ends."""


def steps_of(block: list[Instruction]) -> Steps:
    """A block as it is run. What has no handler is refused where it is reached.

    Raises:
        NotInterpretedError: no branch ends it.
    """
    steps: list[tuple[Handler, Instruction, bool]] = []
    for at in block:
        if at.op in BRANCHES:
            return steps, BRANCHES[at.op], at
        steps.append((HANDLERS.get(at.op, _unknown), at, at.op == Op.FUNCTION_CALL))
    raise NotInterpretedError("not interpreted: a block without an end")


def _unknown(run: Run, at: Instruction, world: World) -> Value:
    name = NAMES.get(at.op, f"SPIR-V's opcode {at.op}")
    raise run.program.not_interpreted(name, at.line)
