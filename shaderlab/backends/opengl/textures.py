"""Textures on the device: made of images or of compressed blocks, and read back.

Pixels are moved as they lie in memory, through PyOpenGL's raw functions: its wrappers convert and
copy what they are given, and know neither half floats nor packed depth and stencil.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from shaderlab.backends.opengl.device import Device
from shaderlab.backends.opengl.formats import transfer
from shaderlab.backends.opengl.pyopengl import GL, GL_1_0, GL_1_2, GL_1_3
from shaderlab.errors import UnsupportedError
from shaderlab.frame import Array
from shaderlab.model.textures import level_sizes
from shaderlab.programs.compressed import Blocks
from shaderlab.programs.formats import format_of
from shaderlab.programs.textures import Contents

# OpenGL 4.5 core profile: the binding points, and the first of a cube's six images.
TARGETS = {"2D": 0x0DE1, "2DArray": 0x8C1A, "Cube": 0x8513, "2DMS": 0x9100}
_FIRST_FACE = 0x8515
# OpenGL's number, the extension that brings it, and the version that has it without.
_COMPRESSED = {
    "etc2_rgb8": (0x9274, "GL_ARB_ES3_compatibility", 430),
    "etc2_eac_rgba8": (0x9278, "GL_ARB_ES3_compatibility", 430),
    "bc1": (0x83F0, "GL_EXT_texture_compression_s3tc", 10**6),
    "bc3": (0x83F3, "GL_EXT_texture_compression_s3tc", 10**6),
    "bc7": (0x8E8C, "GL_ARB_texture_compression_bptc", 420),
}


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
        return TARGETS[self.kind]

    def release(self) -> None:
        """Release its memory."""
        GL.glDeleteTextures(1, [self.glo])


def upload(device: Device, kind: str, format: str, images: Contents) -> DeviceTexture:
    """A texture with these images.

    Raises:
        UnsupportedError: it is too large for the driver.
    """
    height, width = images.layers[0].shape[:2]
    limit = int(device.context.info["GL_MAX_TEXTURE_SIZE"])
    if max(width, height) > limit:
        raise UnsupportedError(f"a texture of {width} × {height}: this driver ends at {limit}")
    made = DeviceTexture.new(kind)
    form = transfer(format)
    if kind == "2DArray":
        stacked = np.stack(images.layers)
        with tightly_packed():
            GL_1_2.glTexImage3D(
                made.target, 0, form.internal, width, height, len(stacked), 0,
                form.components, form.type, address(stacked),
            )  # fmt: skip
    elif kind == "Cube":
        for face, image in enumerate(images.layers):
            set_image(_FIRST_FACE + face, 0, format, image)
    else:
        for level, image in enumerate((*images.layers, *images.smaller)):
            set_image(made.target, level, format, image)
    GL.glBindTexture(made.target, 0)
    return made


def set_image(target: int, level: int, format: str, image: Array) -> None:
    """Fill one level of the texture that is bound."""
    form = transfer(format)
    height, width = image.shape[:2]
    with tightly_packed():
        GL_1_0.glTexImage2D(
            target, level, form.internal, width, height, 0, form.components, form.type,
            address(np.ascontiguousarray(image)),
        )  # fmt: skip


def upload_compressed(device: Device, blocks: Blocks) -> tuple[DeviceTexture, list[Array]]:
    """A texture of these blocks, and each level as the driver decodes it: codes (height, width,
    4).

    Raises:
        UnsupportedError: the driver lacks the format; names the extension.
    """
    internal, extension, version = _COMPRESSED[blocks.format]
    if device.version < version and extension not in device.context.extensions:
        raise UnsupportedError(f"{blocks.format} textures", remedy=f"this driver lacks {extension}")
    sizes = level_sizes(*blocks.size)[: len(blocks.levels)]
    made = DeviceTexture.new("2D")
    for level, (size, data) in enumerate(zip(sizes, blocks.levels, strict=True)):
        GL_1_3.glCompressedTexImage2D(made.target, level, internal, *size, 0, len(data), data)
    GL.glTexParameteri(made.target, GL.GL_TEXTURE_MAX_LEVEL, len(sizes) - 1)
    GL.glBindTexture(made.target, 0)
    return made, [read_level(made, "rgba8", level, (*s, 1)) for level, s in enumerate(sizes)]


def generate_levels(texture: DeviceTexture) -> None:
    """Have the driver make all smaller levels."""
    GL.glBindTexture(texture.target, texture.glo)
    GL.glGenerateMipmap(texture.target)
    # llvmpipe (Mesa 22.3) draws the levels later, and hands out empty ones until it has.
    GL.glFinish()
    GL.glBindTexture(texture.target, 0)


def read_level(
    texture: DeviceTexture, format: str, level: int, size: tuple[int, int, int]
) -> Array:
    """One level as it is on the device: (height, width, channels), or of an array or a cube
    (layers, height, width, channels).

    Args:
        texture: what to read.
        format: its format.
        level: 0 is the largest.
        size: the level's (width, height, layers).
    """
    width, height, count = size
    form, kind = transfer(format), format_of(format)
    values = np.empty((count, height, width, kind.components), kind.numpy)
    cube = texture.kind == "Cube"
    GL.glBindTexture(texture.target, texture.glo)
    with tightly_packed():
        for number, part in enumerate(values if cube else [values]):
            target = _FIRST_FACE + number if cube else texture.target
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
