"""Reading what textures hold: colours by attaching them, depths and blocks by a shader that fetches
each texel, stencils bit by bit by drawing where one is set."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from shaderlab.errors import DriverError
from shaderlab.model.frame import Array

from ..attachments import COVERING
from ..programs.formats import format_of
from .calls import Object, Objects, decoded
from .device import Device
from .formats import READ_TYPES, read_as

Size = tuple[int, int]

_CORNERS = COVERING.replace("330 core", "300 es")
_FETCH = """#version 300 es
precision highp float;
uniform highp sampler2D texels;
uniform int level;
out vec4 color;
void main() { color = texelFetch(texels, ivec2(gl_FragCoord.xy), level); }
"""
_BIT = """#version 300 es
precision highp float;
uniform float bit;
out vec4 color;
void main() { color = vec4(bit); }
"""
_STENCIL_BITS = 8


def attached(
    device: Device, texture: Object, word: str, size: Size, *, level: int = 0, face: str = "2D"
) -> Array:
    """A level of a texture that can be drawn to: (height, width, channels).

    Args:
        device: where it is.
        texture: what to read.
        word: its format.
        size: of the level in texels.
        level: its number.
        face: the texture's target without "TEXTURE_", that of a face for a cube.
    """
    gl = device.gl
    with Objects(gl) as own:
        frame = own.new("Framebuffer")
        gl.bindFramebuffer(gl.FRAMEBUFFER, frame)
        target = getattr(gl, f"TEXTURE_{face}")
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, target, texture, level)
        return read_pixels(device, word, size)


def read_pixels(device: Device, word: str, size: Size) -> Array:
    """The first attachment of the framebuffer that is bound, (height, width, channels).

    Raises:
        DriverError: it can't be read.
    """
    gl, found = device.gl, format_of(word)
    format, kind, array = read_as(word)
    how = (getattr(gl, format), getattr(gl, kind), array, found.components)
    data, errors = gl.ask_all([("texels", *size, *how), ("errors",)])
    if errors:
        raise DriverError(f"reading {word}: WebGL2 raised {', '.join(map(hex, errors))}")
    values = decoded(data, READ_TYPES[array])
    return values.reshape(size[1], size[0], found.components).astype(found.numpy, copy=False)


def fetched(device: Device, texture: Object, size: Size, level: int = 0) -> Array:
    """A level of a texture of floats or depths, as shaders get it: (height, width, 4) floats."""
    gl = device.gl
    with Objects(gl) as own:
        program = program_of(device, _FETCH)
        draw_to_floats(device, own, size)
        gl.activeTexture(gl.TEXTURE0)
        gl.bindTexture(gl.TEXTURE_2D, texture)
        sampler = own.new("Sampler")
        for filtered in (gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER):
            mipmaps = filtered == gl.TEXTURE_MIN_FILTER
            gl.samplerParameteri(
                sampler, filtered, gl.NEAREST_MIPMAP_NEAREST if mipmaps else gl.NEAREST
            )
        gl.bindSampler(0, sampler)
        gl.uniform1i(gl.new("getUniformLocation", program, "level"), level)
        gl.drawArrays(gl.TRIANGLES, 0, 3)
        gl.bindSampler(0, None)
        return read_pixels(device, "rgba32f", size)


def stencil(device: Device, attachment: Mapping[str, Object], size: Size) -> Array:
    """What a stencil buffer holds, (height, width, 1) bytes.

    Args:
        device: where it is.
        attachment: the image that has it, by what it is attached as.
        size: in pixels.
    """
    gl = device.gl
    with Objects(gl) as own:
        program = program_of(device, _BIT)
        draw_to_floats(device, own, size)
        for point, texture in attachment.items():
            gl.framebufferTexture2D(gl.FRAMEBUFFER, getattr(gl, point), gl.TEXTURE_2D, texture, 0)
        gl.enable(gl.STENCIL_TEST)
        gl.enable(gl.BLEND)
        gl.blendFunc(gl.ONE, gl.ONE)
        gl.blendEquation(gl.FUNC_ADD)
        gl.stencilMask(0)
        gl.stencilOp(gl.KEEP, gl.KEEP, gl.KEEP)
        location = gl.new("getUniformLocation", program, "bit")
        for number in range(_STENCIL_BITS):
            gl.stencilFunc(gl.EQUAL, 1 << number, 1 << number)
            gl.uniform1f(location, 1 << number)
            gl.drawArrays(gl.TRIANGLES, 0, 3)
        gl.disable(gl.STENCIL_TEST)
        gl.disable(gl.BLEND)
        return read_pixels(device, "rgba32f", size)[..., :1].astype(np.uint8)


def program_of(device: Device, fragment: str) -> Object:
    """A program of the lab's, in use, that draws one triangle over the target; made once."""
    gl = device.gl
    if fragment not in device.own_programs:
        program = gl.new("createProgram")
        refused = gl.ask("link", program, {"vertex": _CORNERS, "fragment": fragment}, [])
        if refused:
            raise DriverError(f"WebGL2 refuses a program of the lab's: {refused[1]}")
        device.own_programs[fragment] = program
    gl.useProgram(device.own_programs[fragment])
    return device.own_programs[fragment]


def draw_to_floats(device: Device, own: Objects, size: Size) -> Object:
    """Draw to a texture of floats from now on, each pixel once, whatever the state was; the
    framebuffer."""
    gl = device.gl
    texture, frame = own.new("Texture"), own.new("Framebuffer")
    gl.activeTexture(gl.TEXTURE0)
    gl.bindTexture(gl.TEXTURE_2D, texture)
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, *size)
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame)
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0)
    for word in ("SCISSOR_TEST", "DEPTH_TEST", "STENCIL_TEST", "BLEND", "CULL_FACE"):
        gl.disable(getattr(gl, word))
    gl.colorMask(True, True, True, True)
    gl.viewport(0, 0, *size)
    gl.bindVertexArray(None)
    gl.clearBufferfv(gl.COLOR, 0, [0.0, 0.0, 0.0, 0.0])
    return frame
