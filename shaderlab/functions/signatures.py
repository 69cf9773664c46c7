"""What calling a function takes: its parameters, the globals that it reads, its text alone."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from shaderlab.compiler.syntax import Declarator, GlslDeclaration, TypeSpecifier
from shaderlab.functions.declarations import Declarations, Type

PREFIX = "shaderlab_"
Direction = Literal["in", "out", "inout"]

# Qualifiers of what a caller has to give.
_GIVEN = frozenset({"uniform", "in", "attribute", "varying", "shared"})
# What other stages read and write, as variables that a caller may give.
_STAGE_INPUTS = {
    "gl_VertexID": "int", "gl_InstanceID": "int", "gl_VertexIndex": "int",
    "gl_InstanceIndex": "int", "gl_BaseVertex": "int", "gl_BaseInstance": "int",
    "gl_DrawID": "int", "gl_GlobalInvocationID": "uvec3", "gl_LocalInvocationID": "uvec3",
    "gl_WorkGroupID": "uvec3", "gl_WorkGroupSize": "uvec3", "gl_NumWorkGroups": "uvec3",
    "gl_LocalInvocationIndex": "uint",
}  # fmt: skip
_STAGE_OUTPUTS = {"gl_Position": "vec4", "gl_PointSize": "float", "gl_FragColor": "vec4"}
# What Shadertoy declares for every shader (shadertoy.com/howto).
_SHADERTOY = {
    "iResolution": Type("vec3"), "iTime": Type("float"), "iTimeDelta": Type("float"),
    "iFrameRate": Type("float"), "iFrame": Type("int"), "iChannelTime": Type("float", (4,)),
    "iChannelResolution": Type("vec3", (4,)), "iMouse": Type("vec4"), "iDate": Type("vec4"),
    "iSampleRate": Type("float"),
    **{f"iChannel{n}": Type("sampler2D") for n in range(4)},
}  # fmt: skip
_OTHER_STAGES = frozenset({
    "EmitVertex", "EndPrimitive", "EmitStreamVertex", "barrier", "subpassLoad",
    "gl_in", "gl_out", "gl_InvocationID", "gl_TessCoord",
})  # fmt: skip
FRAGMENT_ONLY = re.compile(
    r"\b(discard|[dD]Fd[xy]\w*|fwidth\w*|texture(?:Proj|Offset|ProjOffset|QueryLod)?|texture2D\w*"
    r"|interpolateAt\w+|gl_(?:FragCoord|FrontFacing|PointCoord|FragDepth))\b"
)
"""What depends on the pixel that a function runs for, or on its neighbours."""
_GL = re.compile(rf"\bgl_({'|'.join(n[3:] for n in (*_STAGE_INPUTS, *_STAGE_OUTPUTS))})\b")
# The samplers that the lab has textures for.
_TEXTURED = re.compile(r"[iu]?sampler(?:2D|2DArray|Cube)|sampler(?:2D|2DArray|Cube)Shadow")
# Texture functions of GLSL 1.20 and ES 1.00, under the names that replaced them.
_OLD = re.compile(r"\btexture(?:1D|2D|3D|Cube)(Proj)?(Lod)?(?:EXT|ARB)?(?=\s*\()")


@dataclass(frozen=True)
class Input:
    """A parameter, or a global that the function's file leaves to others to set.

    Attributes:
        name, type: as declared.
        direction: of a parameter; globals are "in".
        optional: whether the file has a value for it.
    """

    name: str
    type: Type
    direction: Direction = "in"
    optional: bool = False


@dataclass(frozen=True)
class Signature:
    """One function of a file, an overload of its name.

    Attributes:
        name: in GLSL.
        result: what it returns; "void" for nothing.
        parameters: in order.
        globals: what else it reads.
        code: the text that it needs, line for line as in the file.
        line: of the definition in that text, counted from 1.
        definition: the function's own text.
        per_pixel: whether it depends on the pixel that it runs for.
        state: variables of the file that a call may change, with their initialisers.
        discards: whether it may discard its pixel.
        extensions: the file's `#extension` lines.
        obstacle: why it can't be called; "" if it can.
    """

    name: str
    result: Type
    parameters: tuple[Input, ...]
    globals: tuple[Input, ...]
    code: str
    line: int
    definition: str
    per_pixel: bool
    state: tuple[tuple[str, str], ...]
    discards: bool
    extensions: tuple[str, ...]
    obstacle: str = ""

    @property
    def given(self) -> tuple[Input, ...]:
        """The parameters that a caller gives."""
        return tuple(p for p in self.parameters if p.direction != "out")

    @property
    def outputs(self) -> tuple[tuple[str, Type], ...]:
        """What a call gives, by name: the result, then what is written to parameters."""
        outs = tuple((p.name, p.type) for p in self.parameters if p.direction != "in")
        name = "result" if all(p.name != "result" for p in self.parameters) else "returned"
        return outs if self.result.name == "void" else ((name, self.result), *outs)

    def __str__(self) -> str:
        shown = ", ".join(
            f"{'' if p.direction == 'in' else p.direction + ' '}{p.type} {p.name}".rstrip()
            for p in self.parameters
        )
        return f"{self.result} {self.name}({shown})"


def find_signatures(found: Declarations) -> dict[str, list[Signature]]:
    """The signatures of a file's functions by name, but for `main`."""
    return {
        name: [_signature(found, function) for function in functions]
        for name, functions in found.functions().items()
        if name != "main"
    }


