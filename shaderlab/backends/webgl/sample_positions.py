"""Where the device takes a pixel's samples, by a shader that says it of one sample after the other.

Source: Khronos, OES_sample_variables.
"""

from __future__ import annotations

import numpy as np

from shaderlab.backends.webgl.calls import Objects
from shaderlab.backends.webgl.device import Device
from shaderlab.backends.webgl.reading import draw_to_floats, program_of, read_pixels
from shaderlab.frame import Array

_EXTENSION = "OES_sample_variables"
_TELLING = """#version 300 es
#extension GL_OES_sample_variables : require
precision highp float;
uniform int number;
out vec4 color;
void main() {
    if (gl_SampleID != number) discard;
    color = vec4(gl_SamplePosition, 0.0, 1.0);
}
"""


def sample_positions(device: Device, samples: int) -> Array:
    """The places of a pixel's samples, (samples, 2), from its lower left corner.

    Raises:
        UnsupportedError: the browser does not say.
    """
    device.require(_EXTENSION, "sample positions")
    gl, found = device.gl, []
    with Objects(gl) as own:
        program = program_of(device, _TELLING)
        # What is read is the average of all samples, of which one is not zero.
        frame = draw_to_floats(device, own, (1, 1))
        several, buffer = own.new("Framebuffer"), own.new("Renderbuffer")
        gl.bindRenderbuffer(gl.RENDERBUFFER, buffer)
        gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, gl.RGBA32F, 1, 1)
        location = gl.new("getUniformLocation", program, "number")
        for number in range(samples):
            gl.bindFramebuffer(gl.FRAMEBUFFER, several)
            gl.framebufferRenderbuffer(
                gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, buffer
            )
            gl.clearBufferfv(gl.COLOR, 0, [0.0, 0.0, 0.0, 0.0])
            gl.uniform1i(location, number)
            gl.drawArrays(gl.TRIANGLES, 0, 3)
            gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, frame)
            gl.blitFramebuffer(0, 0, 1, 1, 0, 0, 1, 1, gl.COLOR_BUFFER_BIT, gl.NEAREST)
            gl.bindFramebuffer(gl.FRAMEBUFFER, frame)
            x, y, _, share = read_pixels(device, "rgba32f", (1, 1))[0, 0]
            found.append((x / share, y / share))
    return np.array(found, np.float32)
