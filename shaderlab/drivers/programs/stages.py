"""The texts that the lab writes from a program's: stages that feed a fragment shader, and stages
that also write down what they got.

An interface names an input as a driver reports it: "VS_OUT.FragPos" by its block's name, whatever
the instance is called. A shader's text has to be read for what the interface leaves out: the
instance's name, and the declarations that a vertex stage must repeat to the letter.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from shaderlab.compiler.reflection import Interface, Variable
from shaderlab.compiler.shader_files import strip_comments
from shaderlab.compiler.syntax import Declarator, GlslDeclaration, Syntax
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array

from .textures import components_of, numpy_type


@dataclass(frozen=True)
class VaryingPart:
    """A scalar or a vector out of an input that an attachment or an attribute holds: the input's
    name, the path from there in GLSL ("" or a matrix' column, "[2]"), and its type."""

    name: str
    path: str
    type: str


class GlslDeclarations:
    """The declarations of inputs in a fragment shader's text (after includes); with "out" for a
    direction, of a vertex or geometry shader's outputs."""

    def __init__(self, text: str, direction: str = "in") -> None:
        found = read_declarations(text)
        own = [declared for declared in found if direction in declared.qualifiers]
        self._structs = [d for d in found if d.kind == "struct"]
        self._blocks = {d.name: d for d in own if d.kind == "block"}
        # Each variable with the words before its type.
        self._plain = {m.name: (d.prefix, m) for d in own for m in d.members if not d.name}

    def spell(self, name: str) -> str:
        """Write an input as the shader itself does: a block's name becomes its instance's.

        >>> GlslDeclarations("in VS_OUT { vec3 FragPos; } fs_in;").spell("VS_OUT.FragPos")
        'fs_in.FragPos'
        """
        head = _head(name)
        block = self._blocks.get(head) if "." in name else None
        if block is None:
            return name
        instance = "" if block.instance is None else block.instance.name
        return instance + name.removeprefix(head)

    def _block_of(self, name: str) -> GlslDeclaration | None:
        """Find the block that an input is a member of."""
        head = _head(name)
        if "." in name and head in self._blocks:
            return self._blocks[head]
        return next((block for block in self._blocks.values() if head in block.declares), None)

    def declare_outputs(self, variables: Sequence[Variable]) -> list[str]:
        """Declare outputs that fit a fragment shader's inputs; blocks and structs to the letter, as
        stages must agree. Raises UnsupportedError: a struct's declaration can't be found."""
        lines: dict[str, None] = {}
        for variable in variables:
            name, head = variable.name, _head(variable.name)
            block = self._block_of(name)
            prefix, member = self._plain.get(head, ("", None))
            qualifiers = re.sub(r"\bin\b", "out", prefix)
            if block is not None:
                instance = ""
                if block.instance is not None:
                    instance = f"{PREFIX}to_{block.name}{_spell_lengths(block.instance)}"
                lines[f"out {block.name} {{{block.body}}} {instance};"] = None
            elif "." in name:
                if member is None:
                    raise UnsupportedError(
                        f"the declaration of the input {name!r} can't be read",
                        remedy="declare it on its own (in Type name;), or draw a mesh",
                    )
                lines[f"{qualifiers} {member.type.name} {head}{_spell_lengths(member)};"] = None
            else:
                array = "" if variable.array is None else f"[{variable.array}]"
                smooth = variable.interpolation == "smooth"
                own = "out" if smooth else f"{variable.interpolation} out"
                lines[f"{qualifiers or own} {variable.type} {name}{array};"] = None
        structs = self._structs if any("." in variable.name for variable in variables) else []
        return [*(f"struct {struct.name} {{{struct.body}}};" for struct in structs), *lines]

    def spell_output(self, name: str) -> str:
        """Write an input's name as of the vertex stage that `declare_outputs` is for."""
        block = self._block_of(name)
        return f"{PREFIX}to_{name}" if block is not None and block.instance else name


@lru_cache(maxsize=64)
def read_declarations(text: str) -> tuple[GlslDeclaration, ...]:
    """Read what a shader's text declares outside of functions."""
    return Syntax(strip_comments(text)).declarations


def _default_layout(text: str, direction: str) -> set[str]:
    """Return the words of all layouts that a stage gives its inputs or outputs by default."""
    layouts = (d.qualifiers for d in read_declarations(text) if d.kind == "layout")
    return {word for words in layouts if direction in words for word in words}


def _spell_lengths(declarator: Declarator) -> str:
    return "".join(f"[{length}]" for length in declarator.type.lengths)


def _head(name: str) -> str:
    """The variable that an input like "surface.normal" or "v[1]" is part of."""
    return name.partition(".")[0].partition("[")[0]


def array_elements(variables: Iterable[Variable]) -> Iterator[Variable]:
    """The variables with each array's elements one by one: "v[0]", "v[1]", …"""
    for variable in variables:
        if variable.array is None:
            yield variable
        for index in range(variable.array or 0):
            yield replace(variable, name=f"{variable.name}[{index}]", array=None)


def split_parts(variable: Variable) -> Iterator[VaryingPart]:
    """A variable that is no array, as vectors: itself, or a matrix' columns.

    >>> from shaderlab.compiler.reflection import Variable
    >>> [piece.path + piece.type for piece in split_parts(Variable(name="m", type="mat2x3"))]
    ['[0]vec3', '[1]vec3']
    """
    if variable.type.startswith("d"):
        raise UnsupportedError(
            f"capturing {variable.name!r}: {variable.type} between stages",
            remedy="pass it on in single precision",
        )
    if not variable.type.startswith("mat"):
        yield VaryingPart(variable.name, "", variable.type)
        return
    columns, _, rows = variable.type[3:].partition("x")
    for column in range(int(columns)):
        yield VaryingPart(variable.name, f"[{column}]", f"vec{rows or columns}")


def join_parts(parts: Mapping[VaryingPart, Array]) -> dict[str, Array]:
    """The inputs by name: vectors (…, components), and matrices (…, rows, columns)."""
    found: dict[str, list[Array]] = {}
    for piece, values in parts.items():
        found.setdefault(piece.name, []).append(values)
    matrices = {piece.name for piece in parts if piece.path}
    return {n: np.stack(v, axis=-1) if n in matrices else v[0] for n, v in found.items()}


PREFIX = "shaderlab_"
COORD = PREFIX + "coord"
NUMBER, NUMBERED = PREFIX + "draw", PREFIX + "drawn"
VERSION = re.compile(r"^[ \t]*#[ \t]*version[^\n]*", re.MULTILINE)
_DIRECTIVE = re.compile(r"^[ \t]*#[ \t]*(?:version|extension)[^\n]*\n?", re.MULTILINE)
MOST_OUTPUTS = 8
_MAY_KEEP_OUT = ("discard", "gl_FragDepth", "gl_SampleMask")
# Words that change the value of an input, or of gl_FragCoord, in the shader that has them.
_CHANGE_INPUTS = ("mediump", "lowp", "origin_upper_left", "pixel_center_integer")
_BUILT_IN = {"gl_FrontFacing": "float", "gl_PointCoord": "vec2", "gl_PrimitiveID": "int"}


def end_of_directives(text: str) -> int:
    """Find where a text's last #version or #extension ends."""
    return max((found.end() for found in _DIRECTIVE.finditer(text)), default=0)


def fragment_input_parts(text: str, inputs: Iterable[Variable]) -> list[VaryingPart]:
    """All that a fragment shader gets, in pieces that fit an attachment: its inputs, and the
    built-in ones that its text names."""
    found = [piece for variable in array_elements(inputs) for piece in split_parts(variable)]
    used = {name: kind for name, kind in _BUILT_IN.items() if re.search(rf"\b{name}\b", text)}
    return [*found, *(VaryingPart(name, "", kind) for name, kind in used.items())]


def may_drop_fragments(text: str) -> bool:
    """Whether a fragment shader may discard fragments, or change their depth or coverage."""
    return any(word in text for word in _MAY_KEEP_OUT)


def changes_inputs(text: str) -> bool:
    """Whether a fragment shader may get other values than another one of the same inputs: in lower
    precision, or with another origin of window coordinates."""
    return any(word in text for word in _CHANGE_INPUTS)


def capture_fragment(
    text: str,
    group: Sequence[VaryingPart],
    unwanted: Collection[str] = (),
    *,
    keep_all: bool = False,
    calls: bool = False,
    numbered: bool = False,
) -> tuple[str, dict[VaryingPart, str]]:
    """Write a fragment shader, unchanged but for a new ending that writes what it got: gl_FragCoord
    to shaderlab_coord, and each piece of `group` to an output of the type `attachment_type`.

    The author's main is called where it may drop fragments, so that `discard` and depth writes
    happen as before, and with `calls`. With `keep_all` it is not: every fragment is kept, with the
    depth that it comes with. Outputs that are `unwanted` become plain variables, to make room. If
    `numbered`, the uniform NUMBER, the draw's number, goes to the output NUMBERED.
    """
    captured = {piece: f"{PREFIX}out{i}" for i, piece in enumerate(group)}
    shader = GlslDeclarations(text)
    calls = not keep_all and (calls or may_drop_fragments(text))
    text = _demote_outputs(text, unwanted)
    declared = [f"out vec4 {COORD};"]
    declared += [f"out {attachment_type(piece)} {name};" for piece, name in captured.items()]
    written = [f"    {COORD} = gl_FragCoord;"]
    written += [f"    {name} = {_attachment_value(p, shader)};" for p, name in captured.items()]
    if numbered:
        declared += [f"uniform float {NUMBER};", f"out float {NUMBERED};"]
        written.append(f"    {NUMBERED} = {NUMBER};")
    if keep_all and "gl_FragDepth" in text:  # what names it has to write it
        written.append("    gl_FragDepth = gl_FragCoord.z;")
    return replace_main(text, declared, written, calls=calls), captured


def capture_vertex(text: str, group: Sequence[VaryingPart]) -> tuple[str, dict[VaryingPart, str]]:
    """Write a vertex shader that also writes some of its outputs, each to a separate output.
    Returns its text, and the output of each piece, of the type `attachment_type`."""
    captured = {piece: f"{PREFIX}out{i}" for i, piece in enumerate(group)}
    shader = GlslDeclarations(text, "out")
    declared = [f"flat out {attachment_type(piece)} {name};" for piece, name in captured.items()]
    written = [f"    {name} = {_attachment_value(p, shader)};" for p, name in captured.items()]
    return replace_main(text, declared, written), captured


OFF_SCREEN = (
    "    if (any(greaterThan(abs(gl_Position.xyz), vec3(gl_Position.w))))",
    "        gl_Position = vec4(64.0, 64.0, 0.0, 1.0);",
)


def clip_points(text: str, size: float | None) -> str:
    """Write the last stage of a program that draws points, which drops those whose middle is
    outside of the clip volume and writes a `size` in pixels, if there is one."""
    lines = [*([] if size is None else [f"    gl_PointSize = {size!r};"]), *OFF_SCREEN]
    return _wrap_emit(text, lines, []) if "EmitVertex" in text else replace_main(text, [], lines)


def pass_instance_on(text: str) -> str:
    """Write a vertex shader that also passes a geometry shader the number of its instance."""
    return replace_main(
        text, [f"flat out int {PREFIX}instance;"], [f"    {PREFIX}instance = gl_InstanceID;"]
    )


def emits_points(texts: Mapping[str, str]) -> bool:
    """Whether a program has a geometry stage that makes points."""
    return "points" in _default_layout(texts.get("geometry", ""), "out")


def replace_main(
    text: str, declared: Sequence[str], written: Sequence[str], *, calls: bool = True
) -> str:
    """Rename the author's main, and add one that calls it (or not) and continues with `written`."""
    version = VERSION.search(text)
    head, rest = ("", text) if version is None else (version.group(0), text[version.end() :])
    body = ["void main() {", *([f"    {PREFIX}main();"] if calls else []), *written, "}", ""]
    renamed = [head, f"#define main {PREFIX}main", rest, "", "#undef main"]
    return "\n".join([*renamed, *declared, *body])


EMITTED = {
    "gl_InstanceID": PREFIX + "of_instance",
    "gl_PrimitiveIDIn": PREFIX + "of_primitive",
    "emitted": PREFIX + "index",
}
"""What `count_emitted` adds to each emitted vertex: where it comes from."""


def count_emitted(text: str) -> str:
    """Write a geometry shader whose vertices also say which instance and primitive they were made
    of, and which of its vertices they are, counted from 0. It feeds on `pass_instance_on`."""
    instance, primitive, index = EMITTED.values()
    declared = [
        f"flat in int {PREFIX}instance[];",
        *(f"flat out int {name};" for name in EMITTED.values()),
        f"int {PREFIX}count = 0;",
    ]
    written = [
        f"    {instance} = {PREFIX}instance[0];",
        f"    {primitive} = gl_PrimitiveIDIn;",
        f"    {index} = {PREFIX}count++;",
    ]
    return _wrap_emit(text, written, declared)


def _wrap_emit(text: str, written: Sequence[str], declared: Sequence[str]) -> str:
    """Make a geometry shader do more as it emits each vertex. What it does stands behind the
    author's own text, as it needs the layout of the inputs' array."""
    at = end_of_directives(text)
    first = [f"void {PREFIX}emit();", f"#define EmitVertex {PREFIX}emit", ""]
    body = [f"void {PREFIX}emit() {{", *written, "    EmitVertex();", "}", ""]
    return "\n".join([text[:at], *first, text[at:], "#undef EmitVertex", *declared, *body])


def _demote_outputs(text: str, names: Collection[str]) -> str:
    """Make outputs plain variables. Raises UnsupportedError: a declaration can't be read."""
    found = [d for d in read_declarations(text) if d.kind == "variables" and "out" in d.qualifiers]
    own = [d for d in found if {member.name for member in d.members} <= set(names)]
    missing = set(names).difference(member.name for d in own for member in d.members)
    if missing:
        raise UnsupportedError(
            f"the declaration of the output {min(missing)!r} can't be read, so there is no room to "
            "capture inputs beside all outputs",
            remedy="declare each output on its own (out Type name;)",
        )
    for declaration in reversed(own):
        precision = declaration.qualifiers & {"highp", "mediump", "lowp"}
        rest = text[declaration.start :].removeprefix(declaration.prefix)
        text = f"{text[: declaration.start]}{' '.join(precision)}{rest}"
    return text


def attachment_type(piece: VaryingPart) -> str:
    """The type of four components that holds a piece: the renderable formats have no three."""
    return {"i": "ivec4", "u": "uvec4"}.get(piece.type[0], "vec4")


def _attachment_value(piece: VaryingPart, shader: GlslDeclarations) -> str:
    size = int(piece.type[-1]) if piece.type[-1].isdigit() else 1
    value = f"{shader.spell(piece.name)}{piece.path}"
    if piece.name == "gl_FrontFacing":
        value = "gl_FrontFacing ? 1.0 : 0.0"  # as an integer it is 0 on softpipe, in front too
    return f"{attachment_type(piece)}({value}{', 0' * (4 - size)})"


BLOCK = PREFIX + "Stored"
"""The storage block: of each vertex a word, 1 where it came out, and the words of its pieces."""
PER_INSTANCE = PREFIX + "per_instance"
"""The uniform that holds how many vertices are stored for an instance at most (int)."""
_EXTENSIONS = ("GL_ARB_shader_storage_buffer_object", "GL_ARB_shader_bit_encoding")
_WORDS = {"f": "floatBitsToUint({})", "v": "floatBitsToUint({})", "i": "uint({})", "u": "{}"}
_FRAGMENT = "#version 330 core\nvoid main() {}\n"
_SIZE = PREFIX + "point_size"


def count_words(parts: Sequence[VaryingPart]) -> int:
    """How many words a vertex takes."""
    return 1 + sum(components_of(piece.type) for piece in parts)


def store_outputs(
    texts: Mapping[str, str], parts: Sequence[VaryingPart], most: int
) -> dict[str, str]:
    """Write a program whose last stage before rasterisation stores these pieces of each vertex.

    A vertex stage stores vertex v of instance i in place i · PER_INSTANCE + v. A geometry stage, as
    `count_emitted` makes it, which emits `most` vertices of a primitive, stores vertex k of
    primitive p in place i · PER_INSTANCE + p · `most` + k.
    """
    last = "geometry" if "geometry" in texts else "vertex"
    text = _extend(texts[last])
    stored = list(_store_words(parts, GlslDeclarations(texts[last], "out")))
    size = ["    gl_PointSize = 1.0;"] if last == "vertex" or emits_points(texts) else []
    if last == "vertex":
        place = f"gl_InstanceID * {PER_INSTANCE} + gl_VertexID"
        written = [_begin_store(place, parts), *stored, *size]
        return {"vertex": replace_main(text, _declare_storage(), written), "fragment": _FRAGMENT}
    instance, primitive, index = EMITTED.values()
    place = f"{instance} * {PER_INSTANCE} + {primitive} * {most} + {index}"
    # The last function is the one that emits.
    head, mark, body = text.rpartition(f"void {PREFIX}emit() {{\n")
    counting, emitting, _ = body.rpartition("    EmitVertex();\n")
    lines = [*_declare_storage(), f"{mark}{counting}{_begin_store(place, parts)}", *stored, *size]
    geometry = "\n".join([head, *lines, f"{emitting}}}", ""])
    return {"vertex": texts["vertex"], "geometry": geometry, "fragment": _FRAGMENT}


def unpack_outputs(parts: Sequence[VaryingPart], words: Array) -> dict[VaryingPart, Array]:
    """The pieces of each vertex that came out, (vertices, components), of the words (uint32)."""
    sizes = [components_of(piece.type) for piece in parts]
    rows = words.reshape(-1, count_words(parts))
    rows = rows[rows[:, 0] == 1, 1:]
    columns = np.split(rows, np.cumsum(sizes)[:-1], axis=1)
    return {
        piece: np.ascontiguousarray(part).view(numpy_type(piece.type))
        for piece, part in zip(parts, columns, strict=True)
    }


def _declare_storage() -> list[str]:
    block = f"layout(std430) buffer {BLOCK} {{ uint {PREFIX}words[]; }};"
    return [block, f"uniform int {PER_INSTANCE};"]


def _begin_store(place: str, parts: Sequence[VaryingPart]) -> str:
    return f"    uint at = uint({place}) * {count_words(parts)}u; {PREFIX}words[at] = 1u;"


def _extend(text: str) -> str:
    """The text with the extensions that storing takes, after its #version; a point's size is a
    variable of its own, which can be read."""
    version = VERSION.search(text)
    end = 0 if version is None else version.end()
    lines = "".join(f"\n#extension {name} : enable" for name in _EXTENSIONS)
    body = re.sub(r"\bgl_PointSize\b", _SIZE, text[end:])
    return f"{text[:end]}{lines}\nfloat {_SIZE};{body}"


def _store_words(parts: Sequence[VaryingPart], shader: GlslDeclarations) -> Iterator[str]:
    at = 1
    for piece in parts:
        name = _SIZE if piece.name == "gl_PointSize" else shader.spell(piece.name)
        count = components_of(piece.type)
        for component in range(count):
            one = f"{name}{piece.path}" + (f"[{component}]" if count > 1 else "")
            yield f"    {PREFIX}words[at + {at}u] = {_WORDS[piece.type[0]].format(one)};"
            at += 1


_LEVELS = (
    *(f"gl_TessLevelOuter[{n}]" for n in range(4)),
    *(f"gl_TessLevelInner[{n}]" for n in range(2)),
)
# Of the 128 components that an evaluation stage may have for outputs at least (OpenGL 4.5, table
# 23.57), what is left to the author's own.
_ROOM = 64


def patch_primitive(text: str) -> str:
    """What an evaluation shader's patches are divided into: "points", "lines" or "triangles".

    >>> patch_primitive("layout (quads, equal_spacing) in;")
    'triangles'
    """
    words = _default_layout(text, "in")
    if "point_mode" in words:
        return "points"
    return "lines" if "isolines" in words else "triangles"


def control_outputs(interface: Interface) -> Iterator[VaryingPart]:
    """What a control stage makes of a patch, as the evaluation stage calls it: the levels, and what
    it gives of each vertex and of the whole."""
    yield from (VaryingPart(name, "", "float") for name in _LEVELS)
    count = interface.patch_vertices
    yield from (VaryingPart(f"gl_in[{n}].gl_Position", "", "vec4") for n in range(count))
    for variable in array_elements(interface.evaluation_inputs.values()):
        vertex = re.match(r"\w+\[(\d+)\]", variable.name)
        if variable.patch or vertex is None or int(vertex.group(1)) < count:
            yield from split_parts(variable)


def group_inputs(interface: Interface) -> Iterator[list[VaryingPart]]:
    """Divide what an evaluation shader gets into groups that one draw passes on: where it is in
    which patch, and what the control stage made of that."""
    group = [VaryingPart("gl_TessCoord", "", "vec3"), VaryingPart("gl_PrimitiveID", "", "int")]
    room = _ROOM - 4
    for piece in control_outputs(interface):
        size = components_of(piece.type)
        if size > room:
            yield group
            group, room = [], _ROOM
        group.append(piece)
        room -= size
    yield group


def copy_inputs(
    text: str, group: Sequence[VaryingPart]
) -> tuple[str, Mapping[VaryingPart, VaryingPart]]:
    """Write an evaluation shader that also passes some inputs on; returns the outputs, too."""
    shader = GlslDeclarations(text)
    copies = {p: VaryingPart(f"{PREFIX}in{n}", "", p.type) for n, p in enumerate(group)}
    flat = {"i": "flat ", "u": "flat "}
    declared = [f"{flat.get(c.type[0], '')}out {c.type} {c.name};" for c in copies.values()]
    written = [f"    {c.name} = {shader.spell(p.name)}{p.path};" for p, c in copies.items()]
    return replace_main(text, declared, written), copies


def write_domain_stage(text: str, inputs: Iterable[Variable]) -> str:
    """Write a vertex stage for one screen-filling triangle, feeding the fragment shader's `inputs`
    as linear ramps: each takes three uniforms, shaderlab_NAME_origin, _dx and _dy; those of members
    of a block or a struct are members of one themselves (shaderlab_VS_OUT.FragPos_origin). Raises
    UnsupportedError: an input is an array."""
    variables, shader = sorted(inputs, key=lambda variable: variable.name), GlslDeclarations(text)
    written = []
    ramps: dict[str, list[str]] = {}
    for variable in variables:
        name, kind = variable.name, variable.type
        if variable.array is not None or "[" in name or name.count(".") > 1:
            raise UnsupportedError(
                f"a domain for {name!r}, an input that is an array or lies deeper than one struct",
                remedy="draw a mesh with a vertex shader of your own",
            )
        owner, dot, own = name.rpartition(".")
        integer = kind[0] in "iu"
        parts = ("origin",) if integer else ("origin", "dx", "dy")
        ramps.setdefault(owner, []).extend(f"{kind} {own}_{part};" for part in parts)
        origin, *steps = (f"{PREFIX}{owner}{dot}{own}_{part}" for part in parts)
        value = origin if integer else f"{origin} + st.x * {steps[0]} + st.y * {steps[1]}"
        written.append(f"    {shader.spell_output(name)} = {value};")
    declared = shader.declare_outputs(variables)
    for owner, members in ramps.items():
        if not owner:
            declared += [f"uniform {m.replace(' ', f' {PREFIX}', 1)}" for m in members]
            continue
        declared.append(f"struct {PREFIX}ramps_{owner} {{ {' '.join(members)} }};")
        declared.append(f"uniform {PREFIX}ramps_{owner} {PREFIX}{owner};")
    body = [
        "void main() {",
        "    vec2 st = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;",
        *written,
        "    gl_Position = vec4(st * 2.0 - 1.0, 0.0, 1.0);",
        "}",
    ]
    return "\n".join([find_version(text), *declared, *body, ""])


@lru_cache(maxsize=256)
def write_probe_stage(
    text: str, inputs: tuple[Variable, ...]
) -> tuple[str, Mapping[VaryingPart, str]]:
    """Write a vertex stage that puts vertex i on pixel i of a row-by-row target, feeding `inputs`
    from attributes, without interpolation. Returns its text, and the attribute of each piece."""
    shader = GlslDeclarations(text)
    parts = [piece for variable in array_elements(inputs) for piece in split_parts(variable)]
    attributes = {piece: f"{PREFIX}in{i}" for i, piece in enumerate(parts)}
    declared = ["uniform ivec2 shaderlab_size;"]
    declared += [f"in {piece.type} {name};" for piece, name in attributes.items()]
    declared += shader.declare_outputs(inputs)
    body = [
        "void main() {",
        *(f"    {shader.spell_output(p.name)}{p.path} = {name};" for p, name in attributes.items()),
        "    vec2 pixel = vec2(gl_VertexID % shaderlab_size.x, gl_VertexID / shaderlab_size.x);",
        "    gl_Position = vec4((pixel + 0.5) / vec2(shaderlab_size) * 2.0 - 1.0, 0.0, 1.0);",
        "    gl_PointSize = 1.0;",
        "}",
    ]
    return "\n".join([find_version(text), *declared, *body, ""]), attributes


def find_version(text: str) -> str:
    """A shader's own #version line, or the oldest that generated stages can be written in."""
    found = VERSION.search(text)
    return found.group(0).strip() if found else "#version 330 core"
