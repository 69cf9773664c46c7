"""GLSL that the lab writes itself: text only, no device.

Three stages: one that lays a domain over the screen, one that runs a fragment shader on given
inputs, and an ending for a fragment shader that also writes down what it got. Names they add
start with `shaderlab_`, so that they can't meet an author's.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from shaderlab.glsl.spirv import Variable

PREFIX = "shaderlab_"
COORD = PREFIX + "coord"
_VERSION = re.compile(r"^[ \t]*#[ \t]*version[^\n]*", re.MULTILINE)


@dataclass(frozen=True)
class CapturedInput:
    """A fragment input and the extra output that holds it, padded to four components."""

    variable: Variable
    output: str

    @property
    def format(self) -> str:
        """The attachment format that holds it without loss."""
        kind = {"i": "rgba32i", "b": "rgba32i", "u": "rgba32ui"}
        return kind.get(self.variable.type[0], "rgba32f")


def version_line(text: str) -> str:
    """A shader's own #version line, or the oldest that generated stages can be written in."""
    found = _VERSION.search(text)
    return found.group(0).strip() if found else "#version 330 core"


def domain_vertex(version: str, inputs: Iterable[Variable]) -> str:
    """A vertex stage for one screen-filling triangle, feeding `inputs` as linear ramps.

    Each input takes three uniforms: shaderlab_NAME_origin, _dx and _dy.
    """
    declared, written = [], []
    for variable in inputs:
        name, kind = variable.name, variable.type
        declared.append(f"{_qualifier(variable)}out {kind} {name};")
        if kind[0] in "iu":
            declared.append(f"uniform {kind} {PREFIX}{name}_origin;")
            written.append(f"    {name} = {PREFIX}{name}_origin;")
            continue
        names = ", ".join(f"{PREFIX}{name}_{part}" for part in ("origin", "dx", "dy"))
        origin, dx, dy = names.split(", ")
        declared.append(f"uniform {kind} {names};")
        written.append(f"    {name} = {origin} + st.x * {dx} + st.y * {dy};")
    body = [
        "void main() {",
        "    vec2 st = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;",
        *written,
        "    gl_Position = vec4(st * 2.0 - 1.0, 0.0, 1.0);",
        "}",
    ]
    return "\n".join([version, *declared, *body, ""])


def probe_vertex(version: str, inputs: Iterable[Variable]) -> str:
    """A vertex stage that puts vertex i on pixel i of a row-by-row target, feeding `inputs`
    from attributes shaderlab_in_NAME: a point has one vertex, so nothing is interpolated."""
    declared, written = ["uniform ivec2 shaderlab_size;"], []
    for variable in inputs:
        name, kind = variable.name, variable.type
        declared.append(f"in {kind} {PREFIX}in_{name};")
        declared.append(f"{_qualifier(variable)}out {kind} {name};")
        written.append(f"    {name} = {PREFIX}in_{name};")
    body = [
        "void main() {",
        *written,
        "    vec2 pixel = vec2(gl_VertexID % shaderlab_size.x, gl_VertexID / shaderlab_size.x);",
        "    gl_Position = vec4((pixel + 0.5) / vec2(shaderlab_size) * 2.0 - 1.0, 0.0, 1.0);",
        "    gl_PointSize = 1.0;",
        "}",
    ]
    return "\n".join([version, *declared, *body, ""])


def capture_fragment(text: str, inputs: Sequence[Variable]) -> tuple[str, list[CapturedInput]]:
    """A fragment shader, unchanged but for a new ending that writes what it got.

    The author's main is renamed and called, so `discard` and depth writes happen as before; then
    gl_FragCoord goes to shaderlab_coord and each input to an output of its own.
    """
    captured = [CapturedInput(v, f"{PREFIX}out{i}") for i, v in enumerate(inputs)]
    version = _VERSION.search(text)
    head, rest = ("", text) if version is None else (version.group(0), text[version.end() :])
    ending = ["", "#undef main", f"out vec4 {COORD};"]
    ending += [f"out {_padded_type(c.variable)} {c.output};" for c in captured]
    ending += ["void main() {", f"    {PREFIX}main();", f"    {COORD} = gl_FragCoord;"]
    ending += [f"    {c.output} = {_padded_value(c.variable)};" for c in captured]
    return "\n".join([head, f"#define main {PREFIX}main", rest, *ending, "}", ""]), captured


def _qualifier(variable: Variable) -> str:
    return "" if variable.interpolation == "smooth" else f"{variable.interpolation} "


def _padded_type(variable: Variable) -> str:
    return {"i": "ivec4", "u": "uvec4"}.get(variable.type[0], "vec4")


def _padded_value(variable: Variable) -> str:
    size = variable.components
    zeros = ", 0" * (4 - size)
    return f"{_padded_type(variable)}({variable.name}{zeros})"
