"""Reading every sample of a multisampled texture: a shader fetches them, one number at a time."""

from __future__ import annotations

import moderngl
import numpy as np

from shaderlab.backends.opengl import state
from shaderlab.backends.opengl.device import Device
from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.backends.opengl.textures import DeviceTexture
from shaderlab.errors import UnsupportedError
from shaderlab.frame import Array
from shaderlab.model import State

_CORNERS = """#version 330 core
void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(corner, 0.0, 1.0);
}
"""
_FETCH = """#version 330 core
uniform sampler2DMS image;
uniform int number;
out vec4 color;
void main() { color = texelFetch(image, ivec2(gl_FragCoord.xy), number); }
"""


def read_samples(
    device: Device, texture: DeviceTexture, size: tuple[int, int], samples: int
) -> Array:
    """All samples of a float or normalised texture, as float32 (samples, height, width, 4).

    Raises:
        UnsupportedError: the driver can't fetch single samples.
    """
    context = device.context
    try:
        program = context.program(vertex_shader=_CORNERS, fragment_shader=_FETCH)
    except moderngl.Error as error:
        raise UnsupportedError(f"fetching single samples: {str(error).strip()}") from error
    target = context.texture(size, 4, dtype="f4")
    framebuffer = context.framebuffer([target])
    corners = context.vertex_array(program, [])
    values = np.empty((samples, size[1], size[0], 4), np.float32)
    framebuffer.use()
    state.apply(State(), size, device.version)
    GL.glActiveTexture(GL.GL_TEXTURE0)
    GL.glBindTexture(texture.target, texture.glo)
    GL.glUseProgram(program.glo)
    GL.glUniform1i(GL.glGetUniformLocation(program.glo, b"image"), 0)
    for number in range(samples):
        GL.glUniform1i(GL.glGetUniformLocation(program.glo, b"number"), number)
        corners.render(4, vertices=3)
        target.read_into(values[number], alignment=1)
    GL.glBindTexture(texture.target, 0)
    for made in (corners, framebuffer, target, program):
        made.release()
    return values
