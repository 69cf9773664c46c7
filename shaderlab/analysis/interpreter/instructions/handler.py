"""What a handler of an instruction is, and the most usual one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..memory import World
from ..program import Instruction

if TYPE_CHECKING:
    from ..running import Run

Handler = Callable[["Run", Instruction, World], Any]


def calling(function: str) -> Handler:
    """A handler that calls a function of the arithmetic on the operands' values."""

    def handler(run: Run, at: Instruction, world: World) -> Any:
        if run.arithmetic.rules is None:
            return run.repeated(at, function)
        return run.arithmetic.call(function, *run.values(at.operands))

    return handler


def of_values(function: Callable[..., Any]) -> Handler:
    """A handler that calls a Python function on the operands' values."""

    def handler(run: Run, at: Instruction, world: World) -> Any:
        return function(*run.values(at.operands))

    return handler
