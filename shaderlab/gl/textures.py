"""Textures: from what a case gives to exact values, and from there onto the device."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.errors import CaseError, UnsupportedError
from shaderlab.frame import Array, Image
from shaderlab.gl import formats, pixels
from shaderlab.gl.device import Device
from shaderlab.model.textures import level_sizes

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
        from OpenGL import GL

        GL.glDeleteTextures(1, [self.glo])


def texel_values(image: Any, format: str, folder: Path, owner: str = "a texture") -> Array:
    """The array that will be uploaded: (height, width, channels) of the format's own type.

    Floats for an 8-bit format are taken as 0…1 and rounded to the nearest code.

    Args:
        image: an array, a function that makes one, an image file's path, or a `frame.Image`.
        format: the texture's format.
        folder: where relative paths begin.
        owner: what the image is for, for errors.

    Raises:
        CaseError: the array's shape does not fit the format.
        AssetError: an image file can't be read.
    """
    depth = format in formats.DEPTH
    wanted: Any = np.float32 if depth else formats.COLOR[format].numpy
    channels = 1 if depth else formats.COLOR[format].components
    if isinstance(image, str | Path):
        from shaderlab.pictures import load

        image = load(folder / image)
    if isinstance(image, Image):
        codes = image.values.dtype == np.uint8 and wanted is not np.uint8
        values = image.values / 255.0 if codes else image.values
    else:
        values = np.asarray(image() if callable(image) else image)
    if values.ndim == 2:
        values = values[:, :, None]
    if values.ndim != 3 or values.shape[2] < channels or 0 in values.shape:
        raise CaseError(
            f"{owner}: a {format} texture takes (height, width, {channels}), not {values.shape}"
        )
    values = values[:, :, :channels]
    if wanted is np.uint8 and values.dtype.kind == "f":
        values = np.rint(np.clip(values, 0.0, 1.0) * 255.0)
    return np.ascontiguousarray(values.astype(wanted))


def check_levels(first: Array, smaller: Sequence[Array]) -> None:
    """Raise CaseError unless these are all the levels below `first`, in order."""
    sizes = level_sizes(first.shape[1], first.shape[0])[1:]
    given = [(level.shape[1], level.shape[0]) for level in smaller]
    if given != sizes:
        listed = ", ".join(f"{w} × {h}" for w, h in given) or "nothing"
        raise CaseError(
            f"a texture of {first.shape[1]} × {first.shape[0]}: its smaller mipmap levels are "
            f"{listed}",
            remedy=f"mipmaps=True, or all of {', '.join(f'{w} × {h}' for w, h in sizes)}",
        )


def upload(
    device: Device, kind: str, format: str, layers: Sequence[Array], smaller: Sequence[Array] = ()
) -> DeviceTexture:
    """A texture with these images: one, or an array's layers, or a cube's six faces.

    `smaller` are further levels of a plain texture. All images have one size.

    Raises:
        UnsupportedError: the texture is too large for the driver.
    """
    from OpenGL import GL

    height, width = layers[0].shape[:2]
    limit = int(device.context.info["GL_MAX_TEXTURE_SIZE"])
    if max(width, height) > limit:
        raise UnsupportedError(f"a texture of {width} × {height}: this driver ends at {limit}")
    made = DeviceTexture(int(GL.glGenTextures(1)), kind)
    moved = formats.transfer(format)
    place = (moved.components, moved.type)
    GL.glBindTexture(made.target, made.glo)
    if kind == "2DArray":
        size = (width, height, len(layers))
        pixels.tex_image_3d(made.target, 0, moved.internal, size, place, np.stack(layers))
    elif kind == "Cube":
        for face, image in enumerate(layers):
            pixels.tex_image_2d(
                _FIRST_FACE + face, 0, moved.internal, (width, height), place, image
            )
    else:
        for level, image in enumerate((*layers, *smaller)):
            of_level = (image.shape[1], image.shape[0])
            pixels.tex_image_2d(made.target, level, moved.internal, of_level, place, image)
    GL.glBindTexture(made.target, 0)
    return made


def generate_levels(texture: DeviceTexture) -> None:
    """Have the driver make all smaller levels."""
    from OpenGL import GL

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
    from OpenGL import GL

    width, height, count = size
    moved = formats.transfer(format)
    depth = format in formats.DEPTH
    kind: Any = np.float32 if depth else formats.COLOR[format].numpy
    shape = (height, width, 1 if depth else formats.COLOR[format].components)
    values = np.empty((count, *shape), kind)
    GL.glBindTexture(texture.target, texture.glo)
    place = (moved.components, moved.type)
    if texture.kind == "Cube":
        for face in range(count):
            pixels.get_tex_image(_FIRST_FACE + face, level, place, values[face])
    else:
        pixels.get_tex_image(texture.target, level, place, values)
    GL.glBindTexture(texture.target, 0)
    return values[0] if texture.kind == "2D" else values
