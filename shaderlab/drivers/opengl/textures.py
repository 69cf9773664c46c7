"""Textures on the device: made of images or compressed blocks, bound to units, and read back.

Pixels are moved as they lie in memory, through PyOpenGL's raw functions: its wrappers convert and
copy what they are given, and know neither half floats nor packed depth and stencil.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Variable
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Image, Texels
from shaderlab.model.state import State
from shaderlab.model.textures import (
    CompressedTexture,
    CubeTexture,
    Output,
    Sampling,
    Texture,
    TextureSource,
    level_sizes,
)

from ..gl_state import sampler_calls
from ..programs import textures
from ..programs.storage import image_output
from ..resources import COVERING, DeviceTexels, SceneTextures
from .buffers import write_mapped
from .device import GL, GL_1_0, GL_1_2, GL_1_3, Device, apply_state, gl_constant, resolve_call
from .linking import uniform_location

TARGETS = {
    "2D": "texture_2d",
    "2DArray": "texture_2d_array",
    "3D": "texture_3d",
    "Cube": "texture_cube_map",
    "2DMS": "texture_2d_multisample",
}
"""The binding point of each kind of texture."""
# OpenGL's number, the extension that brings it, and the version that has it without.
COMPRESSED = {
    "etc2_rgb8": (0x9274, "GL_ARB_ES3_compatibility", 430),
    "etc2_eac_rgba8": (0x9278, "GL_ARB_ES3_compatibility", 430),
    "bc1": (0x83F0, "GL_EXT_texture_compression_s3tc", 10**6),
    "bc3": (0x83F3, "GL_EXT_texture_compression_s3tc", 10**6),
    "bc7": (0x8E8C, "GL_ARB_texture_compression_bptc", 420),
}

# Source: OpenGL 4.5 core profile specification, tables 8.10 to 8.13 (sized internal formats).
_COMPONENTS = ("red", "rg", "rgb", "rgba")
_TYPES = {
    np.uint8: "unsigned_byte", np.float16: "half_float", np.float32: "float", np.int32: "int",
    np.uint32: "unsigned_int",
}  # fmt: skip
_PACKED = {
    "depth24_stencil8": "unsigned_int_24_8", "depth32f_stencil8": "float_32_unsigned_int_24_8_rev",
}  # fmt: skip


@dataclass(frozen=True)
class Transfer:
    """A format's internal number, and the components and type of the pixels that it comes in."""

    internal: int
    components: int
    type: int


def transfer(word: str) -> Transfer:
    """How a colour or depth format is uploaded and read; depths as floats.

    >>> hex(transfer("rgba8").internal), hex(transfer("depth24").components)
    ('0x8058', '0x1902')
    """
    kind = textures.format_of(word)
    components = _COMPONENTS[kind.components - 1] + "_integer" * kind.integer
    internal = word
    if word in textures.DEPTH:
        components = "depth_component"
        internal = word if kind.stencil else word.replace("depth", "depth_component")
    return Transfer(gl_constant(internal), gl_constant(components), gl_constant(_TYPES[kind.numpy]))


def depth_storage(word: str) -> Transfer:
    """How an empty depth texture is made: with its stencil packed beside each depth."""
    if word in _PACKED:
        return Transfer(gl_constant(word), gl_constant("depth_stencil"), gl_constant(_PACKED[word]))
    return transfer(word)


@dataclass(frozen=True)
class DeviceTexture:
    """A texture's name on the device, and the kind of its samplers, as in `Texels.kind`."""

    glo: int
    kind: str

    @classmethod
    def new(cls, kind: str) -> DeviceTexture:
        """A texture without any image, bound."""
        made = cls(int(GL.glGenTextures(1)), kind)
        GL.glBindTexture(made.target, made.glo)
        return made

    @property
    def target(self) -> int:
        """The binding point."""
        return gl_constant(TARGETS[self.kind])

    def release(self) -> None:
        GL.glDeleteTextures(1, [self.glo])


