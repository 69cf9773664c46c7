"""Textures in WebGL2: the lab's formats, how texels are uploaded and read back, what samplers read.

Source: OpenGL ES 3.0 specification, tables 3.2 and 3.13; WEBGL_compressed_texture_etc,
WEBGL_compressed_texture_s3tc and EXT_texture_compression_bptc.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Variable
from shaderlab.errors import DriverError, UnsupportedError
from shaderlab.model.frame import Array
from shaderlab.model.textures import CompressedTexture, Output, TextureSource, level_sizes

from .. import Size
from ..gl_state import sampler_calls
from ..programs import textures
from ..resources import COVERING, UNREADABLE, DeviceTexels, SceneTextures
from .device import ARRAYS, Device, Object, Objects, decode

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


def texture_format(word: str) -> Stored:
    if word in _DEPTHS:
        internal, kind = _DEPTHS[word]
        return Stored(internal, "DEPTH_STENCIL" if "stencil" in word else "DEPTH_COMPONENT", kind)
    found = textures.format_of(word)
    channels = _CHANNELS[found.components] + ("_INTEGER" if found.integer else "")
    return Stored(word.upper(), channels, _TYPES[found.numpy])


def encode_texels(word: str, values: Array) -> Array:
    """Texels as they are handed over: depths as codes, those of 24 bits as the nearest of 32."""
    if word not in textures.DEPTH or word == "depth32f":
        return np.ascontiguousarray(values)
    most = 0xFFFF if word == "depth16" else 0xFFFFFF
    codes = np.rint(np.clip(values.astype(np.float64), 0.0, 1.0) * most).astype(np.uint32)
    return codes.astype(np.uint16) if word == "depth16" else codes << 8 | codes >> 16


def round_depths(word: str, values: Array) -> Array:
    """Texels as shaders get them after `uploaded`: depths are those that their codes stand for."""
    if word not in textures.DEPTH or word == "depth32f":
        return values
    codes = encode_texels(word, values)
    return (codes / float(np.iinfo(codes.dtype).max)).astype(np.float32)


# The format and the type in which texels of an attachment are read; floats whatever their size.
READ: dict[Any, tuple[str, str]] = {
    np.uint8: ("RGBA", "UNSIGNED_BYTE"), np.int32: ("RGBA_INTEGER", "INT"),
    np.uint32: ("RGBA_INTEGER", "UNSIGNED_INT"), np.float32: ("RGBA", "FLOAT"),
}  # fmt: skip


def require_filtered(device: Device, word: str, filters: tuple[str, str], compared: bool) -> None:
    """Raise UnsupportedError where WebGL2 does not filter a format."""
    if all(name in ("nearest", "nearest_mipmap_nearest") for name in filters):
        return
    if word in textures.DEPTH and not compared:
        raise UnsupportedError(f"filtering {word}: WebGL2 filters depths only as it compares them")
    if word.endswith("32f") and word not in textures.DEPTH:
        device.require("OES_texture_float_linear", f"filtering {word}")


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


def read_attached(
    device: Device, texture: Object, word: str, size: Size, *, level: int = 0, face: str = "2D"
) -> Array:
    """Return a level of a texture that can be drawn to: (height, width, channels); `size` is the
    level's, `face` the texture's target without "TEXTURE_", that of a face for a cube."""
    gl = device.gl
    with Objects(gl) as own:
        frame = own.new("Framebuffer")
        gl.bindFramebuffer(gl.FRAMEBUFFER, frame)
        target = getattr(gl, f"TEXTURE_{face}")
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, target, texture, level)
        return read_pixels(device, word, size)


def read_pixels(device: Device, word: str, size: Size) -> Array:
    """Return the first attachment of the framebuffer that is bound, (height, width, channels).
    Raises DriverError: it can't be read."""
    gl, found = device.gl, textures.format_of(word)
    read = found.numpy if found.numpy in READ else np.float32
    format, kind = (getattr(gl, name) for name in READ[read])
    how = (format, kind, ARRAYS[np.dtype(read)], found.components)
    data, errors = gl.ask_all([("texels", *size, *how), ("errors",)])
    if errors:
        raise DriverError(f"reading {word}: WebGL2 raised {', '.join(map(hex, errors))}")
    values = decode(data, read)
    return values.reshape(size[1], size[0], found.components).astype(found.numpy, copy=False)


