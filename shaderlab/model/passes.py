"""Passes of one draw or dispatch, as most cases have them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import (
    UNIT_SQUARE,
    BufferValue,
    Draw,
    Pass,
    Ramp,
    Target,
    Uniform,
    UniformBuffer,
)
from shaderlab.model.state import State
from shaderlab.model.textures import ImageValue, TextureSource


def fullscreen(
    fragment: str,
    *,
    domain: Mapping[str, Ramp] | None = None,
    uniforms: Mapping[str, Uniform] | None = None,
    textures: Mapping[str, TextureSource] | None = None,
    blocks: Mapping[str, UniformBuffer] | None = None,
    target: Target | None = None,
    state: State | None = None,
    name: str = "main",
) -> tuple[Pass, ...]:
    """One pass that runs a fragment shader over the whole target.

    `domain` lays each of its inputs over the screen (`across`, `up`, `Ramp`); without it the
    shader may read `in vec2 TexCoords`, from (0, 0) lower left to (1, 1) upper right.
    """
    draw = Draw(
        fragment=fragment,
        domain=UNIT_SQUARE if domain is None else domain,
        **_present(uniforms=uniforms, textures=textures, blocks=blocks, state=state),
    )
    return (Pass(name=name, draws=(draw,), **_present(target=target)),)


def mesh_pass(
    vertex: str,
    fragment: str,
    mesh: Mesh,
    *,
    geometry: str | None = None,
    tess_control: str | None = None,
    tess_evaluation: str | None = None,
    uniforms: Mapping[str, Uniform] | None = None,
    textures: Mapping[str, TextureSource] | None = None,
    blocks: Mapping[str, UniformBuffer] | None = None,
    target: Target | None = None,
    state: State | None = None,
    instances: int = 1,
    name: str = "main",
) -> tuple[Pass, ...]:
    """One pass that draws one mesh with one program."""
    draw = Draw(
        vertex=vertex,
        geometry=geometry,
        tess_control=tess_control,
        tess_evaluation=tess_evaluation,
        fragment=fragment,
        mesh=mesh,
        instances=instances,
        **_present(uniforms=uniforms, textures=textures, blocks=blocks, state=state),
    )
    return (Pass(name=name, draws=(draw,), **_present(target=target)),)


def compute(
    shader: str,
    *,
    groups: tuple[int, int, int],
    buffers: Mapping[str, BufferValue] | None = None,
    images: Mapping[str, ImageValue] | None = None,
    uniforms: Mapping[str, Uniform] | None = None,
    textures: Mapping[str, TextureSource] | None = None,
    blocks: Mapping[str, UniformBuffer] | None = None,
    name: str = "main",
) -> tuple[Pass, ...]:
    """One pass that runs a compute shader once.

    Each member of its storage blocks that is not `readonly` is an output, called by its name: an
    image of one row that has a pixel for each element. So is each of its images.

    Args:
        shader: the compute shader.
        groups: how many work groups are dispatched in x, y and z.
        buffers: what the members of storage blocks hold before, by the names that GLSL gives them,
            with the block's before it where two blocks share one ("Block.values"). Arrays have
            shape (length, components); one of run-time length is as long as what is given. An
            `Output` is what an earlier pass left.
        images: what each `image2D` holds before, by its name: an array (height, width, components)
            whose row 0 is the bottom one, a function that makes one, a file's path, or an `Output`.
            An `image2DArray` or `image3D` takes (layers, height, width, components). Its format is
            the one that the shader's layout names.
        uniforms, textures, blocks, name: as in `Draw` and `Pass`.
    """
    draw = Draw(
        compute=shader,
        groups=groups,
        **_present(buffers=buffers, images=images),
        **_present(uniforms=uniforms, textures=textures, blocks=blocks),
    )
    return (Pass(name=name, draws=(draw,)),)


def _present(**arguments: Any) -> dict[str, Any]:
    """Those arguments that are given."""
    return {name: value for name, value in arguments.items() if value is not None}
