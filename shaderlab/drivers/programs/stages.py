"""Shaders that also write down what they got: an author's text with another ending.

Names that the lab adds start with `shaderlab_`, so that they can't meet an author's.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence, Sized

from shaderlab.compiler.interface import Variable
from shaderlab.errors import UnsupportedError

from .varyings import Declared, Piece, elements, pieces

PREFIX = "shaderlab_"
COORD = PREFIX + "coord"
# A draw's number in its pass: the uniform that has it, and the output that it goes to.
NUMBER = PREFIX + "draw"
NUMBERED = PREFIX + "drawn"
VERSION = re.compile(r"^[ \t]*#[ \t]*version[^\n]*", re.MULTILINE)
_DIRECTIVE = re.compile(r"^[ \t]*#[ \t]*(?:version|extension)[^\n]*\n?", re.MULTILINE)
MOST_OUTPUTS = 8
_POINTS_OUT = re.compile(r"\blayout\s*\([^)]*\bpoints\b[^)]*\)\s*out\b")
_MAY_KEEP_OUT = ("discard", "gl_FragDepth", "gl_SampleMask")
# Words that change the value of an input, or of gl_FragCoord, in the shader that has them.
_CHANGE_INPUTS = ("mediump", "lowp", "origin_upper_left", "pixel_center_integer")
_BUILT_IN = {"gl_FrontFacing": "float", "gl_PointCoord": "vec2", "gl_PrimitiveID": "int"}


def after_directives(text: str) -> int:
    """Where a text goes on behind its last #version or #extension."""
    return max((found.end() for found in _DIRECTIVE.finditer(text)), default=0)


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
    """Whether a fragment shader may discard fragments, or change their depth or coverage.

    >>> may_keep_out("void main() { if (gl_FragCoord.x > 9.0) discard; }")
    True
    """
    return any(word in text for word in _MAY_KEEP_OUT)


def may_discard(text: str) -> bool:
    """Whether a fragment shader may discard fragments."""
    return "discard" in text


def writes_depth(text: str) -> bool:
    """Whether a fragment shader may give fragments another depth."""
    return "gl_FragDepth" in text


def changes_inputs(text: str) -> bool:
    """Whether a fragment shader may get other values than another one of the same inputs: in lower
    precision, or with another origin of window coordinates.

    >>> changes_inputs("layout(origin_upper_left) in vec4 gl_FragCoord;")
    True
    """
    return any(word in text for word in _CHANGE_INPUTS)


def capture_fragment(
    text: str,
    group: Sequence[Piece],
    unwanted: Mapping[str, Variable] | None = None,
    *,
    keep_all: bool = False,
    calls: bool = False,
    numbered: bool = False,
) -> tuple[str, dict[Piece, str]]:
    """A fragment shader, unchanged but for a new ending that writes what it got.

    The author's main is renamed; then gl_FragCoord goes to shaderlab_coord and each piece to an
    output of its own. It is called where it may keep fragments out, so that `discard` and depth
    writes happen as before, and where a caller wants what it writes.

    Args:
        text: the shader's.
        group: what is written of its inputs.
        unwanted: outputs that become plain variables, to make room.
        keep_all: whether every fragment is kept, with the depth that it comes with: the author's
            main is not called then.
        calls: whether the author's main is called in any case.
        numbered: whether the uniform NUMBER, the draw's number, goes to the output NUMBERED.

    Returns:
        Its text, and the output of each piece, of the type `padded_type`.
    """
    captured = {piece: f"{PREFIX}out{i}" for i, piece in enumerate(group)}
    shader = Declared(text)
    calls = not keep_all and (calls or may_keep_out(text))
    for variable in (unwanted or {}).values():
        text = _demoted(text, variable)
    declared = [f"out vec4 {COORD};"]
    declared += [f"out {padded_type(piece)} {name};" for piece, name in captured.items()]
    written = [f"    {COORD} = gl_FragCoord;"]
    written += [f"    {name} = {_padded_value(p, shader)};" for p, name in captured.items()]
    if numbered:
        declared += [f"uniform float {NUMBER};", f"out float {NUMBERED};"]
        written.append(f"    {NUMBERED} = {NUMBER};")
    if keep_all and writes_depth(text):  # what names it has to write it
        written.append("    gl_FragDepth = gl_FragCoord.z;")
    return with_ending(text, declared, written, calls=calls), captured


def capture_vertex(text: str, group: Sequence[Piece]) -> tuple[str, dict[Piece, str]]:
    """A vertex shader that also writes some of its outputs, each to an output of its own.

    Returns:
        Its text, and the output of each piece, of the type `padded_type`.
    """
    captured = {piece: f"{PREFIX}out{i}" for i, piece in enumerate(group)}
    shader = Declared(text, "out")
    declared = [f"flat out {padded_type(piece)} {name};" for piece, name in captured.items()]
    written = [f"    {name} = {_padded_value(p, shader)};" for p, name in captured.items()]
    return with_ending(text, declared, written), captured


_OFF_SCREEN = (
    "    if (any(greaterThan(abs(gl_Position.xyz), vec3(gl_Position.w))))",
    "        gl_Position = vec4(64.0, 64.0, 0.0, 1.0);",
)


def drawing_points(text: str, size: float | None) -> str:
    """The last stage of a program that draws points, which drops those whose middle is outside of
    the clip volume.

    Args:
        text: a vertex or a geometry shader.
        size: a point's size in pixels, whatever the shader writes; None leaves that to it.
    """
    lines = [*([] if size is None else [f"    gl_PointSize = {size!r};"]), *_OFF_SCREEN]
    return _emitting(text, lines, []) if "EmitVertex" in text else with_ending(text, [], lines)


def counting_vertex(text: str) -> str:
    """A vertex shader that also tells a geometry shader which instance it is of."""
    return with_ending(
        text, [f"flat out int {PREFIX}instance;"], [f"    {PREFIX}instance = gl_InstanceID;"]
    )


def emits_points(texts: Mapping[str, str]) -> bool:
    """Whether a program has a geometry stage that makes points."""
    return bool(_POINTS_OUT.search(texts.get("geometry", "")))


def with_ending(
    text: str, declared: Sequence[str], written: Sequence[str], *, calls: bool = True
) -> str:
    """The author's main renamed, and one that calls it (or not) and goes on with `written`."""
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
"""What `counting_geometry` adds to each emitted vertex: where it comes from."""


def counting_geometry(text: str) -> str:
    """A geometry shader whose vertices also say which instance and primitive they were made of,
    and which of its vertices they are, counted from 0. It feeds on `counting_vertex`."""
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
    return _emitting(text, written, declared)


def _emitting(text: str, written: Sequence[str], declared: Sequence[str]) -> str:
    """A geometry shader that does something more as it emits each vertex."""
    added = [
        *declared,
        f"void {PREFIX}emit() {{",
        *written,
        "    EmitVertex();",
        "}",
        f"#define EmitVertex {PREFIX}emit",
        "",
    ]
    at = after_directives(text)
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


def padded_type(piece: Piece) -> str:
    """The type of four components that holds a piece: the renderable formats have no three."""
    return {"i": "ivec4", "u": "uvec4"}.get(piece.type[0], "vec4")


def _padded_value(piece: Piece, shader: Declared) -> str:
    size = int(piece.type[-1]) if piece.type[-1].isdigit() else 1
    value = f"{shader.spelt(piece.name)}{piece.path}"
    if piece.name == "gl_FrontFacing":
        value = "gl_FrontFacing ? 1.0 : 0.0"  # as an integer it is 0 on softpipe, in front too
    return f"{padded_type(piece)}({value}{', 0' * (4 - size)})"
