"""The precision rules of a band: a table of errors, and what a compiler may do to a formula."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from shaderlab.errors import FormulaError, nearest

Spec = Literal["vulkan", "glsl"]
TrigOutside = Literal["vacuous", "scaled", "error"]


@dataclass(frozen=True, slots=True)
class Rules:
    """What a conforming device may do to a 32-bit formula.

    Args:
        spec: `"vulkan"` is the table of the Vulkan specification, "Precision and Operation of
            SPIR-V Instructions", which agrees with the OpenGL Shading Language 4.60, section
            4.7.1, wherever that one states a bound. `"glsl"` takes the latter alone, which leaves
            the precision of every trigonometric function undefined.
        rearrange: the compiler may reassociate, factor and distribute; `False` is GLSL's
            `precise`: the operations as written.
        trig_outside: sine and cosine have no stated bound outside [-π, π]: `"vacuous"` takes
            anything, which is counted, `"scaled"` allows |x|·2^-12 as the Vulkan conformance suite
            does, `"error"` raises `FormulaError`.
        flush: denormals may be flushed to zero.

    A fused a·b+c needs no rule: its one rounding lies between the bounds of the two.

    Raises:
        FormulaError: `spec` or `trig_outside` is unknown.
    """

    spec: Spec = "vulkan"
    rearrange: bool = True
    trig_outside: TrigOutside = "vacuous"
    flush: bool = True

    def __post_init__(self) -> None:
        for name, choices in (
            ("spec", ("vulkan", "glsl")),
            ("trig_outside", ("vacuous", "scaled", "error")),
        ):
            value = getattr(self, name)
            if value not in choices:
                raise FormulaError(
                    f"there are no rules with {name}={value!r}", remedy=nearest(str(value), choices)
                )
