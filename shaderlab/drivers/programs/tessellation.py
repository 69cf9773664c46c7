"""Tessellation evaluation shaders that also pass on what they got, to be captured."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from shaderlab.compiler.interface import Interface
from shaderlab.compiler.text import without_comments

from .formats import components_of
from .stages import PREFIX, with_ending
from .varyings import Declared, Piece, elements, pieces

_LEVELS = (
    *(f"gl_TessLevelOuter[{n}]" for n in range(4)),
    *(f"gl_TessLevelInner[{n}]" for n in range(2)),
)
# Of the 128 components that an evaluation stage may have for outputs at least (OpenGL 4.5, table
# 23.57), what is left to the author's own.
_ROOM = 64


def primitive(text: str) -> str:
    """What an evaluation shader's patches are divided into: "points", "lines" or "triangles".

    >>> primitive("layout (quads, equal_spacing) in;")
    'triangles'
    """
    inputs = " ".join(re.findall(r"\blayout\s*\(([^)]*)\)\s*in\s*;", without_comments(text)))
    if re.search(r"\bpoint_mode\b", inputs):
        return "points"
    return "lines" if re.search(r"\bisolines\b", inputs) else "triangles"


def controlled(interface: Interface) -> Iterator[Piece]:
    """What a control stage makes of a patch, as the evaluation stage calls it: the levels, and what
    it gives of each vertex and of the whole."""
    yield from (Piece(name, "", "float") for name in _LEVELS)
    count = interface.patch_vertices
    yield from (Piece(f"gl_in[{n}].gl_Position", "", "vec4") for n in range(count))
    for variable in elements(interface.evaluation_inputs.values()):
        vertex = re.match(r"\w+\[(\d+)\]", variable.name)
        if variable.patch or vertex is None or int(vertex.group(1)) < count:
            yield from pieces(variable)


def groups(interface: Interface) -> Iterator[list[Piece]]:
    """All that an evaluation shader gets, in groups that are passed on at once: where it is in
    which patch, and what the control stage made of that."""
    group = [Piece("gl_TessCoord", "", "vec3"), Piece("gl_PrimitiveID", "", "int")]
    room = _ROOM - 4
    for piece in controlled(interface):
        size = components_of(piece.type)
        if size > room:
            yield group
            group, room = [], _ROOM
        group.append(piece)
        room -= size
    yield group


def copying(text: str, group: Sequence[Piece]) -> tuple[str, Mapping[Piece, Piece]]:
    """An evaluation shader that also passes on some of its inputs, and the output that each is."""
    shader = Declared(text)
    copies = {
        piece: Piece(f"{PREFIX}in{number}", "", piece.type) for number, piece in enumerate(group)
    }
    flat = {"i": "flat ", "u": "flat "}
    declared = [f"{flat.get(c.type[0], '')}out {c.type} {c.name};" for c in copies.values()]
    written = [f"    {c.name} = {shader.spelt(p.name)}{p.path};" for p, c in copies.items()]
    return with_ending(text, declared, written), copies