def fetch_texels(device: Device, texture: Object, size: Size, level: int = 0) -> Array:
    """Return a level of floats or depths as shaders get it: (height, width, 4) floats."""
    gl = device.gl
    with Objects(gl) as own:
        program = use_own_program(device, _FETCH)
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


def read_stencil(device: Device, attachment: Mapping[str, Object], size: Size) -> Array:
    """Return what a stencil buffer holds, (height, width, 1) bytes; `attachment` is the image that
    has it, by what it is attached as."""
    gl = device.gl
    with Objects(gl) as own:
        program = use_own_program(device, _BIT)
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


def use_own_program(device: Device, fragment: str) -> Object:
    """Return a program of the lab's, in use, that draws one triangle over the target; made once."""
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
    """Draw each pixel of a new texture of floats once from now on; returns the framebuffer."""
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


_TARGETS = {"2D": "TEXTURE_2D", "Cube": "TEXTURE_CUBE_MAP", "2DArray": "TEXTURE_2D_ARRAY"}
NO_LEVELS = ("rgb32f", "r32i", "rg32i", "rgba32i", "r32ui", "rg32ui", "rgba32ui")


@dataclass(frozen=True)
class DeviceTexture:
    """A texture: `kind` as in `Texels.kind`, `size` (width, height) of its largest level."""

    handle: Object
    kind: str
    word: str
    size: tuple[int, int]
    layers: int = 1

    @property
    def target(self) -> str:
        """The constant of what it is bound as."""
        return _TARGETS[self.kind]


