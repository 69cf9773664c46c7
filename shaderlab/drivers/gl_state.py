"""Fixed-function state and samplers as the calls that OpenGL and WebGL2 have in common: the name of
a function without "gl", then its arguments, constants by their names in lower case."""

from collections.abc import Iterator, Mapping
from typing import Any

from shaderlab.model.state import Blend, Depth, State, Stencil
from shaderlab.model.textures import Sampling

_NO_DEPTH, _NO_STENCIL, _NO_BLEND = Depth(), Stencil(), Blend()


def state_calls(
    state: State, size: tuple[int, int], switches: Mapping[str, bool]
) -> Iterator[tuple[Any, ...]]:
    """Yield the calls that make a context's state what `state` says, for a target of `size` pixels;
    `switches` are what one of the two has besides to be enabled or disabled."""
    whole = (0, 0, *size)
    cell = None if state.cell is None else state.cell.rectangle(size)
    scissor = cell or state.scissor
    for word, on in {
        "scissor_test": scissor is not None,
        "depth_test": state.depth is not None,
        "polygon_offset_fill": state.polygon_offset is not None,
        "stencil_test": state.stencil is not None,
        "blend": state.blend is not None,
        "cull_face": state.cull is not None,
        "sample_alpha_to_coverage": state.alpha_to_coverage,
        **switches,
    }.items():
        yield "Enable" if on else "Disable", word
    yield "Viewport", *(cell or state.viewport or whole)
    yield "Scissor", *(scissor or whole)
    depth = state.depth or _NO_DEPTH
    yield "DepthFunc", depth.func
    yield "DepthMask", depth.write
    yield "DepthRange", *state.depth_range
    yield "PolygonOffset", *(state.polygon_offset or (0.0, 0.0))
    front = state.stencil or _NO_STENCIL
    for face, stencil in (("front", front), ("back", state.stencil_back or front)):
        yield "StencilFuncSeparate", face, stencil.func, stencil.reference, stencil.mask
        yield "StencilOpSeparate", face, stencil.fail, stencil.depth_fail, stencil.depth_pass
        yield "StencilMaskSeparate", face, stencil.write_mask
    blend = state.blend or _NO_BLEND
    colors = (blend.source, blend.destination)
    alphas = (blend.source_alpha, blend.destination_alpha)
    own = (alpha or color for alpha, color in zip(alphas, colors, strict=True))
    yield "BlendFuncSeparate", *colors, *own
    equations = (blend.equation, blend.equation_alpha or blend.equation)
    words = (word if word in ("min", "max") else f"func_{word}" for word in equations)
    yield "BlendEquationSeparate", *words
    yield "BlendColor", *blend.constant
    yield "CullFace", state.cull or "back"
    yield "FrontFace", state.front_face
    yield "ColorMask", *state.color_mask


def sampler_calls(made: Any, sampling: Sampling) -> Iterator[tuple[Any, ...]]:
    """Yield the calls that give a new sampler its filters and wraps, but for the colour of borders.
    Source: OpenGL 4.5 core profile, table 8.15."""
    wraps = zip(("texture_wrap_s", "texture_wrap_t", "texture_wrap_r"), sampling.wrap, strict=False)
    for what, word in (
        ("texture_min_filter", sampling.filter[0]),
        ("texture_mag_filter", sampling.filter[1]),
        *wraps,
        ("texture_compare_mode", "compare_ref_to_texture" if sampling.compare else "none"),
        ("texture_compare_func", sampling.compare or "lequal"),
    ):
        yield "SamplerParameteri", made, what, word
    yield "SamplerParameterf", made, "texture_min_lod", sampling.lod[0]
    yield "SamplerParameterf", made, "texture_max_lod", sampling.lod[1]
