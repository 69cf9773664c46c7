"""What vertices come out of the last stage before rasterisation, by transform feedback."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from shaderlab.errors import DriverError, ShaderError
from shaderlab.model.frame import Array, Bindings
from shaderlab.model.scene import Target

from ..programs import tessellation
from ..programs.formats import components_of, numpy_type
from ..programs.prepare import PreparedDraw
from ..programs.varyings import Piece
from .drawing import Drawing, drain_errors, submit
from .pyopengl import GL, named
from .target import RenderTarget
from .vertices import vertex_array

# What every OpenGL 3.3 driver can write of one vertex at once.
MAX_COMPONENTS = 64
UNDEFINED = np.uint32(0xFFFFFFFF)
"""The bits of an output that nothing writes: NaN in floats, −1 and the largest number in others."""


def vertex_outputs(
    drawing: Drawing,
    draw: PreparedDraw,
    texts: Mapping[str, str],
    parts: Sequence[Piece],
    bindings: Bindings,
    count: int | None,
) -> dict[Piece, Array]:
    """As `PassSession.vertex_outputs`, by transform feedback; without a `count` the
    driver is asked first.

    Raises:
        DriverError: the driver writes down fewer vertices than it says there are.
    """
    found: dict[Piece, Array] = {}
    written = _written(drawing, texts, parts)
    for group in _groups([piece for piece in parts if piece.name in written]):
        sizes = [components_of(piece.type) for piece in group]
        names = tuple(dict.fromkeys(piece.name for piece in group))
        program = drawing.linker.link(texts, feedback=names)
        mode = _mode(program, texts)
        if count is None:
            count, _ = _draw(drawing, draw, program, mode, bindings, 1, 4 * sum(sizes))
        _, data = _draw(drawing, draw, program, mode, bindings, count, 4 * sum(sizes))
        raw = np.frombuffer(data, np.float32).reshape(count, sum(sizes))
        columns = np.split(raw, np.cumsum(sizes)[:-1], axis=1)
        for piece, part in zip(group, columns, strict=True):
            found[piece] = np.ascontiguousarray(part).view(numpy_type(piece.type))
    undefined = {p: np.full((count or 0, components_of(p.type)), UNDEFINED) for p in parts}
    return {p: found.get(p, u.view(numpy_type(p.type))) for p, u in undefined.items()}


def _written(drawing: Drawing, texts: Mapping[str, str], parts: Sequence[Piece]) -> set[str]:
    """The names of those outputs that the program has. A driver may drop one that is declared and
    never written, and then refuses to capture it.

    Raises:
        ShaderError: it refuses the program as well if nothing is captured.
    """
    names = dict.fromkeys(piece.name for piece in parts)
    try:
        for group in _groups(parts):
            drawing.linker.link(texts, feedback=tuple(dict.fromkeys(p.name for p in group)))
        return set(names)
    except ShaderError:
        drawing.linker.link(texts)
    return {name for name in names if _is_linked(drawing, texts, name)}


def _is_linked(drawing: Drawing, texts: Mapping[str, str], name: str) -> bool:
    try:
        drawing.linker.link(texts, feedback=(name,))
    except ShaderError:
        return False
    return True


def _groups(parts: Sequence[Piece]) -> list[list[Piece]]:
    """The pieces in groups that are captured at once; a matrix stays together."""
    groups: list[list[Piece]] = [[]]
    room = MAX_COMPONENTS
    for name in dict.fromkeys(piece.name for piece in parts):
        own = [piece for piece in parts if piece.name == name]
        size = sum(components_of(piece.type) for piece in own)
        if size > room:
            groups.append([])
            room = MAX_COMPONENTS
        groups[-1].extend(own)
        room -= size
    return groups


def _mode(program: Any, texts: Mapping[str, str]) -> int:
    """The primitives that come out of the last stage; strips as the single ones of them."""
    if "tess_evaluation" in texts:
        return named(tessellation.primitive(texts["tess_evaluation"]))
    return int(program.geometry_output or GL.GL_POINTS)


def _draw(
    drawing: Drawing, draw: PreparedDraw, program: Any, mode: int, bindings: Bindings,
    room: int, stride: int,
) -> tuple[int, bytes]:  # fmt: skip
    """Draw into a buffer with room for so many vertices of `stride` bytes: how many there would
    have been, and what was written.

    Raises:
        DriverError: the buffer is large enough, but less was written.
    """
    corner_count = {GL.GL_LINES: 2, GL.GL_TRIANGLES: 3}.get(mode, 1)
    device = drawing.device
    # Transform feedback without a complete framebuffer returns zeros without an error.
    target = RenderTarget(device, Target(), {"unused": "r8"}, (1, 1))
    buffer = device.context.buffer(reserve=max(room * stride, 4))
    queries = np.atleast_1d(GL.glGenQueries(2))
    try:
        target.clear()
        drawing.use(program, draw, bindings)
        vao = vertex_array(device, program, draw.draw.mesh)
        GL.glUseProgram(program.glo)
        GL.glBindBufferBase(GL.GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffer.glo)
        GL.glEnable(GL.GL_RASTERIZER_DISCARD)
        GL.glBeginQuery(GL.GL_PRIMITIVES_GENERATED, queries[0])
        GL.glBeginQuery(GL.GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, queries[1])
        GL.glBeginTransformFeedback(mode)
        submit(vao, program, replace(draw, draw=replace(draw.draw, vertex_array=True)))
        GL.glEndTransformFeedback()
        GL.glEndQuery(GL.GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN)
        GL.glEndQuery(GL.GL_PRIMITIVES_GENERATED)
        generated, written = (
            int(GL.glGetQueryObjectuiv(query, GL.GL_QUERY_RESULT)) for query in queries
        )
        drain_errors()
        data = buffer.read(room * stride) if room else b""
    finally:
        GL.glDisable(GL.GL_RASTERIZER_DISCARD)
        GL.glBindBufferBase(GL.GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0)
        GL.glDeleteQueries(2, queries)
        buffer.release()
        target.release()
    if written < generated and generated * corner_count <= room:
        raise DriverError(f"transform feedback wrote {written} of {generated} primitives")
    return generated * corner_count, data
