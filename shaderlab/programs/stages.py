"""GLSL that the lab writes itself: text only, no device.

A stage that lays a domain over the screen, one that runs a fragment shader on given inputs, and
endings for shaders that also write down what they got. Names they add start with `shaderlab_`, so
that they can't meet an author's.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence, Sized
from dataclasses import dataclass

from shaderlab.errors import UnsupportedError
from shaderlab.glsl.interface import Variable
from shaderlab.programs.varyings import Declared, Piece, elements, pieces

PREFIX = "shaderlab_"
COORD = PREFIX + "coord"
_VERSION = re.compile(r"^[ \t]*#[ \t]*version[^\n]*", re.MULTILINE)
_DIRECTIVE = re.compile(r"^[ \t]*#[ \t]*(?:version|extension)[^\n]*\n?", re.MULTILINE)
MOST_OUTPUTS = 8
_KEEPS_OUT = ("discard", "gl_FragDepth", "gl_SampleMask")
# Words that change what an input's value, or gl_FragCoord, is in one shader and not in another.
_OWN_READING = ("mediump", "lowp", "origin_upper_left", "pixel_center_integer")
_BUILT_IN = {"gl_FrontFacing": "float", "gl_PointCoord": "vec2", "gl_PrimitiveID": "int"}


@dataclass(frozen=True)
class CapturedInput:
    """A piece of a fragment input and the extra output that holds it, padded to four."""

    piece: Piece
    output: str

    @property
    def format(self) -> str:
        """The attachment format that holds it without loss."""
        kind = {"i": "rgba32i", "b": "rgba32i", "u": "rgba32ui"}
        return kind.get(self.piece.type[0], "rgba32f")


def version_line(text: str) -> str:
    """A shader's own #version line, or the oldest that generated stages can be written in."""
    found = _VERSION.search(text)
    return found.group(0).strip() if found else "#version 330 core"


def input_pieces(text: str, inputs: Iterable[Variable]) -> list[Piece]:
    """All that a fragment shader gets, in pieces that fit an attachment: its inputs, and the
    built-in ones that its text names."""
    found = [piece for variable in elements(inputs) for piece in pieces(variable)]
    used = {name: kind for name, kind in _BUILT_IN.items() if re.search(rf"\b{name}\b", text)}
    return [*found, *(Piece(name, "", kind) for name, kind in used.items())]


def crowded(outputs: Sized) -> bool:
    """Whether there is no room beside a fragment shader's outputs for a place and an input."""
    return len(outputs) + 2 > MOST_OUTPUTS


def may_keep_out(text: str) -> bool:
    """Whether a fragment shader may keep fragments from being written, or give them another depth.

    >>> may_keep_out("void main() { if (gl_FragCoord.x > 9.0) discard; }")
    True
    """
    return any(word in text for word in _KEEPS_OUT)


def changes_inputs(text: str) -> bool:
    """Whether a fragment shader may get other values than one that reads the same inputs: in a
    lower precision, or with window coordinates counted from elsewhere.

    >>> changes_inputs("layout(origin_upper_left) in vec4 gl_FragCoord;")
    True
    """
    return any(word in text for word in _OWN_READING)


def domain_vertex(text: str, inputs: Iterable[Variable]) -> str:
    """A vertex stage for one screen-filling triangle, feeding `inputs` as linear ramps.

    Each input takes three uniforms: shaderlab_NAME_origin, _dx and _dy; those of members of a
    block or a struct are members of one themselves (shaderlab_VS_OUT.FragPos_origin).

    Args:
        text: the fragment shader.
        inputs: what it reads.

    Raises:
        UnsupportedError: an input is an array.
    """
    variables = list(inputs)
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
        written.append(f"    {_given(name, text)} = {value};")
    declared = _outputs(text, variables)
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
    return "\n".join([version_line(text), *declared, *body, ""])


def probe_vertex(text: str, inputs: Iterable[Variable]) -> tuple[str, dict[Piece, str]]:
    """A vertex stage that puts vertex i on pixel i of a row-by-row target, feeding `inputs` from
    attributes: a point has one vertex, so nothing is interpolated.

    Returns:
        Its text, and the attribute of each piece.
    """
    variables = list(inputs)
    parts = [piece for variable in elements(variables) for piece in pieces(variable)]
    attributes = {piece: f"{PREFIX}in{i}" for i, piece in enumerate(parts)}
    declared = ["uniform ivec2 shaderlab_size;"]
    declared += [f"in {piece.type} {name};" for piece, name in attributes.items()]
    declared += _outputs(text, variables)
    body = [
        "void main() {",
        *(f"    {_given(p.name, text)}{p.path} = {name};" for p, name in attributes.items()),
        "    vec2 pixel = vec2(gl_VertexID % shaderlab_size.x, gl_VertexID / shaderlab_size.x);",
        "    gl_Position = vec4((pixel + 0.5) / vec2(shaderlab_size) * 2.0 - 1.0, 0.0, 1.0);",
        "    gl_PointSize = 1.0;",
        "}",
    ]
    return "\n".join([version_line(text), *declared, *body, ""]), attributes