@dataclass(eq=False)
class BoundTextures(SceneTextures[Any]):
    """What a scene's samplers read; what is made is released with `_own`."""

    _device: Device
    _own: Objects

    def bind(self, unit: int, variable: Variable, source: TextureSource) -> None:
        """Bind a texture that `texels` has looked at to a unit, and its sampler."""
        gl, found = self._device.gl, self.find(source, self.kind(source, variable))
        require_filtered(self._device, found.format, source.filter, source.compare is not None)
        if "clamp_to_border" in source.wrap:
            raise UnsupportedError("clamp_to_border: textures have no border in WebGL2")
        if not getattr(source, "seamless", True):
            raise UnsupportedError("seamless=False: WebGL2 filters every cube across its edges")
        gl.activeTexture(gl.TEXTURE0 + unit)
        gl.bindTexture(getattr(gl, found.handle.target), found.handle.handle)
        gl.bindSampler(unit, self.sampler(source))

    def attachment(self, source: Output, kind: str) -> DeviceTexels:
        if kind == "2DMS":
            raise UnsupportedError("sampler2DMS: WebGL2 has no multisampled textures")
        image, target = textures.find_image(source, self.images), self.targets[source.pass_name]
        if source.name == "stencil":
            raise UnsupportedError("sampling the stencil of this target")
        drawn = target.textures.get(source.name, target.depth_texture)
        if drawn is None:
            raise UnsupportedError(f"sampling the {source.name} of this target", remedy=UNREADABLE)
        texture = DeviceTexture(drawn, "2D", image.format, target.size)
        if not source.mipmaps:
            return DeviceTexels(source, texture, image.format, image.values)
        texture = self._new("2D", image.format, target.size, len(level_sizes(*target.size)))
        self._copy(drawn, texture)
        self._generate(texture)
        levels = self._smaller(texture)
        return DeviceTexels(source, texture, image.format, image.values, levels)

    def upload(self, source: TextureSource) -> DeviceTexels:
        assert not isinstance(source, Output)
        if isinstance(source, CompressedTexture):
            return self._upload_compressed(source)
        kind, word = textures.texture_kind(source, "", 0), source.format
        if kind == "3D":
            raise UnsupportedError("sampler3D on this backend", remedy="--driver opengl draws it")
        images = textures.texture_contents(source, self.folder, self.images)
        height, width = images.layers[0].shape[:2]
        given: list[Sequence[Array]] = [images.layers, *([level] for level in images.smaller)]
        whole = source.mipmaps is True
        count = len(level_sizes(width, height)) if whole else len(given)
        texture = self._new(kind, word, (width, height), count, len(images.layers))
        for level, layers in enumerate(given):
            for layer, values in enumerate(layers):
                self._write(texture, level, layer, encode_texels(word, values))
        layers = [round_depths(word, each) for each in images.layers]
        values = layers[0] if kind == "2D" else np.stack(layers)
        smaller = tuple(round_depths(word, each) for each in images.smaller)
        if whole:
            self._generate(texture)
            smaller = self._smaller(texture)
        return DeviceTexels(source, texture, word, values, smaller)

    def _upload_compressed(self, source: CompressedTexture) -> DeviceTexels:
        gl, blocks = self._device.gl, textures.load_blocks(source, self.folder)
        name, extension = COMPRESSED[blocks.format]
        self._device.require(extension, blocks.format)
        texture = DeviceTexture(self._own.new("Texture"), "2D", "rgba8", blocks.size)
        gl.activeTexture(gl.TEXTURE0)
        gl.bindTexture(gl.TEXTURE_2D, texture.handle)
        sizes = level_sizes(*blocks.size)[: len(blocks.levels)]
        constant = getattr(gl, name)
        gl.texStorage2D(gl.TEXTURE_2D, len(sizes), constant, *blocks.size)
        for level, (size, data) in enumerate(zip(sizes, blocks.levels, strict=True)):
            gl.compressedTexSubImage2D(gl.TEXTURE_2D, level, 0, 0, *size, constant, data)
        fetched = (fetch_texels(self._device, texture.handle, s, n) for n, s in enumerate(sizes))
        first, *smaller = (np.rint(level * 255.0).astype(np.uint8) for level in fetched)
        return DeviceTexels(source, texture, "rgba8", first, tuple(smaller))

    def _new(
        self, kind: str, word: str, size: tuple[int, int], levels: int, layers: int = 1
    ) -> DeviceTexture:
        gl = self._device.gl
        texture = DeviceTexture(self._own.new("Texture"), kind, word, size, layers)
        gl.activeTexture(gl.TEXTURE0)
        target = getattr(gl, texture.target)
        gl.bindTexture(target, texture.handle)
        internal = getattr(gl, texture_format(word).internal)
        if kind == "2DArray":
            gl.texStorage3D(target, levels, internal, *size, layers)
        else:
            gl.texStorage2D(target, levels, internal, *size)
        return texture

    def _write(self, texture: DeviceTexture, level: int, layer: int, values: Array) -> None:
        """Write a level of one layer or face of the texture that is bound."""
        gl, word = self._device.gl, texture_format(texture.word)
        height, width = values.shape[:2]
        how = (getattr(gl, word.format), getattr(gl, word.type), values)
        if texture.kind == "2DArray":
            gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, level, 0, 0, layer, width, height, 1, *how)
        else:
            face = gl.TEXTURE_CUBE_MAP_POSITIVE_X + layer
            target = face if texture.kind == "Cube" else gl.TEXTURE_2D
            gl.texSubImage2D(target, level, 0, 0, width, height, *how)

    def _copy(self, drawn: Object, texture: DeviceTexture) -> None:
        """Copy an attachment to the first level of a texture, which is bound."""
        gl = self._device.gl
        with Objects(gl) as own:
            gl.bindFramebuffer(gl.FRAMEBUFFER, own.new("Framebuffer"))
            gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, drawn, 0)
            gl.copyTexSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 0, 0, *texture.size)

    def _generate(self, texture: DeviceTexture) -> None:
        """Halve each level into the next one."""
        gl = self._device.gl
        if texture.word in NO_LEVELS or texture.word in textures.DEPTH:
            raise UnsupportedError(f"mipmaps=True: WebGL2 makes no levels of {texture.word}")
        require_filtered(self._device, texture.word, ("linear", "linear"), False)
        gl.bindTexture(getattr(gl, texture.target), texture.handle)
        gl.generateMipmap(getattr(gl, texture.target))

    def _smaller(self, texture: DeviceTexture) -> tuple[Array, ...]:
        """Return the levels below the first, as the device has them."""
        if texture.kind == "2DArray":
            raise UnsupportedError("mipmaps=True of a texture array: WebGL2 can't read its levels")
        faces = ["2D"]
        if texture.kind == "Cube":
            faces = [f"CUBE_MAP_{way}_{axis}" for axis in "XYZ" for way in ("POSITIVE", "NEGATIVE")]
        found = []
        for level, size in enumerate(level_sizes(*texture.size)[1:], start=1):
            own = (self._device, texture.handle, texture.word, size)
            each = [read_attached(*own, level=level, face=face) for face in faces]
            found.append(each[0] if texture.kind == "2D" else np.stack(each))
        return tuple(found)

    def new_sampler(self, source: TextureSource) -> Object:
        made = self._own.new("Sampler")
        for call in sampler_calls(made, source):
            self._device.gl.make(*call)
        return made
