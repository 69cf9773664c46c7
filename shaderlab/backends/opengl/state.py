"""Setting OpenGL's fixed-function state from a `State`.

moderngl has no stencil, no separate write masks, no depth range and no constant blend colour, so
all of it is set through PyOpenGL on the same context. `apply` sets every state it knows, each time:
a draw gets exactly what it says, whatever ran before it.
"""

from __future__ import annotations

from shaderlab.backends.opengl.pyopengl import GL, named
from shaderlab.errors import UnsupportedError
from shaderlab.model import Blend, Cell, Depth, State, Stencil


def apply(state: State, size: tuple[int, int]) -> None:
    """Make the current context's state what `state` says, for a target of `size` pixels."""
    _confine(state, size)
    _depth(state.depth)
    GL.glDepthRange(*state.depth_range)
    _polygon_offset(state.polygon_offset)
    _stencil(state.stencil, state.stencil_back or state.stencil)
    _blend(state.blend)
    _switch(GL.GL_CULL_FACE, state.cull is not None)
    if state.cull is not None:
        GL.glCullFace(named(state.cull))
    GL.glFrontFace(named(state.front_face))
    GL.glColorMask(*state.color_mask)
    _switch(GL.GL_FRAMEBUFFER_SRGB, state.srgb)
    _switch(GL.GL_PROGRAM_POINT_SIZE, isinstance(state.point_size, str))
    GL.glPointSize(state.point_size if isinstance(state.point_size, int | float) else 1.0)
    _multisample(state)


def rectangle(cell: Cell, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """The cell's pixels as (x, y, width, height); neighbouring cells share no pixel and no gap.

    >>> rectangle(Cell(column=1, row=0, columns=3, rows=8), (64, 64))
    (21, 0, 21, 8)
    """
    x, right = (size[0] * k // cell.columns for k in (cell.column, cell.column + 1))
    y, top = (size[1] * k // cell.rows for k in (cell.row, cell.row + 1))
    return x, y, right - x, top - y


def _switch(capability: int, on: bool) -> None:
    (GL.glEnable if on else GL.glDisable)(capability)


def _confine(state: State, size: tuple[int, int]) -> None:
    whole = (0, 0, *size)
    cell = None if state.cell is None else rectangle(state.cell, size)
    scissor = state.scissor if cell is None else cell
    GL.glViewport(*(cell or state.viewport or whole))
    GL.glScissor(*(scissor or whole))
    _switch(GL.GL_SCISSOR_TEST, scissor is not None)


def _depth(depth: Depth | None) -> None:
    _switch(GL.GL_DEPTH_TEST, depth is not None)
    if depth is not None:
        GL.glDepthFunc(named(depth.func))
    GL.glDepthMask(depth is None or depth.write)


def _polygon_offset(offset: tuple[float, float] | None) -> None:
    for primitive in (GL.GL_POLYGON_OFFSET_FILL, GL.GL_POLYGON_OFFSET_LINE):
        _switch(primitive, offset is not None)
    GL.glPolygonOffset(*(offset or (0.0, 0.0)))


def _stencil(front: Stencil | None, back: Stencil | None) -> None:
    _switch(GL.GL_STENCIL_TEST, front is not None)
    for face, stencil in ((GL.GL_FRONT, front), (GL.GL_BACK, back)):
        if stencil is None:
            GL.glStencilMaskSeparate(face, 0xFF)
            continue
        func = named(stencil.func)
        GL.glStencilFuncSeparate(face, func, stencil.reference, stencil.mask)
        operations = (stencil.fail, stencil.depth_fail, stencil.depth_pass)
        GL.glStencilOpSeparate(face, *(named(word) for word in operations))
        GL.glStencilMaskSeparate(face, stencil.write_mask)


def _multisample(state: State) -> None:
    _switch(GL.GL_MULTISAMPLE, state.multisample)
    _switch(GL.GL_SAMPLE_ALPHA_TO_COVERAGE, state.alpha_to_coverage)
    if int(GL.glGetIntegerv(GL.GL_MAJOR_VERSION)) < 4:
        if state.sample_shading is not None:
            raise UnsupportedError("shading each sample (sample_shading): it takes OpenGL 4.0")
        return
    _switch(GL.GL_SAMPLE_SHADING, state.sample_shading is not None)
    GL.glMinSampleShading(state.sample_shading or 0.0)


def _blend(blend: Blend | None) -> None:
    _switch(GL.GL_BLEND, blend is not None)
    if blend is None:
        return
    GL.glBlendFuncSeparate(
        named(blend.source),
        named(blend.destination),
        named(blend.source_alpha or blend.source),
        named(blend.destination_alpha or blend.destination),
    )
    for_color, for_alpha = (
        named(word if word in ("min", "max") else f"func_{word}")
        for word in (blend.equation, blend.equation_alpha or blend.equation)
    )
    GL.glBlendEquationSeparate(for_color, for_alpha)
    GL.glBlendColor(*blend.constant)
