"""Compressed textures: blocks onto the device, and what the driver decodes them to."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shaderlab.backends.opengl import pixels, textures
from shaderlab.backends.opengl.device import Device
from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.backends.opengl.textures import DeviceTexture
from shaderlab.errors import UnsupportedError
from shaderlab.frame import Array
from shaderlab.model import CompressedTexture
from shaderlab.model.textures import level_sizes
from shaderlab.programs.compressed import blocks_of

# OpenGL's number, the extension that brings it, and the version that has it without.
_FORMATS = {
    "etc2_rgb8": (0x9274, "GL_ARB_ES3_compatibility", 430),
    "etc2_eac_rgba8": (0x9278, "GL_ARB_ES3_compatibility", 430),
    "bc1": (0x83F0, "GL_EXT_texture_compression_s3tc", 10**6),
    "bc3": (0x83F3, "GL_EXT_texture_compression_s3tc", 10**6),
    "bc7": (0x8E8C, "GL_ARB_texture_compression_bptc", 420),
}


def upload(
    device: Device, source: CompressedTexture, folder: Path
) -> tuple[DeviceTexture, list[Array]]:
    """A texture of the source's blocks, and each level as the driver decodes it: codes (height,
    width, 4).

    Raises:
        CaseError: a level has another number of bytes than its size asks for.
        AssetError: the file can't be read; see `read_dds`.
        UnsupportedError: the driver lacks the format; names the extension.
    """
    blocks = blocks_of(source, folder)
    internal, extension, version = _FORMATS[blocks.format]
    if device.version < version and extension not in device.context.extensions:
        raise UnsupportedError(f"{blocks.format} textures", remedy=f"this driver lacks {extension}")
    sizes = level_sizes(*blocks.size)[: len(blocks.levels)]
    made = DeviceTexture(int(GL.glGenTextures(1)), "2D")
    GL.glBindTexture(made.target, made.glo)
    for level, (size, data) in enumerate(zip(sizes, blocks.levels, strict=True)):
        pixels.compressed_tex_image_2d(made.target, level, internal, size, data)
    GL.glTexParameteri(made.target, GL.GL_TEXTURE_MAX_LEVEL, len(sizes) - 1)
    GL.glBindTexture(made.target, 0)
    decoded = [
        np.asarray(textures.read_level(made, "rgba8", level, (*size, 1)))
        for level, size in enumerate(sizes)
    ]
    return made, decoded
