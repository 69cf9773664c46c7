"""What vertices come out of a vertex stage, by transform feedback."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from shaderlab.errors import DriverError
from shaderlab.model.frame import Array, Bindings

from ..programs import stages
from ..programs.formats import components_of, numpy_type
from ..programs.prepare import PreparedDraw
from ..programs.varyings import Piece
from .calls import Objects, decoded
from .drawing import Drawing
from .linking import Program
from .vertices import VertexArray

_AT_ONCE = 8  # vectors; every device captures 16, and some of those are the author's own
_CHANNELS = 4
_FRAGMENT = "#version 330 core\nvoid main() {}\n"


def vertex_outputs(
    drawing: Drawing,
    draw: PreparedDraw,
    texts: Mapping[str, str],
    parts: Sequence[Piece],
    bindings: Bindings,
    count: int | None,
) -> Mapping[Piece, Array]:
    """As `PassSession.vertex_outputs`, by transform feedback."""
    assert count is not None, "without a geometry stage it is known"
    found: dict[Piece, Array] = {}
    for start in range(0, len(parts), _AT_ONCE):
        group = parts[start : start + _AT_ONCE]
        text, names = stages.capture_vertex(texts["vertex"], group)
        program = drawing.linker.link(
            {**texts, "vertex": text, "fragment": _FRAGMENT}, feedback=tuple(names.values())
        )
        raw = _fed(drawing, draw, program, bindings, 4 * _CHANNELS * len(group) * count)
        rows = raw.reshape(count, len(group), _CHANNELS)
        for number, piece in enumerate(group):
            part = np.ascontiguousarray(rows[:, number, : components_of(piece.type)])
            found[piece] = part.view(numpy_type(piece.type))
    return found


def _fed(
    drawing: Drawing, draw: PreparedDraw, program: Program, bindings: Bindings, size: int
) -> Array:
    """The floats, of so many bytes, that a draw's vertices leave in a buffer.

    Raises:
        DriverError: a call that this takes raises an error.
    """
    gl = drawing.device.gl
    with Objects(gl) as own:
        buffer = own.new("Buffer")

        def feed(vertices: VertexArray) -> None:
            gl.bindFramebuffer(gl.FRAMEBUFFER, None)
            gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, buffer)
            gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, bytes(size), gl.STREAM_READ)
            gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, buffer)
            gl.enable(gl.RASTERIZER_DISCARD)
            gl.beginTransformFeedback(gl.POINTS)
            vertices.draw(gl, draw.draw.instances)
            gl.endTransformFeedback()
            gl.disable(gl.RASTERIZER_DISCARD)

        drawing.use(program, draw, bindings, {}, feed)
        data, errors = gl.ask_all([("contents", gl.TRANSFORM_FEEDBACK_BUFFER, size), ("errors",)])
        gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, None)
    if errors:
        raise DriverError(f"capturing vertices: WebGL2 raised {', '.join(map(hex, errors))}")
    return decoded(data, np.float32)
