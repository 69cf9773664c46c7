"""What the interpreter asks of an arithmetic: the one protocol behind floats, whatever they are.

Integers are `shaderlab.bands.Integer` and conditions `shaderlab.bands.Truth` in every arithmetic;
only floats differ: NumPy arrays of one width (`numbers.py`), or bands (`banded.py`). Both are
shaped (count, components), or (1, components) where all invocations have the same value, and
(count or 1, rows, columns) for matrices.
"""

from __future__ import annotations

from typing import Any, Protocol

from shaderlab.bands import Rules

Floats = Any
"""Values of an arithmetic: it takes + - * / and comparisons, and has a shape."""


class Arithmetic(Protocol):
    """A way to compute with floats."""

    @property
    def name(self) -> str:
        """Such as "float32" or "band"."""

    @property
    def rules(self) -> Rules | None:
        """The precision rules of bands; None for numbers."""

    def exact(self, values: Any) -> Floats:
        """The float32 numbers that the shader gets, as this arithmetic has them."""

    def literal(self, value: float) -> Floats:
        """A float32 constant of the module, (1, 1): the author wrote a decimal number."""

    def undefined(self) -> Floats:
        """A float that nothing was stored to, (1, 1)."""

    def call(self, function: str, *values: Any) -> Any:
        """One of GLSL's functions by its name in `shaderlab.glslmath`, or one of `negate`, `add`,
        `subtract`, `multiply`, `divide`, `remainder`; integers as they are."""

    def rounded(self, value: Any) -> Any:
        """What `glslmath` and `sampling` give (float64 arrays or bands), as this arithmetic's."""
