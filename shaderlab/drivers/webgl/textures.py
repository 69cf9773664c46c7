"""The lab's formats as WebGL2 has them, and texels as they are uploaded.

Source: OpenGL ES 3.0 specification, tables 3.2 and 3.13; WEBGL_compressed_texture_etc,
WEBGL_compressed_texture_s3tc and EXT_texture_compression_bptc.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shaderlab.errors import DriverError, UnsupportedError
from shaderlab.model.frame import Array

from ..programs.textures import DEPTH, format_of
from ..resources import COVERING
from .device import Device, Object, Objects, decoded

_CHANNELS = {1: "RED", 2: "RG", 3: "RGB", 4: "RGBA"}
_TYPES = {
    np.uint8: "UNSIGNED_BYTE", np.float16: "HALF_FLOAT", np.float32: "FLOAT", np.int32: "INT",
    np.uint32: "UNSIGNED_INT",
}  # fmt: skip
_DEPTHS = {
    "depth16": ("DEPTH_COMPONENT16", "UNSIGNED_SHORT"),
    "depth24": ("DEPTH_COMPONENT24", "UNSIGNED_INT"),
    "depth32f": ("DEPTH_COMPONENT32F", "FLOAT"),
    "depth24_stencil8": ("DEPTH24_STENCIL8", "UNSIGNED_INT_24_8"),
    "depth32f_stencil8": ("DEPTH32F_STENCIL8", "FLOAT_32_UNSIGNED_INT_24_8_REV"),
}
COMPRESSED = {
    "etc2_rgb8": ("COMPRESSED_RGB8_ETC2", "WEBGL_compressed_texture_etc"),
    "etc2_eac_rgba8": ("COMPRESSED_RGBA8_ETC2_EAC", "WEBGL_compressed_texture_etc"),
    "bc1": ("COMPRESSED_RGB_S3TC_DXT1_EXT", "WEBGL_compressed_texture_s3tc"),
    "bc3": ("COMPRESSED_RGBA_S3TC_DXT5_EXT", "WEBGL_compressed_texture_s3tc"),
    "bc7": ("COMPRESSED_RGBA_BPTC_UNORM_EXT", "EXT_texture_compression_bptc"),
}
"""Each compressed format's constant, and the extension that it comes with."""


@dataclass(frozen=True)
class Stored:
    """The constants by which WebGL2 knows a format: as it is stored, and as texels come."""

    internal: str
    format: str
    type: str


def stored(word: str) -> Stored:
    """The constants of a colour or depth format."""
    if word in _DEPTHS:
        internal, kind = _DEPTHS[word]
        return Stored(internal, "DEPTH_STENCIL" if "stencil" in word else "DEPTH_COMPONENT", kind)
    found = format_of(word)
    channels = _CHANNELS[found.components] + ("_INTEGER" if found.integer else "")
    return Stored(word.upper(), channels, _TYPES[found.numpy])


def uploaded(word: str, values: Array) -> Array:
    """Texels as they are handed over: depths as codes, those of 24 bits as the nearest of 32."""
    if word not in DEPTH or word == "depth32f":
        return np.ascontiguousarray(values)
    most = 0xFFFF if word == "depth16" else 0xFFFFFF
    codes = np.rint(np.clip(values.astype(np.float64), 0.0, 1.0) * most).astype(np.uint32)
    return codes.astype(np.uint16) if word == "depth16" else codes << 8 | codes >> 16


def stored_depths(word: str, values: Array) -> Array:
    """Texels as shaders get them after `uploaded`: depths are those that their codes stand for."""
    if word not in DEPTH or word == "depth32f":
        return values
    codes = uploaded(word, values)
    return (codes / float(np.iinfo(codes.dtype).max)).astype(np.float32)


def read_as(word: str) -> tuple[str, str, str]:
    """The format and the type in which texels of an attachment are read, and the array they go
    into: in fours, floats whatever their size."""
    found = format_of(word)
    if found.numpy is np.uint8:
        return "RGBA", "UNSIGNED_BYTE", "Uint8Array"
    if found.numpy is np.int32:
        return "RGBA_INTEGER", "INT", "Int32Array"
    if found.numpy is np.uint32:
        return "RGBA_INTEGER", "UNSIGNED_INT", "Uint32Array"
    return "RGBA", "FLOAT", "Float32Array"


READ_TYPES = {
    "Uint8Array": np.uint8, "Int32Array": np.int32, "Uint32Array": np.uint32,
    "Float32Array": np.float32,
}  # fmt: skip


def require_filtered(device: Device, word: str, filters: tuple[str, str], compared: bool) -> None:
    """Raise UnsupportedError where WebGL2 does not filter a format: a texture of it would be
    incomplete."""
    if all(name in ("nearest", "nearest_mipmap_nearest") for name in filters):
        return
    if word in DEPTH and not compared:
        raise UnsupportedError(f"filtering {word}: WebGL2 filters depths only as it compares them")
    if word.endswith("32f") and word not in DEPTH:
        device.require("OES_texture_float_linear", f"filtering {word}")


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