def upload(
    device: Device, kind: str, format: str, images: textures.Contents, *, mapped: bool = False
) -> DeviceTexture:
    """A texture with these images; `mapped` writes those of a plane through a pixel buffer. Raises
    UnsupportedError: it is too large for the driver."""
    height, width = images.layers[0].shape[:2]
    limit = int(device.context.info["GL_MAX_TEXTURE_SIZE"])
    if max(width, height) > limit:
        raise UnsupportedError(f"a texture of {width} × {height}: this driver ends at {limit}")
    word = {"2DArray": "GL_MAX_ARRAY_TEXTURE_LAYERS", "3D": "GL_MAX_3D_TEXTURE_SIZE"}.get(kind)
    if word and len(images.layers) > (most := int(device.context.info[word])):
        layers = len(images.layers)
        raise UnsupportedError(f"a texture of {layers} layers: this driver ends at {most}")
    made = DeviceTexture.new(kind)
    form = transfer(format)
    if kind in ("2DArray", "3D"):
        stacked = np.stack(images.layers)
        with tightly_packed():
            size, pixels = (width, height, len(stacked)), (form.components, form.type)
            data = address(stacked)
            GL_1_2.glTexImage3D(made.target, 0, form.internal, *size, 0, *pixels, data)
    elif kind == "Cube":
        for face, image in enumerate(images.layers):
            _set_image(GL.GL_TEXTURE_CUBE_MAP_POSITIVE_X + face, 0, format, image)
    else:
        for level, image in enumerate((*images.layers, *images.smaller)):
            _set_image(made.target, level, format, image, mapped=mapped)
    GL.glBindTexture(made.target, 0)
    return made


def _set_image(target: int, level: int, format: str, image: Array, *, mapped: bool = False) -> None:
    """Fill one level of the texture that is bound."""
    form = transfer(format)
    height, width = image.shape[:2]
    texels = np.ascontiguousarray(image)
    source = _pixel_buffer(texels) if mapped else nullcontext(address(texels))
    with tightly_packed(), source as pixels:
        GL_1_0.glTexImage2D(
            target, level, form.internal, width, height, 0, form.components, form.type, pixels
        )


@contextmanager
def _pixel_buffer(texels: Array) -> Iterator[ctypes.c_void_p]:
    """A buffer that texels are written into through a mapping, and that is bound for textures to
    be filled from; gives where they begin in it."""
    target = GL.GL_PIXEL_UNPACK_BUFFER
    name = int(GL.glGenBuffers(1))
    GL.glBindBuffer(target, name)
    GL.glBufferData(target, texels.nbytes, None, GL.GL_STREAM_DRAW)
    write_mapped(target, texels.tobytes())
    try:
        yield ctypes.c_void_p(0)
    finally:
        GL.glBindBuffer(target, 0)
        GL.glDeleteBuffers(1, np.array([name], np.uint32))


def upload_compressed(device: Device, blocks: textures.Blocks) -> tuple[DeviceTexture, list[Array]]:
    """A texture of these blocks, and each level as samplers decode it: codes (height, width, 4).
    Raises UnsupportedError: the driver lacks the format."""
    internal, extension, version = COMPRESSED[blocks.format]
    if device.version < version and extension not in device.context.extensions:
        raise UnsupportedError(f"{blocks.format} textures", remedy=f"this driver lacks {extension}")
    sizes = level_sizes(*blocks.size)[: len(blocks.levels)]
    made = DeviceTexture.new("2D")
    for level, (size, data) in enumerate(zip(sizes, blocks.levels, strict=True)):
        GL_1_3.glCompressedTexImage2D(made.target, level, internal, *size, 0, len(data), data)
    GL.glTexParameteri(made.target, GL.GL_TEXTURE_MAX_LEVEL, len(sizes) - 1)
    GL.glBindTexture(made.target, 0)
    fetched = fetch_texels(device, made.kind, made.glo, sizes)
    return made, [np.rint(level * 255.0).astype(np.uint8) for level in fetched]


