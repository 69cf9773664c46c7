"""GLSL's types, what a file declares, and what calling its functions takes.

In Python, a value of a type is an array whose last axes are the type's own `shape`; all axes before
those are the batch, over which a function is called. A struct is a mapping of its members, an array
of structs a sequence of such mappings.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from shaderlab import glslmath
from shaderlab.compiler.dialects import CALLS, keep_own_names
from shaderlab.compiler.shader_files import HOST_INPUTS
from shaderlab.compiler.syntax import (
    Declarator,
    GlslDeclaration,
    Syntax,
    TypeSpecifier,
    check_brackets,
)
from shaderlab.glslmath import sampling

_BASIC = re.compile(
    r"(?P<scalar>float|int|uint|bool)|(?P<kind>[iub]?)vec(?P<size>[234])"
    r"|mat(?P<columns>[234])(?:x(?P<rows>[234]))?"
)
_OPAQUE = re.compile(r"[iu]?(sampler|image|texture|subpassInput)\w*|sampler|atomic_uint")
_KINDS = {"": "float", "i": "int", "u": "uint", "b": "bool"}
DTYPES = {"float": "float32", "int": "int32", "uint": "uint32", "bool": "bool"}
"""NumPy's type for each kind of number."""


@dataclass(frozen=True)
class Type:
    """A GLSL type; its name is without array lengths: "vec3", "Light", "sampler2D"."""

    name: str
    dims: tuple[int, ...] = ()
    members: tuple[tuple[str, Type], ...] = ()

    def __str__(self) -> str:
        return self.name + "".join(f"[{n}]" for n in self.dims)

    @cached_property
    def kind(self) -> str:
        """What its numbers are: "float", "int", "uint" or "bool"; "" for any other type."""
        match = _BASIC.fullmatch(self.name)
        if match is None:
            return ""
        return match["scalar"] or _KINDS[match["kind"] or ""]

    @cached_property
    def base_shape(self) -> tuple[int, ...]:
        """The shape of one element: () for a scalar, (n,), or (rows, columns)."""
        match = _BASIC.fullmatch(self.name)
        if match is None or match["scalar"]:
            return ()
        if match["size"]:
            return (int(match["size"]),)
        return (int(match["rows"] or match["columns"]), int(match["columns"]))

    @property
    def shape(self) -> tuple[int, ...]:
        """The last axes of an array of such values: array lengths, then `base_shape`."""
        return self.dims + self.base_shape

    @property
    def element(self) -> Type:
        return Type(self.name, self.dims[1:], self.members)

    @cached_property
    def opaque(self) -> bool:
        """Whether it is a sampler, or holds one."""
        return bool(_OPAQUE.fullmatch(self.name)) or any(t.opaque for _, t in self.members)

    @cached_property
    def known(self) -> bool:
        """Whether it can be passed and returned as numbers."""
        return all(t.known for _, t in self.members) if self.members else bool(self.kind)

    @cached_property
    def words(self) -> int:
        """How many 32-bit words a value takes."""
        inner = sum(t.words for _, t in self.members)
        return math.prod(self.dims) * (inner or math.prod(self.base_shape))

    def leaves(self, name: str) -> Iterator[tuple[str, Type]]:
        """The whole name and the type of each member that is no struct: "lights[0].power"."""
        if self.dims and (self.members or self.opaque):
            for n in range(self.dims[0]):
                yield from self.element.leaves(f"{name}[{n}]")
        elif self.members:
            for member, its in self.members:
                yield from its.leaves(f"{name}.{member}")
        else:
            yield name, self


@dataclass(frozen=True)
class Declarations:
    """A file's declarations; its text is preprocessed, with directives blanked out."""

    text: str
    extensions: tuple[str, ...]
    all: tuple[GlslDeclaration, ...]
    constants: Mapping[str, int]

    @cached_property
    def names(self) -> frozenset[str]:
        return frozenset(name for one in self.all for name in one.declares)

    def needed_by(self, function: GlslDeclaration) -> list[GlslDeclaration]:
        """What a function needs, itself included, in order."""
        by_name: dict[str, list[GlslDeclaration]] = {}
        for one in self.all:
            for name in one.declares:
                by_name.setdefault(name, []).append(one)
        found = {function.start}
        open_ends = list(function.uses)
        while open_ends:
            for one in by_name.get(open_ends.pop(), ()):
                # Another overload may take what somebody else declares.
                apart = one.name == function.name and not all(map(self._is_known, one.members))
                if one.start not in found and not apart:
                    found.add(one.start)
                    open_ends += one.uses
        return [one for one in self.all if one.start in found]

    def _is_known(self, one: Declarator) -> bool:
        structs = {known.name for known in self.all if known.kind == "struct"}
        return one.type.name in structs or Type(one.type.name).opaque or Type(one.type.name).known

    def type_of(self, written: TypeSpecifier) -> Type:
        """The type that is written so. Raises LookupError, whose message names what is unknown."""
        dims = []
        for length in written.lengths:
            value = _constant(length, self.constants)
            if value is None or value < 1:
                raise LookupError(f"the length of {written.name}[{length}] is not known")
            dims.append(value)
        structs = {one.name: one.members for one in self.all if one.kind in ("struct", "block")}
        members = ((m.name, self.type_of(m.type)) for m in structs.get(written.name, ()))
        return Type(written.name, tuple(dims), tuple(members))


