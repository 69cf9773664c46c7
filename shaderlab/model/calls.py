"""Calls of the OpenGL API as data, for what the API itself answers, or which error it raises.

A call is made in a separate context, in OpenGL's initial state, after the passes are drawn. Words
are resolved when it is made: "GL_TEXTURE_2D" to its number, an `Object` to the name of an object
that the lab makes and deletes, a `Location` to where a program has a uniform.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from shaderlab.errors import CaseError

from .checked import Checked
from .state import check_choice

OBJECTS = (
    "buffer", "fragment_shader", "framebuffer", "program", "program_pipeline", "query",
    "renderbuffer", "sampler", "texture", "transform_feedback", "vertex_array", "vertex_shader",
)  # fmt: skip

GL_ERRORS = {
    "no_error": 0x0000, "invalid_enum": 0x0500, "invalid_value": 0x0501,
    "invalid_operation": 0x0502, "out_of_memory": 0x0505, "invalid_framebuffer_operation": 0x0506,
}  # fmt: skip

COUNTERS = (
    "samples_passed", "primitives_generated", "vertices_submitted", "primitives_submitted",
    "vertex_shader_invocations", "geometry_shader_invocations", "geometry_primitives_emitted",
    "clipping_input_primitives", "clipping_output_primitives", "fragment_shader_invocations",
)  # fmt: skip


@dataclass(frozen=True)
class Object(Checked):
    """An object of the API, made when a call first names it: `Object("texture")`.

    `label` tells two of a kind apart: `Object("texture", "left")`. The first call that binds it
    gives it its target, as in OpenGL.
    """

    kind: str
    label: str = ""

    def __post_init__(self) -> None:
        check_choice("Object", "kind", self.kind, OBJECTS)

    def __str__(self) -> str:
        return f"{self.kind} {self.label}".rstrip()


@dataclass(frozen=True)
class Program(Checked):
    """The linked program of one of the case's draws; the last draw of the last pass by default."""

    pass_name: str | None = None
    draw: int = -1

    def __str__(self) -> str:
        return "program" if self.pass_name is None else f"program of {self.pass_name}"


@dataclass(frozen=True)
class Location(Checked):
    """The location of a program's uniform, −1 if it is not in use. The program is made the
    current one (glUseProgram) before the first call that names it."""

    uniform: str
    program: Program = Program()

    def __str__(self) -> str:
        return f"location of {self.uniform}"


Argument = (
    int | float | str | bytes | None | Object | Program | Location
    | Sequence[float] | Sequence[str] | Sequence[Object]
)  # fmt: skip


@dataclass(frozen=True)
class Call(Checked):
    """A function of the API with its arguments, in C's order.

    A word that begins with "GL_" is a constant ("GL_MAP_READ_BIT | GL_MAP_WRITE_BIT" several of
    them), any other word a C string, a sequence an array of the parameter's own type, None a null
    pointer. The array that a function fills, its last parameter, is left out: of a glGet… function
    in its own type, of glReadPixels, glGetTexImage and glGetBufferSubData in bytes.
    """

    function: str
    arguments: tuple[Argument, ...] = ()

    def __post_init__(self) -> None:
        if not self.function.startswith("gl"):
            raise CaseError(
                f"call: {self.function!r} is not a function of OpenGL",
                remedy="the C name, as glTexParameteri",
            )
        arguments = (tuple(a) if isinstance(a, list) else a for a in self.arguments)
        object.__setattr__(self, "arguments", tuple(arguments))

    def __str__(self) -> str:
        return f"{self.function}({', '.join(_format_argument(a) for a in self.arguments)})"


def call(function: str, *arguments: Argument) -> Call:
    """One step of what comes `before` a `gl_call`; it must raise no error itself."""
    return Call(function, arguments)


def programs_of(calls: Sequence[Call]) -> list[Program]:
    """The case's programs that some calls name."""
    arguments = [a for c in calls for a in c.arguments]
    named = [a.program if isinstance(a, Location) else a for a in arguments]
    return list(dict.fromkeys(a for a in named if isinstance(a, Program)))


def _format_argument(argument: Argument) -> str:
    if argument is None:
        return "NULL"
    if isinstance(argument, str):
        return argument if argument.startswith("GL_") else f'"{argument}"'
    if isinstance(argument, bytes):
        return f"{len(argument)} bytes"
    if isinstance(argument, tuple):
        return str(list(argument))
    return str(argument)


def error_name(code: int) -> str:
    """A GL error's name with its number.

    >>> error_name(0x0502)
    'GL_INVALID_OPERATION (0x0502)'
    """
    for name, number in GL_ERRORS.items():
        if number == code:
            return f"GL_{name.upper()} (0x{code:04X})"
    return f"GL error 0x{code:04X}"


@dataclass(frozen=True, kw_only=True)
class CallEdit:
    """A change to one of the calls that drawing a scene makes.

    Attributes:
        function: the call's C name, such as "glBufferData".
        number: which call of this function, counted from 0 in the order of the drawing.
    """

    function: str
    number: int


@dataclass(frozen=True, kw_only=True)
class DropCall(CallEdit):
    """The call is not made; one that returns something returns 0."""


@dataclass(frozen=True, kw_only=True)
class ChangeCall(CallEdit):
    """The call is made with another value for one parameter, by its name in OpenGL's headers: a
    number, or a constant's name."""

    parameter: str
    value: int | str


@dataclass(frozen=True, kw_only=True)
class PostponeCall(CallEdit):
    """The call is made after another one: a function's name, and which call of it."""

    behind: tuple[str, int]


@dataclass(frozen=True, kw_only=True)
class RepeatCall(CallEdit):
    """The call is made again before each later draw of its pass, with the bindings that it had."""
