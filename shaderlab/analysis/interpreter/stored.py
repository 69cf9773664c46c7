"""What a run tells of on the way: values that are stored, and those that its flow depends on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .memory import Flags
from .program import Instruction
from .types import Type

_FLOW = (57, 250, 251)  # a call, a branch, a switch


@dataclass(frozen=True, eq=False)
class Stored:
    """One value stored by one path through a program, or one that its flow depends on.

    Attributes:
        at: the instruction. Of an argument that is the call, of a condition the branch.
        name: the variable, or the part of it, as GLSL writes it; "f()" is the result of f, "f(x)"
            what f is passed as x, "condition" what a branch goes by, "selector" a switch.
        type: the value's type.
        value: floats of the arithmetic, an `Integer`, a `Truth`, or a tuple of such, with one row
            or as many as there are invocations.
        mask: the invocations that were here; the value means nothing to others.
        calls: the lines of the calls that led here, the outermost first.
        reads: what was loaded, and what functions gave, since the value that was stored before.
    """

    at: Instruction
    name: str
    type: Type
    value: Any
    mask: Flags
    calls: tuple[int, ...]
    reads: tuple[Any, ...]

    @property
    def line(self) -> int:
        """The line of the program's text, counted from 1; see `Program.place`."""
        return self.at.line

    @property
    def is_flow(self) -> bool:
        """Whether it is an argument or a condition."""
        return self.at.op in _FLOW


Trace = Callable[[Stored], object]
