"""Textures: from a case's `Texture` to exact values, and from there onto the device."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.frame import Array
from shaderlab.gl import formats
from shaderlab.gl.device import Device
from shaderlab.model import Texture

# OpenGL 4.5 core profile, table 8.15.
_FILTER = {
    "nearest": 0x2600,
    "linear": 0x2601,
    "nearest_mipmap_nearest": 0x2700,
    "linear_mipmap_nearest": 0x2701,
    "nearest_mipmap_linear": 0x2702,
    "linear_mipmap_linear": 0x2703,
}
_WRAP = {
    "repeat": 0x2901,
    "mirrored_repeat": 0x8370,
    "clamp_to_edge": 0x812F,
    "clamp_to_border": 0x812D,
}


def texel_values(texture: Texture, folder: Path) -> Array:
    """The array that will be uploaded: (height, width, channels) of the format's own type.

    Floats for an 8-bit format are taken as 0…1 and rounded to the nearest code.

    Raises:
        CaseError: the array's shape does not fit the format.
        AssetError: an image file can't be read.
    """
    kind = formats.COLOR[texture.format]
    image = texture.image
    if isinstance(image, str | Path):
        from shaderlab.pictures import load

        image = load(folder / image)
    values = np.asarray(image() if callable(image) else image)
    if values.ndim == 2:
        values = values[:, :, None]
    if values.ndim != 3 or values.shape[2] < kind.components or 0 in values.shape:
        raise CaseError(
            f"a {texture.format} texture takes (height, width, {kind.components}), "
            f"not {values.shape}"
        )
    values = values[:, :, : kind.components]
    if kind.numpy is np.uint8 and values.dtype.kind == "f":
        values = np.rint(np.clip(values, 0.0, 1.0) * 255.0)
    return np.ascontiguousarray(values.astype(kind.numpy))


def upload(device: Device, texture: Texture, values: Array) -> Any:
    """A `moderngl.Texture` with these values and the texture's filters, wraps and border."""
    from OpenGL import GL

    kind = formats.COLOR[texture.format]
    made = device.context.texture(
        (values.shape[1], values.shape[0]), kind.components, values, alignment=1, dtype=kind.dtype,
        **({} if kind.internal is None else {"internal_format": kind.internal}),
    )  # fmt: skip
    if "mipmap" in texture.filter[0]:
        made.build_mipmaps()
    GL.glBindTexture(GL.GL_TEXTURE_2D, made.glo)
    for name, number in (
        (GL.GL_TEXTURE_MIN_FILTER, _FILTER[texture.filter[0]]),
        (GL.GL_TEXTURE_MAG_FILTER, _FILTER[texture.filter[1]]),
        (GL.GL_TEXTURE_WRAP_S, _WRAP[texture.wrap[0]]),
        (GL.GL_TEXTURE_WRAP_T, _WRAP[texture.wrap[1]]),
    ):
        GL.glTexParameteri(GL.GL_TEXTURE_2D, name, number)
    border = np.array(texture.border, np.float32)
    GL.glTexParameterfv(GL.GL_TEXTURE_2D, GL.GL_TEXTURE_BORDER_COLOR, border)
    GL.glBindTexture(GL.GL_TEXTURE_2D, 0)
    return made
