"""Derivatives over a quad of pixels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from shaderlab.errors import FormulaError

from ..memory import World
from ..program import Instruction
from .handler import Handler

if TYPE_CHECKING:
    from ..running import Run


def derivative(run: Run, function: str, value: Any) -> Any:
    """A derivative of a value by its name in GLSL.

    Raises:
        FormulaError: nobody knows where the pixels are.
    """
    if value.shape[0] == 1:
        return run.arithmetic.call("subtract", value, value)
    if run.places is None:
        raise FormulaError(f"{function} without gl_FragCoord of each pixel")
    return run.arithmetic.call(function, value, run.places)


def _derivative(function: str) -> Handler:
    def handler(run: Run, at: Instruction, world: World) -> Any:
        return derivative(run, function, run.value(at.operands[0]))

    return handler


DERIVATIVES: Mapping[int, Handler] = {
    207: _derivative("dFdx"),
    208: _derivative("dFdy"),
    209: _derivative("fwidth"),
    210: _derivative("dFdxFine"),
    211: _derivative("dFdyFine"),
    212: _derivative("fwidthFine"),
    213: _derivative("dFdxCoarse"),
    214: _derivative("dFdyCoarse"),
    215: _derivative("fwidthCoarse"),
}