def _signature(found: Declarations, own: GlslDeclaration) -> Signature:
    needed = found.needed_by(own)
    used = frozenset[str]().union(*(one.uses for one in needed))
    obstacles: list[str] = []

    def type_of(written: TypeSpecifier, what: str) -> Type:
        try:
            return found.type_of(written)
        except LookupError as error:
            obstacles.append(f"{what}: {error.args[0]}")
            return Type(written.name)

    result = type_of(own.result, "its result")
    parameters = tuple(
        Input(one.name or f"_{number}", type_of(one.type, f"parameter {one.name}"), _direction(one))
        for number, one in enumerate(own.members)
    )
    built_in = _built_in_inputs(found, used)
    globals_ = tuple(
        Input(one.name, type_of(one.type, one.name), optional=bool(one.initialiser))
        for one in _variables_to_give(needed)
    ) + tuple(Input(name, type_) for name, type_ in built_in.items())
    obstacles += _obstacles(needed, used, parameters, globals_)
    if not obstacles:
        obstacles += itertools.islice(_unknown_types(result, parameters), 1)
    declared = built_in | {n: Type(t) for n, t in _STAGE_OUTPUTS.items() if n in used}
    before = "".join(
        f"{'uniform ' * type_.opaque}{declare(type_, name)}; " for name, type_ in declared.items()
    )
    body = _modernise("".join(found.text[one.start : one.end] + "\n" for one in needed))
    return Signature(
        name=own.name,
        result=result,
        parameters=parameters,
        globals=globals_,
        code=_modernise(before) + _modernise(_text_of(found, needed)),
        line=found.text.count("\n", 0, own.start) + 1,
        definition=found.text[own.start : own.end],
        per_pixel=FRAGMENT_ONLY.search(body) is not None,
        state=tuple((one.name, one.initialiser) for one in _state(needed) if one.initialiser),
        discards="discard" in used,
        extensions=found.extensions,
        obstacle="; ".join(dict.fromkeys(obstacles)),
    )


def _direction(parameter: Declarator) -> Direction:
    words = parameter.qualifiers
    return "inout" if "inout" in words else "out" if "out" in words else "in"


def _built_in_inputs(found: Declarations, used: frozenset[str]) -> dict[str, Type]:
    """What a function reads of other stages, and of Shadertoy unless the file declares it."""
    declared = {name for one in found.all for name in one.declares}
    inputs = {n: Type(t) for n, t in _STAGE_INPUTS.items() if n in used}
    return inputs | {n: t for n, t in _SHADERTOY.items() if n in used and n not in declared}


