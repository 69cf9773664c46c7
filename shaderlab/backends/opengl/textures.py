"""Textures on the device: made of images, and read back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shaderlab.backends.opengl import pixels
from shaderlab.backends.opengl.device import Device
from shaderlab.backends.opengl.formats import transfer
from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.errors import UnsupportedError
from shaderlab.frame import Array
from shaderlab.programs.formats import format_of

# OpenGL 4.5 core profile: the binding points, and the first of a cube's six images.
TARGETS = {"2D": 0x0DE1, "2DArray": 0x8C1A, "Cube": 0x8513, "2DMS": 0x9100}
_FIRST_FACE = 0x8515


@dataclass(frozen=True)
class DeviceTexture:
    """A texture's name on the device, and the kind of its samplers, as in `Texels.kind`."""

    glo: int
    kind: str

    @property
    def target(self) -> int:
        """The binding point."""
        return TARGETS[self.kind]

    def release(self) -> None:
        """Give its memory back."""
        GL.glDeleteTextures(1, [self.glo])


def upload(
    device: Device, kind: str, format: str, layers: Sequence[Array], smaller: Sequence[Array] = ()
) -> DeviceTexture:
    """A texture with these images: one, or an array's layers, or a cube's six faces.

    `smaller` are further levels of a plain texture. All images have one size.

    Raises:
        UnsupportedError: the texture is too large for the driver.
    """
    height, width = layers[0].shape[:2]
    limit = int(device.context.info["GL_MAX_TEXTURE_SIZE"])
    if max(width, height) > limit:
        raise UnsupportedError(f"a texture of {width} × {height}: this driver ends at {limit}")
    made = DeviceTexture(int(GL.glGenTextures(1)), kind)
    form = transfer(format)
    GL.glBindTexture(made.target, made.glo)
    if kind == "2DArray":
        size = (width, height, len(layers))
        pixels.tex_image_3d(made.target, 0, size, form, np.stack(layers))
    elif kind == "Cube":
        for face, image in enumerate(layers):
            pixels.tex_image_2d(_FIRST_FACE + face, 0, (width, height), form, image)
    else:
        for level, image in enumerate((*layers, *smaller)):
            of_level = (image.shape[1], image.shape[0])
            pixels.tex_image_2d(made.target, level, of_level, form, image)
    GL.glBindTexture(made.target, 0)
    return made


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
    GL.glBindTexture(texture.target, texture.glo)
    if texture.kind == "Cube":
        for face in range(count):
            pixels.get_tex_image(_FIRST_FACE + face, level, form, values[face])
    else:
        pixels.get_tex_image(texture.target, level, form, values)
    GL.glBindTexture(texture.target, 0)
    return values[0] if texture.kind == "2D" else values