def _outputs(text: str, variables: Sequence[Variable]) -> list[str]:
    """Declarations of outputs that fit a fragment shader's inputs; blocks and structs to the
    letter, as the stages must agree on them."""
    shader = Declared(text)
    lines: dict[str, None] = {}
    for variable in variables:
        name = variable.name
        block = shader.block_of(name)
        if block is not None:
            own = f"{PREFIX}to_{block.name}" if block.instance else ""
            lines[f"out {block.name} {{{block.body}}} {own}{block.array};"] = None
        elif "." in name:
            head = name.partition(".")[0].partition("[")[0]
            kind, array = shader.struct_of(name)
            lines[f"{shader.qualifiers(head)}out {kind} {head}{array};"] = None
        else:
            array = "" if variable.array is None else f"[{variable.array}]"
            given = shader.qualifiers(name) or _qualifier(variable)
            lines[f"{given}out {variable.type} {name}{array};"] = None
    structs = shader.structs() if any("." in v.name for v in variables) else []
    return [*structs, *lines]


def _given(name: str, text: str) -> str:
    """An input's name in the vertex stage that `_outputs` declares it in."""
    block = Declared(text).block_of(name)
    if block is None or not block.instance:
        return name
    return f"{PREFIX}to_{name}"


def capture_fragment(
    text: str, group: Sequence[Piece], unwanted: Mapping[str, Variable] | None = None
) -> tuple[str, list[CapturedInput]]:
    """A fragment shader, unchanged but for a new ending that writes what it got.

    The author's main is renamed and called, so `discard` and depth writes happen as before; then
    gl_FragCoord goes to shaderlab_coord and each piece to an output of its own. `unwanted`
    outputs become plain variables, to make room.
    """
    captured = [CapturedInput(piece, f"{PREFIX}out{i}") for i, piece in enumerate(group)]
    shader = Declared(text)
    for variable in (unwanted or {}).values():
        text = _demoted(text, variable)
    version = _VERSION.search(text)
    head, rest = ("", text) if version is None else (version.group(0), text[version.end() :])
    ending = ["", "#undef main", f"out vec4 {COORD};"]
    ending += [f"out {_padded_type(c.piece)} {c.output};" for c in captured]
    ending += ["void main() {", f"    {PREFIX}main();", f"    {COORD} = gl_FragCoord;"]
    ending += [f"    {c.output} = {_padded_value(c.piece, shader)};" for c in captured]
    return "\n".join([head, f"#define main {PREFIX}main", rest, *ending, "}", ""]), captured


def counting_vertex(text: str) -> str:
    """A vertex shader that also tells a geometry shader which instance it is of."""
    version = _VERSION.search(text)
    head, rest = ("", text) if version is None else (version.group(0), text[version.end() :])
    ending = ["", "#undef main", f"flat out int {PREFIX}instance;", "void main() {"]
    ending += [f"    {PREFIX}main();", f"    {PREFIX}instance = gl_InstanceID;", "}", ""]
    return "\n".join([head, f"#define main {PREFIX}main", rest, *ending])


EMITTED = {
    "gl_InstanceID": PREFIX + "of_instance",
    "gl_PrimitiveIDIn": PREFIX + "of_primitive",
    "emitted": PREFIX + "index",
}
"""What `counting_geometry` adds to each emitted vertex: where it comes from."""


def counting_geometry(text: str) -> str:
    """A geometry shader whose vertices also say which instance and primitive they were made of,
    and which of its vertices they are, counted from 0. It feeds on `counting_vertex`."""
    instance, primitive, index = EMITTED.values()
    added = [
        f"flat in int {PREFIX}instance[];",
        *(f"flat out int {name};" for name in EMITTED.values()),
        f"int {PREFIX}count = 0;",
        f"void {PREFIX}emit() {{",
        f"    {instance} = {PREFIX}instance[0];",
        f"    {primitive} = gl_PrimitiveIDIn;",
        f"    {index} = {PREFIX}count++;",
        "    EmitVertex();",
        "}",
        f"#define EmitVertex {PREFIX}emit",
        "",
    ]
    at = max((found.end() for found in _DIRECTIVE.finditer(text)), default=0)
    # The function needs the layout of the inputs' array, so it follows the author's own.
    layout = re.search(r"\blayout\s*\([^)]*\)\s*in\s*;", text[at:])
    at += layout.end() if layout else 0
    return text[:at] + "\n" + "\n".join(added) + text[at:]


def _demoted(text: str, variable: Variable) -> str:
    """The shader with one of its outputs made a plain variable."""
    name = re.escape(variable.name)
    pattern = rf"(?:layout\s*\([^)]*\)\s*)?\bout\s+((?:(?:high|medium|low)p\s+)?\w+\s+{name}\b)"
    changed, count = re.subn(pattern, r"\1", text)
    if count != 1:
        raise UnsupportedError(
            f"the declaration of the output {variable.name!r} can't be read, so there is no room "
            "to capture inputs beside all outputs",
            remedy="declare each output on its own (out Type name;)",
        )
    return changed


def _qualifier(variable: Variable) -> str:
    return "" if variable.interpolation == "smooth" else f"{variable.interpolation} "


def _padded_type(piece: Piece) -> str:
    return {"i": "ivec4", "u": "uvec4"}.get(piece.type[0], "vec4")


def _padded_value(piece: Piece, shader: Declared) -> str:
    size = int(piece.type[-1]) if piece.type[-1].isdigit() else 1
    value = f"{shader.spelt(piece.name)}{piece.path}"
    if piece.name == "gl_FrontFacing":
        value = "gl_FrontFacing ? 1.0 : 0.0"  # as an integer it is 0 on softpipe, in front too
    return f"{_padded_type(piece)}({value}{', 0' * (4 - size)})"
