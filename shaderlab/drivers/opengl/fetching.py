"""The fixed-function state of draws, and texels as a shader fetches them."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array
from shaderlab.model.state import State

from ..gl_state import state_calls
from ..resources import COVERING
from .device import GL, Device, gl_constant, resolve_call

TARGETS = {
    "2D": "texture_2d",
    "2DArray": "texture_2d_array",
    "3D": "texture_3d",
    "Cube": "texture_cube_map",
    "2DMS": "texture_2d_multisample",
}
"""The binding point of each kind of texture."""


def apply_state(state: State, size: tuple[int, int], version: int) -> None:
    """Make the current context's state what `state` says, for a target of `size` pixels.

    `version` is the context's OpenGL version: 450 for 4.5.
    """
    try:
        calls = _list_calls(state, size, version)
    except TypeError:  # rectangles may be lists, which no cache takes
        calls = _list_calls.__wrapped__(state, size, version)
    for name, given in calls:
        getattr(GL, name)(*given)


@lru_cache(maxsize=512)
def _list_calls(
    state: State, size: tuple[int, int], version: int
) -> Sequence[tuple[str, Sequence[Any]]]:
    switches = {
        "polygon_offset_line": False,  # a driver may take it for that of filled polygons
        "framebuffer_srgb": state.srgb,
        "program_point_size": isinstance(state.point_size, str),
        "multisample": state.multisample,
    }
    calls: list[tuple[Any, ...]] = []
    if version >= 400:
        switches["sample_shading"] = state.sample_shading is not None
        calls.append(("MinSampleShading", state.sample_shading or 0.0))
    elif state.sample_shading is not None:
        raise UnsupportedError("shading each sample (sample_shading): it takes OpenGL 4.0")
    calls += state_calls(state, size, switches)
    calls.append(
        ("PointSize", state.point_size if isinstance(state.point_size, int | float) else 1.0)
    )
    return [resolve_call(*call) for call in calls]


_FETCH = """#version 330 core
uniform sampler%s image;
uniform int number;
out vec4 color;
void main() { color = texelFetch(image, ivec2(gl_FragCoord.xy), number); }
"""


def fetch_texels(
    device: Device, kind: str, texture: int, sizes: Sequence[tuple[int, int]]
) -> list[Array]:
    """Fetch the samples ("2DMS") or levels ("2D") of a float or normalised texture, each of which
    has (width, height) texels: float32 (height, width, 4).

    glGetTexImage may decode blocks in another way than samplers do: NVIDIA's driver does.

    Raises:
        moderngl.Error: the driver can't fetch them.
    """
    context, target = device.context, gl_constant(TARGETS[kind])
    program = context.program(vertex_shader=COVERING, fragment_shader=_FETCH % kind)
    corners, found = context.vertex_array(program, []), []
    unit = GL.glGetIntegerv(GL.GL_ACTIVE_TEXTURE)
    for number, size in enumerate(sizes):
        drawn = context.texture(size, 4, dtype="f4")
        framebuffer = context.framebuffer([drawn])
        framebuffer.use()
        apply_state(State(), size, device.version)
        GL.glActiveTexture(GL.GL_TEXTURE0)  # moderngl makes textures in another unit
        GL.glBindTexture(target, texture)
        GL.glBindSampler(0, 0)
        GL.glUseProgram(program.glo)
        for name, value in (("image", 0), ("number", number)):
            GL.glUniform1i(GL.glGetUniformLocation(program.glo, name.encode()), value)
        corners.render(4, vertices=3)
        values = np.empty((size[1], size[0], 4), np.float32)
        drawn.read_into(values, alignment=1)
        found.append(values)
        for made in (framebuffer, drawn):
            made.release()
    GL.glBindTexture(target, 0)
    GL.glActiveTexture(unit)
    for made in (corners, program):
        made.release()
    return found
