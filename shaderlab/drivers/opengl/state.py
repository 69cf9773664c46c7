"""Setting OpenGL's fixed-function state from a `State`.

moderngl has no stencil, no separate write masks, no depth range and no constant blend colour, so
all of it is set through PyOpenGL on the same context. `apply` sets every state it knows, each time:
a draw gets exactly what it says, whatever ran before it.
"""

from __future__ import annotations

from shaderlab.errors import UnsupportedError
from shaderlab.model.state import Blend, Depth, State, Stencil

from .device import GL, named

_NO_DEPTH, _NO_STENCIL, _NO_BLEND = Depth(), Stencil(), Blend()


def apply(state: State, size: tuple[int, int], version: int) -> None:
    """Make the current context's state what `state` says, for a target of `size` pixels.

    `version` is the context's OpenGL version: 450 for 4.5.
    """
    whole = (0, 0, *size)
    cell = None if state.cell is None else state.cell.rectangle(size)
    scissor = cell or state.scissor
    switches = {
        GL.GL_SCISSOR_TEST: scissor is not None,
        GL.GL_DEPTH_TEST: state.depth is not None,
        GL.GL_POLYGON_OFFSET_FILL: state.polygon_offset is not None,
        GL.GL_POLYGON_OFFSET_LINE: state.polygon_offset is not None,
        GL.GL_STENCIL_TEST: state.stencil is not None,
        GL.GL_BLEND: state.blend is not None,
        GL.GL_CULL_FACE: state.cull is not None,
        GL.GL_FRAMEBUFFER_SRGB: state.srgb,
        GL.GL_PROGRAM_POINT_SIZE: isinstance(state.point_size, str),
        GL.GL_MULTISAMPLE: state.multisample,
        GL.GL_SAMPLE_ALPHA_TO_COVERAGE: state.alpha_to_coverage,
    }
    if version >= 400:
        switches[GL.GL_SAMPLE_SHADING] = state.sample_shading is not None
        GL.glMinSampleShading(state.sample_shading or 0.0)
    elif state.sample_shading is not None:
        raise UnsupportedError("shading each sample (sample_shading): it takes OpenGL 4.0")
    for capability, on in switches.items():
        (GL.glEnable if on else GL.glDisable)(capability)
    GL.glViewport(*(cell or state.viewport or whole))
    GL.glScissor(*(scissor or whole))
    depth = state.depth or _NO_DEPTH
    GL.glDepthFunc(named(depth.func))
    GL.glDepthMask(depth.write)
    GL.glDepthRange(*state.depth_range)
    GL.glPolygonOffset(*(state.polygon_offset or (0.0, 0.0)))
    _stencil(GL.GL_FRONT, state.stencil or _NO_STENCIL)
    _stencil(GL.GL_BACK, state.stencil_back or state.stencil or _NO_STENCIL)
    _blend(state.blend or _NO_BLEND)
    GL.glCullFace(named(state.cull or "back"))
    GL.glFrontFace(named(state.front_face))
    GL.glColorMask(*state.color_mask)
    GL.glPointSize(state.point_size if isinstance(state.point_size, int | float) else 1.0)


def _stencil(face: int, stencil: Stencil) -> None:
    GL.glStencilFuncSeparate(face, named(stencil.func), stencil.reference, stencil.mask)
    operations = (stencil.fail, stencil.depth_fail, stencil.depth_pass)
    GL.glStencilOpSeparate(face, *(named(word) for word in operations))
    GL.glStencilMaskSeparate(face, stencil.write_mask)


def _blend(blend: Blend) -> None:
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
