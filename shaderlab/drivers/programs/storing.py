"""Vertex and geometry shaders that also store each vertex that comes out in a buffer."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from shaderlab.model.frame import Array

from .formats import components_of, numpy_type
from .stages import EMITTED, PREFIX, VERSION, emits_points, with_ending
from .varyings import Declared, Piece

BLOCK = PREFIX + "Stored"
"""The storage block: of each vertex a word, 1 where it came out, and the words of its pieces."""
PER_INSTANCE = PREFIX + "per_instance"
"""The uniform that says how many vertices an instance has room for (int)."""
_EXTENSIONS = ("GL_ARB_shader_storage_buffer_object", "GL_ARB_shader_bit_encoding")
_EMITTED = "    EmitVertex();\n}\n#define EmitVertex"
_WORDS = {"f": "floatBitsToUint({})", "v": "floatBitsToUint({})", "i": "uint({})", "u": "{}"}
_FRAGMENT = "#version 330 core\nvoid main() {}\n"
_SIZE = PREFIX + "point_size"


def words_of(parts: Sequence[Piece]) -> int:
    """How many words a vertex takes."""
    return 1 + sum(components_of(piece.type) for piece in parts)


def storing(texts: Mapping[str, str], parts: Sequence[Piece], most: int) -> dict[str, str]:
    """A program whose last stage before rasterisation stores these pieces of each vertex.

    A vertex stage stores vertex v of instance i in place i · PER_INSTANCE + v. A geometry stage, as
    `stages.counting_geometry` makes it, stores vertex k of primitive p in place
    i · PER_INSTANCE + p · `most` + k.

    Args:
        texts: of the vertex stage, and of the geometry stage if there is one.
        parts: what is stored.
        most: how many vertices a geometry stage may emit of a primitive.
    """
    last = "geometry" if "geometry" in texts else "vertex"
    text = _extended(texts[last])
    stored = list(_stores(parts, Declared(texts[last], "out")))
    size = ["    gl_PointSize = 1.0;"] if last == "vertex" or emits_points(texts) else []
    if last == "vertex":
        place = f"gl_InstanceID * {PER_INSTANCE} + gl_VertexID"
        written = [_at(place, parts), *stored, *size]
        return {"vertex": with_ending(text, _declared(), written), "fragment": _FRAGMENT}
    instance, primitive, index = EMITTED.values()
    place = f"{instance} * {PER_INSTANCE} + {primitive} * {most} + {index}"
    # What is stored is declared further down than what emits.
    before, mark, after = text.partition(_EMITTED)
    head, _, body = before.rpartition(f"void {PREFIX}emit() {{")
    assert mark, "a geometry stage that counts"
    body = "\n".join([body.rstrip("\n"), f"    {PREFIX}store();", *size, ""])
    emitting = f"{head}void {PREFIX}store();\nvoid {PREFIX}emit() {{{body}{mark}"
    lines = [*_declared(), f"void {PREFIX}store() {{", _at(place, parts), *stored, "}", ""]
    return {
        "vertex": texts["vertex"],
        "geometry": "\n".join([emitting + after, *lines]),
        "fragment": _FRAGMENT,
    }


def restored(parts: Sequence[Piece], words: Array) -> dict[Piece, Array]:
    """The pieces of each vertex that came out, (vertices, components), of the words (uint32)."""
    sizes = [components_of(piece.type) for piece in parts]
    rows = words.reshape(-1, words_of(parts))
    rows = rows[rows[:, 0] == 1, 1:]
    columns = np.split(rows, np.cumsum(sizes)[:-1], axis=1)
    return {
        piece: np.ascontiguousarray(part).view(numpy_type(piece.type))
        for piece, part in zip(parts, columns, strict=True)
    }


def _declared() -> list[str]:
    block = f"layout(std430) buffer {BLOCK} {{ uint {PREFIX}words[]; }};"
    return [block, f"uniform int {PER_INSTANCE};"]


def _at(place: str, parts: Sequence[Piece]) -> str:
    return f"    uint at = uint({place}) * {words_of(parts)}u; {PREFIX}words[at] = 1u;"


def _extended(text: str) -> str:
    """The text with the extensions that storing takes, after its #version; a point's size is a
    variable of its own, which can be read."""
    version = VERSION.search(text)
    end = 0 if version is None else version.end()
    lines = "".join(f"\n#extension {name} : enable" for name in _EXTENSIONS)
    body = re.sub(r"\bgl_PointSize\b", _SIZE, text[end:])
    return f"{text[:end]}{lines}\nfloat {_SIZE};{body}"


def _stores(parts: Sequence[Piece], shader: Declared) -> Iterator[str]:
    at = 1
    for piece in parts:
        name = _SIZE if piece.name == "gl_PointSize" else shader.spelt(piece.name)
        count = components_of(piece.type)
        for component in range(count):
            one = f"{name}{piece.path}" + (f"[{component}]" if count > 1 else "")
            yield f"    {PREFIX}words[at + {at}u] = {_WORDS[piece.type[0]].format(one)};"
            at += 1