def read_declarations(text: str) -> Declarations:
    """What a preprocessed text declares. Raises ShaderError: brackets do not match; its line is
    that of the text."""
    rows = text.split("\n")
    extensions = tuple(row.strip() for row in rows if row.lstrip().startswith("#extension"))
    text = "\n".join("" if row.lstrip().startswith("#") else row for row in rows)
    check_brackets(text)
    found = Syntax(text).declarations
    constants: dict[str, int] = {}
    for one in found:
        if one.kind == "variables" and "const" in one.qualifiers:
            for member in one.members:
                value = _constant(member.initialiser, constants)
                if value is not None:
                    constants[member.name] = value
    return Declarations(text, extensions, found, constants)


def _constant(expression: str, known: Mapping[str, int]) -> int | None:
    """The value of an integer constant expression; None if it is anything else."""
    code = re.sub(r"(?<=[\da-fA-F])[uU]\b", "", expression).replace("/", "//").strip()
    code = re.sub(r"\bu?int\b", "", code)
    code = re.sub(r"\b[A-Za-z_]\w*", lambda name: str(known.get(name[0], name[0])), code)
    if not re.fullmatch(r"(?:0[xX][\da-fA-F]+|\d+|[\s()+*/%<>-])+", code):
        return None
    try:
        value = eval(code)
    except (SyntaxError, TypeError, ArithmeticError, ValueError):
        return None
    return value if type(value) is int else None


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
_OTHER_STAGES = frozenset({
    "EmitVertex", "EndPrimitive", "EmitStreamVertex", "barrier", "subpassLoad",
    "gl_in", "gl_out", "gl_InvocationID", "gl_TessCoord",
})  # fmt: skip
_GL = re.compile(rf"\bgl_({'|'.join(n[3:] for n in (*_STAGE_INPUTS, *_STAGE_OUTPUTS))})\b")
# GLSL's own words; what is not among them is compiled before it counts as unknown.
_FUNCTIONS = frozenset((*dir(glslmath), *dir(sampling))) - {"array", "mul", "swizzle", "where"}
_WORDS = re.compile(
    rf"{_BASIC.pattern}|gl_\w+|void|true|false|not|if|else|for|while|do|switch|case|default|break"
    r"|continue|return|discard|const|in|out|inout|uniform|attribute|varying|buffer|shared|struct|flat"
    r"|smooth|noperspective|centroid|sample|patch|invariant|precise|precision|(?:high|medium|low)p"
    r"|coherent|volatile|restrict|readonly|writeonly|layout|location|binding|std[14][34]0|double"
    r"|matrixCompMult|d(?:mat|vec)\w+|[iu]?(?:sampler|image)\w*|texture(?:[123]D|Cube)\w*"
)
# The samplers that the lab has textures for.
_TEXTURED = re.compile(r"[iu]?sampler(?:2D|2DArray|Cube)|sampler(?:2D|2DArray|Cube)Shadow")


@dataclass(frozen=True)
class Input:
    """A parameter, or a global that the function's file leaves to others to set, whose direction is
    "in". It is optional if the file has a value for it, or the function does not read it, as other
    members of a block."""

    name: str
    type: Type
    direction: Direction = "in"
    optional: bool = False


@dataclass(frozen=True)
class Signature:
    """One function of a file, an overload of its name: what it returns ("void" for nothing), the
    text that it needs, line for line as in the file, and the line of the definition in that,
    counted from 1, variables of the file that a call may change, with their initialisers, why it
    can't be called ("" if it can), and the names in the text that nothing declares."""

    name: str
    result: Type
    parameters: tuple[Input, ...]
    globals: tuple[Input, ...]
    code: str
    line: int
    definition: str
    state: tuple[tuple[str, str], ...]
    discards: bool
    extensions: tuple[str, ...]
    obstacle: str = ""
    lacks: frozenset[str] = frozenset()

    @property
    def given(self) -> tuple[Input, ...]:
        return tuple(p for p in self.parameters if p.direction != "out")

    @property
    def outputs(self) -> tuple[tuple[str, Type], ...]:
        """What a call returns, by name: the result, then what is written to parameters."""
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
    """The signatures of a file's functions by name, several where it is overloaded; not `main`."""
    signatures: dict[str, list[Signature]] = {}
    for one in found.all:
        if one.kind == "function" and one.name != "main":
            signatures.setdefault(one.name, []).append(_signature(found, one))
    return signatures


