"""What calling a function takes: its parameters, the globals that it reads, its text alone."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from shaderlab.functions.declarations import Declarations
from shaderlab.functions.emission import Types, emitted, redeclares
from shaderlab.functions.scanner import Item, Named, Spec
from shaderlab.functions.types import Type

PREFIX = "shaderlab_"
Direction = Literal["in", "out", "inout"]

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


def signatures(found: Declarations) -> dict[str, list[Signature]]:
    """The signatures of a file's functions by name."""
    return {
        name: [_signature(found, item) for item in items]
        for name, items in found.functions().items()
        if name != "main"
    }


def _signature(found: Declarations, own: Item) -> Signature:
    needed = found.needed(own)
    types = Types(found)
    obstacles: list[str] = []
    used = frozenset[str]().union(*(item.uses for item in needed))

    def typed(spec: Spec, what: str) -> Type:
        try:
            return types.of(spec)
        except LookupError as error:
            obstacles.append(f"{what}: {error.args[0]}")
            return Type(spec.name)

    result = Type("void") if own.result.name == "void" else typed(own.result, "its result")
    parameters = []
    for number, named in enumerate(own.members):
        direction: Direction = (
            "inout" if "inout" in named.qualifiers else "out" if "out" in named.qualifiers else "in"
        )
        kind = typed(named.spec, f"parameter {named.name}")
        parameters.append(Input(named.name or f"_{number}", kind, direction))
    globals_ = []
    for named in _given(needed):
        globals_.append(
            Input(named.name, typed(named.spec, named.name), optional=bool(named.default))
        )
    declared = {name for item in found.items for name in item.declares}
    extra = {n: Type(t) for n, t in _STAGE_INPUTS.items() if n in used}
    extra |= {n: t for n, t in _SHADERTOY.items() if n in used and n not in declared}
    globals_ += [Input(name, kind) for name, kind in extra.items()]
    extra |= {n: Type(t) for n, t in _STAGE_OUTPUTS.items() if n in used}
    for item in needed:
        if item.kind == "block" and "buffer" in item.qualifiers:
            obstacles.append(f"reads or writes the storage block {item.name}")
    for one in globals_:
        if one.type.opaque and not one.type.members and not _TEXTURED.fullmatch(one.type.name):
            obstacles.append(f"reads {one.type} {one.name}")
    for one in parameters:
        if "sampler" in one.type.name[:8] and not _TEXTURED.fullmatch(one.type.name):
            obstacles.append(f"{one.name} is a {one.type}, of which the lab has no textures")
    obstacles += [f"uses {name}, of another stage" for name in sorted(used & _OTHER_STAGES)]
    for name, kind in (("result", result), *((p.name, p.type) for p in parameters)):
        if kind.name != "void" and not kind.known and not kind.opaque and not obstacles:
            obstacles.append(f"{name} is a {kind}, which has no counterpart in NumPy's float32")
    before = "".join(
        f"{'uniform ' * kind.opaque}{declaration(kind, name)}; " for name, kind in extra.items()
    )
    body = _renamed("".join(found.text[item.start : item.end] + "\n" for item in needed))
    return Signature(
        name=own.name,
        result=result,
        parameters=tuple(parameters),
        globals=tuple(globals_),
        code=_renamed(before) + _renamed(emitted(found, needed, types)),
        line=found.text.count("\n", 0, own.start) + 1,
        definition=found.text[own.start : own.end],
        per_pixel=FRAGMENT_ONLY.search(body) is not None,
        state=tuple((v.name, v.default) for v in _state(needed) if v.default),
        discards="discard" in used,
        extensions=found.extensions,
        obstacle="; ".join(dict.fromkeys(obstacles)),
    )


def declaration(kind: Type, name: str) -> str:
    """A variable's declaration.

    >>> declaration(Type("vec3", (4,)), "points")
    'vec3 points[4]'
    """
    return f"{kind.name} {variable(name)}" + "".join(f"[{n}]" for n in kind.dims)


def variable(name: str) -> str:
    """A global's name in the emitted text."""
    return PREFIX + name[3:] if name in _STAGE_INPUTS or name in _STAGE_OUTPUTS else name


def _renamed(text: str) -> str:
    return _OLD.sub(r"texture\1\2", _GL.sub(rf"{PREFIX}\1", text))


def _given(items: list[Item]) -> Iterator[Named]:
    """The variables that somebody else sets; what GLSL declares itself may be declared again."""
    for item in items:
        if not item.qualifiers & _GIVEN or redeclares(item):
            continue
        if item.kind == "variables":
            yield from item.members
        elif item.kind == "struct":
            yield from item.variables
        elif item.kind == "block" and item.instance is not None:
            yield item.instance
        elif item.kind == "block":
            yield from item.members


def _state(items: list[Item]) -> Iterator[Named]:
    """The variables that the file's own functions may change."""
    for item in items:
        if item.kind in ("struct", "variables") and not item.qualifiers & (_GIVEN | {"const"}):
            yield from item.members if item.kind == "variables" else item.variables
