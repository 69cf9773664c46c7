"""Writing down vertices by transform feedback: linking, room for them, and reading them back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from shaderlab.backends.opengl import state as fixed
from shaderlab.backends.opengl.drawing import Drawing, drain_errors, submit
from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.backends.opengl.target import RenderTarget
from shaderlab.backends.opengl.vertices import vertex_array
from shaderlab.errors import DriverError
from shaderlab.frame import Array, Bindings
from shaderlab.model import State, Target
from shaderlab.programs.formats import components_of, numpy_type
from shaderlab.programs.prepare import PreparedDraw
from shaderlab.programs.varyings import Piece

# What every OpenGL 3.3 driver can write of one vertex at once.
MAX_COMPONENTS = 64

Run = tuple[Any, int, int]
"""A linked program, how it is drawn, and how many vertices it gives a primitive."""


def recorded(
    drawing: Drawing,
    draw: PreparedDraw,
    texts: Mapping[str, str],
    parts: Sequence[Piece],
    bindings: Bindings,
    count: int | None,
) -> dict[Piece, Array]:
    """The pieces of each vertex that comes out, (vertices, components).

    `count` is how many vertices come out; None asks the driver first.
    """
    found: dict[Piece, Array] = {}
    for group in _groups(parts):
        wholes = list(dict.fromkeys(piece.name for piece in group))
        sizes = [components_of(piece.type) for piece in group]
        run = _linked(drawing, texts, wholes, draw)
        if count is None:
            count, _ = _written(drawing, draw, run, bindings, 1, 4 * sum(sizes))
        _, data = _written(drawing, draw, run, bindings, count, 4 * sum(sizes))
        raw = np.frombuffer(data, np.float32).reshape(count, sum(sizes))
        columns = np.split(raw, np.cumsum(sizes)[:-1], axis=1)
        for piece, part in zip(group, columns, strict=True):
            found[piece] = np.ascontiguousarray(part).view(numpy_type(piece.type))
    return found


def _groups(parts: Sequence[Piece]) -> list[list[Piece]]:
    """The pieces in groups that are written at once; a matrix stays together."""
    groups: list[list[Piece]] = [[]]
    sizes: dict[str, int] = {}
    for piece in parts:
        sizes[piece.name] = sizes.get(piece.name, 0) + components_of(piece.type)
    room = MAX_COMPONENTS
    for name, size in sizes.items():
        if size > room:
            groups.append([])
            room = MAX_COMPONENTS
        groups[-1].extend(piece for piece in parts if piece.name == name)
        room -= size
    return groups


def _linked(
    drawing: Drawing, texts: Mapping[str, str], names: Sequence[str], draw: PreparedDraw
) -> Run:
    program = drawing.linker.link(texts, feedback=tuple(names))
    mode = GL.GL_POINTS
    if "geometry" in texts:
        kind = int(GL.glGetProgramiv(program.glo, GL.GL_GEOMETRY_OUTPUT_TYPE))
        mode = {GL.GL_LINE_STRIP: GL.GL_LINES, GL.GL_TRIANGLE_STRIP: GL.GL_TRIANGLES}.get(
            kind, GL.GL_POINTS
        )
    return program, int(mode), {GL.GL_LINES: 2, GL.GL_TRIANGLES: 3}.get(mode, 1)


def _written(
    drawing: Drawing, draw: PreparedDraw, run: Run, bindings: Bindings, room: int, stride: int
) -> tuple[int, bytes]:
    """Draw into a buffer with room for so many vertices of `stride` bytes: how many there would
    have been, and what was written.

    Raises:
        DriverError: the buffer is large enough, but less was written.
    """
    program, mode, corner_count = run
    device = drawing.device
    # Transform feedback without a complete framebuffer returns zeros without an error.
    target = RenderTarget(device, Target(), {"unused": "r8"}, (1, 1))
    buffer = device.context.buffer(reserve=max(room * stride, 4))
    queries = np.atleast_1d(GL.glGenQueries(2))
    try:
        target.clear()
        fixed.apply(State(), (1, 1))
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
