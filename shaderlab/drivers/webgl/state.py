"""Setting WebGL2's fixed-function state from a `State`: all that it has, each time."""

from __future__ import annotations

from shaderlab.errors import UnsupportedError
from shaderlab.model.state import Blend, Depth, State, Stencil

from .device import Calls

_NO_DEPTH, _NO_STENCIL, _NO_BLEND = Depth(), Stencil(), Blend()


def check(state: State, *, samples: int, encodes: bool) -> None:
    """Raise UnsupportedError for what WebGL2 has not, though OpenGL has.

    Args:
        state: what a draw asks for.
        samples: of its target.
        encodes: whether the target has attachments of sRGB.
    """
    front, back = state.stencil or _NO_STENCIL, state.stencil_back or state.stencil or _NO_STENCIL
    for lacks, what in (
        (samples > 1 and not state.multisample,
         "multisample=False: WebGL2 covers the samples of a target always"),
        (state.sample_shading is not None, "sample_shading: WebGL2 shades pixels only"),
        (encodes and not state.srgb,
         "srgb=False: WebGL2 encodes whatever is drawn to attachments of sRGB"),
        (state.depth_range[0] > state.depth_range[1],
         "a depth_range from far to near: WebGL2 has none"),
        ((front.reference, front.mask, front.write_mask)
         != (back.reference, back.mask, back.write_mask),
         "stencil_back: in WebGL2 both faces have one reference and one mask"),
        (_mixes_constants(state.blend),
         "a factor of the constant colour with one of the constant alpha: WebGL2 has none"),
    ):  # fmt: skip
        if lacks:
            raise UnsupportedError(what)


def apply(gl: Calls, state: State, size: tuple[int, int]) -> None:
    """Make the context's state what `state` says, for a target of `size` pixels."""
    whole = (0, 0, *size)
    cell = None if state.cell is None else state.cell.rectangle(size)
    scissor = cell or state.scissor
    switches = {
        "SCISSOR_TEST": scissor is not None,
        "DEPTH_TEST": state.depth is not None,
        "POLYGON_OFFSET_FILL": state.polygon_offset is not None,
        "STENCIL_TEST": state.stencil is not None,
        "BLEND": state.blend is not None,
        "CULL_FACE": state.cull is not None,
        "SAMPLE_ALPHA_TO_COVERAGE": state.alpha_to_coverage,
        "RASTERIZER_DISCARD": False,
    }
    for capability, on in switches.items():
        (gl.enable if on else gl.disable)(getattr(gl, capability))
    gl.viewport(*(cell or state.viewport or whole))
    gl.scissor(*(scissor or whole))
    depth = state.depth or _NO_DEPTH
    gl.depthFunc(_named(gl, depth.func))
    gl.depthMask(depth.write)
    gl.depthRange(*state.depth_range)
    gl.polygonOffset(*(state.polygon_offset or (0.0, 0.0)))
    _stencil(gl, gl.FRONT, state.stencil or _NO_STENCIL)
    _stencil(gl, gl.BACK, state.stencil_back or state.stencil or _NO_STENCIL)
    _blend(gl, state.blend or _NO_BLEND)
    gl.cullFace(_named(gl, state.cull or "back"))
    gl.frontFace(_named(gl, state.front_face))
    gl.colorMask(*state.color_mask)


def _mixes_constants(blend: Blend | None) -> bool:
    factors = [] if blend is None else [blend.source, blend.destination]
    constants = {word.removeprefix("one_minus_") for word in factors}
    return constants == {"constant_color", "constant_alpha"}


def _stencil(gl: Calls, face: int, stencil: Stencil) -> None:
    gl.stencilFuncSeparate(face, _named(gl, stencil.func), stencil.reference, stencil.mask)
    operations = (stencil.fail, stencil.depth_fail, stencil.depth_pass)
    gl.stencilOpSeparate(face, *(_named(gl, word) for word in operations))
    gl.stencilMaskSeparate(face, stencil.write_mask)


def _blend(gl: Calls, blend: Blend) -> None:
    gl.blendFuncSeparate(
        _named(gl, blend.source),
        _named(gl, blend.destination),
        _named(gl, blend.source_alpha or blend.source),
        _named(gl, blend.destination_alpha or blend.destination),
    )
    gl.blendEquationSeparate(*(
        _named(gl, word if word in ("min", "max") else f"func_{word}")
        for word in (blend.equation, blend.equation_alpha or blend.equation)
    ))  # fmt: skip
    gl.blendColor(*blend.constant)


def _named(gl: Calls, word: str) -> int:
    return int(getattr(gl, word.upper()))