def _obstacles(
    needed: list[GlslDeclaration],
    used: frozenset[str],
    parameters: tuple[Input, ...],
    globals_: tuple[Input, ...],
) -> Iterator[str]:
    """Why a function can't be called."""
    for one in needed:
        if one.kind == "block" and "buffer" in one.qualifiers:
            yield f"reads or writes the storage block {one.name}"
    for given in globals_:
        type_ = given.type
        if type_.opaque and not type_.members and not _TEXTURED.fullmatch(type_.name):
            yield f"reads {type_} {given.name}"
    for given in parameters:
        if "sampler" in given.type.name[:8] and not _TEXTURED.fullmatch(given.type.name):
            yield f"{given.name} is a {given.type}, of which the lab has no textures"
    yield from (f"uses {name}, of another stage" for name in sorted(used & _OTHER_STAGES))


def _unknown_types(result: Type, parameters: tuple[Input, ...]) -> Iterator[str]:
    for name, type_ in (("result", result), *((p.name, p.type) for p in parameters)):
        if type_.name != "void" and not type_.known and not type_.opaque:
            yield f"{name} is a {type_}, which has no counterpart in NumPy's float32"


def declare(kind: Type, name: str) -> str:
    """A variable's declaration.

    >>> declare(Type("vec3", (4,)), "points")
    'vec3 points[4]'
    """
    return f"{kind.name} {rename(name)}" + "".join(f"[{n}]" for n in kind.dims)


def rename(name: str) -> str:
    """A global's name in the text that is compiled, where `gl_` is GLSL's own."""
    return PREFIX + name[3:] if name in _STAGE_INPUTS or name in _STAGE_OUTPUTS else name


def _modernise(text: str) -> str:
    return _OLD.sub(r"texture\1\2", _GL.sub(rf"{PREFIX}\1", text))


def _redeclares(one: GlslDeclaration) -> bool:
    """Whether it declares anew what GLSL declares itself."""
    return any(name.startswith("gl_") for name in one.declares)


def _variables_to_give(needed: list[GlslDeclaration]) -> Iterator[Declarator]:
    """The variables that somebody else sets; what GLSL declares itself may be declared again."""
    for one in needed:
        if not one.qualifiers & _GIVEN or _redeclares(one):
            continue
        if one.kind == "struct":
            yield from one.variables
        elif one.kind == "block":
            yield from one.members if one.instance is None else [one.instance]
        elif one.kind == "variables":
            yield from one.members


def _state(needed: list[GlslDeclaration]) -> Iterator[Declarator]:
    """The variables that the file's own functions may change."""
    for one in needed:
        if one.kind in ("struct", "variables") and not one.qualifiers & (_GIVEN | {"const"}):
            yield from one.members if one.kind == "variables" else one.variables


def _text_of(found: Declarations, needed: list[GlslDeclaration]) -> str:
    """The file's text with nothing but what is needed, each on its own lines. What other stages and
    callers set becomes plain variables, which a kernel assigns."""
    parts, at = [], 0
    text = found.text
    for one in needed:
        parts.append("\n" * text.count("\n", at, one.start))
        whole = text[one.start : one.end]
        new = _as_variables(found, one, whole)
        parts.append(new + "\n" * (whole.count("\n") - new.count("\n")))
        at = one.end
    return "".join(parts)


def _as_variables(found: Declarations, one: GlslDeclaration, whole: str) -> str:
    """A declaration's own text, or plain variables for what other stages and callers set."""
    if _redeclares(one):
        return ""
    if one.kind == "block":
        members = "".join(f"{_written(m)}; " for m in one.members)
        if one.instance is None:
            return members
        return f"struct {one.name} {{ {members}}}; {_written(one.instance)};"
    if one.kind == "struct" and one.variables:
        head = whole[whole.index("struct") : whole.rindex("}") + 1]
        return head + "; " + _plain_variables(found, one.variables)
    if one.kind == "variables":
        return _plain_variables(found, one.members)
    return whole


def _plain_variables(found: Declarations, variables: tuple[Declarator, ...]) -> str:
    texts = []
    for one in variables:
        try:
            opaque = found.type_of(one.type).opaque
        except LookupError:
            opaque = False
        default = " = " + " ".join(one.initialiser.split()) if one.initialiser else ""
        qualifier = "uniform " if opaque else "const " if "const" in one.qualifiers else ""
        texts.append(f"{qualifier}{_written(one)}{default};")
    return " ".join(texts)


def _written(one: Declarator) -> str:
    return f"{one.type.name} {one.name}" + "".join(f"[{n}]" for n in one.type.lengths)
