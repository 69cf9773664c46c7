"""One call of the API that is made otherwise: dropped, changed, put off or made again."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class CallEdit:
    """What becomes of one call that drawing a scene takes.

    Attributes:
        function: the call's C name, such as "glBufferData".
        number: which call of this function, counted from 0 in the order of the drawing.
    """

    function: str
    number: int


@dataclass(frozen=True, kw_only=True)
class Dropped(CallEdit):
    """The call is not made; one that returns something returns 0."""


@dataclass(frozen=True, kw_only=True)
class Changed(CallEdit):
    """The call is made with another value for one parameter, by its name in OpenGL's headers: a
    number, or a constant's name."""

    parameter: str
    value: int | str


@dataclass(frozen=True, kw_only=True)
class PutOff(CallEdit):
    """The call is made after another one: a function's name, and which call of it."""

    behind: tuple[str, int]


@dataclass(frozen=True, kw_only=True)
class Repeated(CallEdit):
    """The call is made again before each later draw of its pass, with the bindings that it had."""