def find_names_to_give(found: Declarations) -> Iterator[str]:
    """Yield the names of all globals that functions of a file may read and callers give."""
    yield from (one.name for one in _variables_to_give(list(found.all)))
    yield from _STAGE_INPUTS
    yield from HOST_INPUTS


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
    built_in = _find_built_in_inputs(found, used)
    globals_ = tuple(
        Input(v.name, type_of(v.type, v.name), optional=bool(v.initialiser) or v.name not in used)
        for v in _variables_to_give(needed)
    ) + tuple(Input(name, type_) for name, type_ in built_in.items())
    obstacles += _obstacles(needed, used, parameters, globals_)
    for name, type_ in (("result", result), *((p.name, p.type) for p in parameters)):
        if not obstacles and not (type_.name == "void" or type_.known or type_.opaque):
            known = type_.members or type_.name.startswith("d")  # double, dvec3, a struct of them
            why = "has no counterpart in NumPy's float32" if known else "nothing defines"
            obstacles.append(f"{name} is a {type_}, which {why}")
    declared = built_in | {n: Type(t) for n, t in _STAGE_OUTPUTS.items() if n in used}
    before = "".join(
        f"{'uniform ' * type_.opaque}{declare(type_, name)}; " for name, type_ in declared.items()
    )
    return Signature(
        name=own.name,
        result=result,
        parameters=parameters,
        globals=globals_,
        code=_modernise(before) + _modernise(_text_of(found, needed)),
        line=found.text.count("\n", 0, own.start) + 1,
        definition=found.text[own.start : own.end],
        state=tuple((one.name, one.initialiser) for one in _state(needed) if one.initialiser),
        discards="discard" in used,
        extensions=found.extensions,
        obstacle="; ".join(dict.fromkeys(obstacles)),
        lacks=frozenset(
            name
            for name in used - built_in.keys() - found.names - _FUNCTIONS
            if not _WORDS.fullmatch(name)
        ),
    )


def _direction(parameter: Declarator) -> Direction:
    words = parameter.qualifiers
    return "inout" if "inout" in words else "out" if "out" in words else "in"


def _find_built_in_inputs(found: Declarations, used: frozenset[str]) -> dict[str, Type]:
    """What a function reads of other stages, and of viewers unless the file declares it."""
    inputs = {n: Type(t) for n, t in _STAGE_INPUTS.items() if n in used}
    hosts = HOST_INPUTS.keys() & used - found.names
    return inputs | {n: Type(*kind) for n, kind in HOST_INPUTS.items() if n in hosts}


def _obstacles(
    needed: list[GlslDeclaration],
    used: frozenset[str],
    parameters: tuple[Input, ...],
    globals_: tuple[Input, ...],
) -> Iterator[str]:
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
    return CALLS.sub(r"texture\1", _GL.sub(rf"{PREFIX}\1", keep_own_names(text)))


def _variables_to_give(needed: list[GlslDeclaration]) -> Iterator[Declarator]:
    """The variables that the application or other stages set, but for redeclared built-in ones."""
    for one in needed:
        if not one.qualifiers & _GIVEN or any(name.startswith("gl_") for name in one.declares):
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
    for one in needed:
        whole = found.text[one.start : one.end]
        new = _as_variables(found, one, whole)
        parts.append("\n" * found.text.count("\n", at, one.start) + new)
        parts.append("\n" * (whole.count("\n") - new.count("\n")))
        at = one.end
    return "".join(parts)


def _as_variables(found: Declarations, one: GlslDeclaration, whole: str) -> str:
    """A declaration's own text, or plain variables for what other stages and callers set."""
    if any(name.startswith("gl_") for name in one.declares):
        return ""
    if one.kind == "block":
        members = "".join(f"{_declaration_text(m)}; " for m in one.members)
        if one.instance is None:
            return members
        return f"struct {one.name} {{ {members}}}; {_declaration_text(one.instance)};"
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
        texts.append(f"{qualifier}{_declaration_text(one)}{default};")
    return " ".join(texts)


def _declaration_text(one: Declarator) -> str:
    return f"{one.type.name} {one.name}" + "".join(f"[{n}]" for n in one.type.lengths)