def generate_levels(texture: DeviceTexture) -> None:
    GL.glBindTexture(texture.target, texture.glo)
    GL.glGenerateMipmap(texture.target)
    # llvmpipe (Mesa 22.3) draws the levels later, and hands out empty ones until it has.
    GL.glFinish()
    GL.glBindTexture(texture.target, 0)


def read_level(
    texture: DeviceTexture, format: str, level: int, size: tuple[int, int, int]
) -> Array:
    """One level as it is on the device: (height, width, channels), or of an array or a cube
    (layers, height, width, channels). `size` is the level's (width, height, layers)."""
    width, height, count = size
    form, kind = transfer(format), textures.format_of(format)
    values = np.empty((count, height, width, kind.components), kind.numpy)
    cube = texture.kind == "Cube"
    GL.glBindTexture(texture.target, texture.glo)
    with tightly_packed():
        for number, part in enumerate(values if cube else [values]):
            target = GL.GL_TEXTURE_CUBE_MAP_POSITIVE_X + number if cube else texture.target
            GL_1_0.glGetTexImage(target, level, form.components, form.type, address(part))
    GL.glBindTexture(texture.target, 0)
    return values[0] if texture.kind == "2D" else values


@contextmanager
def tightly_packed() -> Iterator[None]:
    """Transfers of rows without padding between them."""
    words = (GL.GL_PACK_ALIGNMENT, GL.GL_UNPACK_ALIGNMENT)
    for word in words:
        GL.glPixelStorei(word, 1)
    try:
        yield
    finally:
        for word in words:
            GL.glPixelStorei(word, 4)


def address(values: Array) -> ctypes.c_void_p:
    """Where an array lies in memory, without gaps."""
    assert values.flags.c_contiguous
    return ctypes.c_void_p(values.ctypes.data)


@dataclass(eq=False)
class BoundTextures(SceneTextures[Any]):
    """What a scene's samplers read; `_stack` releases device memory at the end."""

    _device: Device
    _stack: ExitStack

    def bind(self, program: Any, unit: int, variable: Variable, source: TextureSource) -> bool:
        """Bind a texture to a unit, and the sampler to that; False if the program lacks it."""
        location = uniform_location(program, variable.name)
        if location < 0:
            return False
        GL.glActiveTexture(GL.GL_TEXTURE0 + unit)  # one that is made now takes no other's unit
        texture = self.find(source, self.kind(source, variable)).handle
        GL.glBindTexture(texture.target, texture.glo)
        GL.glBindSampler(unit, self.sampler(source))
        GL.glActiveTexture(GL.GL_TEXTURE0)
        GL.glUseProgram(program.glo)
        GL.glUniform1i(location, unit)
        if isinstance(source, CubeTexture):
            (GL.glEnable if source.seamless else GL.glDisable)(GL.GL_TEXTURE_CUBE_MAP_SEAMLESS)
        return True

    def attachment(self, source: Output, kind: str) -> DeviceTexels:
        image = textures.find_image(source, self.images)
        target = self.targets[source.pass_name]
        texture = target.texture(source.name, sampled=kind == "2DMS")
        if kind == "2DMS":
            samples = target.read_samples(source.name)
            return DeviceTexels(source, texture, image.format, samples)
        levels: tuple[Array, ...] = ()
        if source.mipmaps:
            generate_levels(texture)
            levels = _read_smaller(texture, image.format, image.values)
        return DeviceTexels(source, texture, image.format, image.values, levels)

    def upload(self, source: TextureSource) -> DeviceTexels:
        if isinstance(source, CompressedTexture):
            texture, levels = upload_compressed(
                self._device, textures.load_blocks(source, self.folder)
            )
            self._stack.callback(texture.release)
            return DeviceTexels(source, texture, "rgba8", levels[0], tuple(levels[1:]))
        if isinstance(source, Output):
            image = textures.find_image(source, self.images)
            kind, format = textures.texture_kind(source, "", 0, image.layers), image.format
            images = textures.split_layers(image)
        else:
            kind, format = textures.texture_kind(source, "", 0), source.format
            images = textures.texture_contents(source, self.folder, self.images)
        mapped = isinstance(source, Texture) and source.upload == "map"
        texture = upload(self._device, kind, format, images, mapped=mapped)
        self._stack.callback(texture.release)
        values = images.layers[0] if kind == "2D" else np.stack(images.layers)
        smaller = tuple(images.smaller)
        if format in textures.DEPTH:  # rounded to its codes on the way
            height, width = images.layers[0].shape[:2]
            values = read_level(texture, format, 0, (width, height, len(images.layers)))
        if source.mipmaps is True:
            generate_levels(texture)
        if source.mipmaps is True or (smaller and format in textures.DEPTH):
            smaller = _read_smaller(texture, format, values)
        return DeviceTexels(source, texture, format, values, smaller)

    def new_sampler(self, source: TextureSource) -> int:
        made = make_sampler(source)
        self._stack.callback(GL.glDeleteSamplers, 1, [made])
        return made


