"""Vertex stages that the lab writes itself: one lays a domain over the screen, one feeds a fragment
shader given inputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

from shaderlab.compiler.interface import Variable
from shaderlab.errors import UnsupportedError

from .stages import PREFIX, VERSION
from .varyings import Declared, Piece, elements, pieces


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
    variables, shader = sorted(inputs, key=lambda variable: variable.name), Declared(text)
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
        written.append(f"    {_given(name, shader)} = {value};")
    declared = _outputs(shader, variables)
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


@lru_cache(maxsize=256)
def probe_vertex(text: str, inputs: tuple[Variable, ...]) -> tuple[str, Mapping[Piece, str]]:
    """A vertex stage that puts vertex i on pixel i of a row-by-row target, feeding `inputs` from
    attributes: a point has one vertex, so nothing is interpolated.

    Returns:
        Its text, and the attribute of each piece.
    """
    shader = Declared(text)
    parts = [piece for variable in elements(inputs) for piece in pieces(variable)]
    attributes = {piece: f"{PREFIX}in{i}" for i, piece in enumerate(parts)}
    declared = ["uniform ivec2 shaderlab_size;"]
    declared += [f"in {piece.type} {name};" for piece, name in attributes.items()]
    declared += _outputs(shader, inputs)
    body = [
        "void main() {",
        *(f"    {_given(p.name, shader)}{p.path} = {name};" for p, name in attributes.items()),
        "    vec2 pixel = vec2(gl_VertexID % shaderlab_size.x, gl_VertexID / shaderlab_size.x);",
        "    gl_Position = vec4((pixel + 0.5) / vec2(shaderlab_size) * 2.0 - 1.0, 0.0, 1.0);",
        "    gl_PointSize = 1.0;",
        "}",
    ]
    return "\n".join([version_line(text), *declared, *body, ""]), attributes


def _outputs(shader: Declared, variables: Sequence[Variable]) -> list[str]:
    """Declarations of outputs that fit a fragment shader's inputs; blocks and structs to the
    letter, as the stages must agree on them."""
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
            own = "" if variable.interpolation == "smooth" else f"{variable.interpolation} "
            lines[f"{shader.qualifiers(name) or own}out {variable.type} {name}{array};"] = None
    structs = shader.structs() if any("." in v.name for v in variables) else []
    return [*structs, *lines]


def _given(name: str, shader: Declared) -> str:
    """An input's name in the vertex stage that `_outputs` declares it in."""
    block = shader.block_of(name)
    return f"{PREFIX}to_{name}" if block is not None and block.instance else name


def version_line(text: str) -> str:
    """A shader's own #version line, or the oldest that generated stages can be written in."""
    found = VERSION.search(text)
    return found.group(0).strip() if found else "#version 330 core"