def _read_smaller(texture: DeviceTexture, format: str, values: Array) -> tuple[Array, ...]:
    count = values.shape[0] if values.ndim == 4 else 1
    height, width = values.shape[-3:-1]
    levels = enumerate(level_sizes(width, height)[1:], start=1)
    return tuple(read_level(texture, format, level, (*size, count)) for level, size in levels)


def make_sampler(sampling: Sampling) -> int:
    name = int(GL.glGenSamplers(1))
    for call in sampler_calls(name, sampling):
        function, given = resolve_call(*call)
        getattr(GL, function)(*given)
    border = np.array(sampling.border, np.float32)
    GL.glSamplerParameterfv(name, GL.GL_TEXTURE_BORDER_COLOR, border)
    return name


def bind_images(
    device: Device, program: Any, images: Mapping[str, Texels], stack: ExitStack
) -> dict[str, DeviceTexture]:
    """Make textures of what the images hold, each bound to a separate unit, without those that have
    no effect; `stack` releases them. Raises UnsupportedError: one is too large for the driver."""
    found: dict[str, DeviceTexture] = {}
    for name, image in images.items():
        location = uniform_location(program, name)
        if location < 0:
            continue
        layers = [image.values] if image.kind == "2D" else list(image.values)
        texture = upload(device, image.kind, image.format, textures.Contents(layers))
        stack.callback(texture.release)
        # A texture whose levels end above what its filter reads counts as incomplete.
        GL.glBindTexture(texture.target, texture.glo)
        GL.glTexParameteri(texture.target, GL.GL_TEXTURE_MAX_LEVEL, 0)
        GL.glBindTexture(texture.target, 0)
        unit, internal = len(found), transfer(image.format).internal
        GL.glBindImageTexture(unit, texture.glo, 0, True, 0, GL.GL_READ_WRITE, internal)
        GL.glUseProgram(program.glo)
        GL.glUniform1i(location, unit)
        found[name] = texture
    return found


def read_images(
    made: Mapping[str, DeviceTexture], before: Mapping[str, Texels]
) -> dict[str, Image]:
    """Read what the images hold now, as outputs; of one without any effect what it held before."""
    left = {}
    for name, image in before.items():
        if name in made:
            height, width = image.values.shape[-3:-1]
            count = 1 if image.kind == "2D" else len(image.values)
            values = read_level(made[name], image.format, 0, (width, height, count))
            image = replace(image, values=values)
        left[name] = image_output(image)
    return left


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

    glGetTexImage may decode blocks in another way than samplers do: NVIDIA's driver does. Raises
    moderngl.Error: the driver can't fetch them."""
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
