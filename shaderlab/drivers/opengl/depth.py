"""Depth and stencil attachments: textures that later passes can sample, and their read-back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Image
from shaderlab.model.scene import Target

from ..attachments import of_several_samples
from ..programs.formats import DEPTH
from .pyopengl import GL, GL_1_0
from .textures import DeviceTexture, address, depth_storage, tightly_packed

NO_TEXTURE = 'Target(depth_storage="texture"): no sampler reads a renderbuffer'
_COMPLETE = 0x8CD5


@dataclass(frozen=True)
class Attached:
    """A depth attachment: a texture or a renderbuffer."""

    texture: DeviceTexture | None
    renderbuffer: int | None = None

    def release(self) -> None:
        """Release its memory."""
        if self.texture is not None:
            self.texture.release()
        if self.renderbuffer is not None:
            GL.glDeleteRenderbuffers(1, [self.renderbuffer])


def attach_depth(framebuffer: Any, target: Target, size: tuple[int, int]) -> Attached:
    """Give a framebuffer the depth of a target, and stencil if the format has it.

    Raises:
        UnsupportedError: the driver can't draw with such a format.
    """
    word, samples = target.depth, target.samples
    assert word is not None
    made_as = depth_storage(word)
    stencil = DEPTH[word].stencil
    point = GL.GL_DEPTH_STENCIL_ATTACHMENT if stencil else GL.GL_DEPTH_ATTACHMENT
    framebuffer.use()
    if samples or target.depth_storage == "renderbuffer":
        buffer = int(GL.glGenRenderbuffers(1))
        GL.glBindRenderbuffer(GL.GL_RENDERBUFFER, buffer)
        kind = GL.GL_RENDERBUFFER
        if samples:
            GL.glRenderbufferStorageMultisample(kind, samples, made_as.internal, *size)
        else:
            GL.glRenderbufferStorage(kind, made_as.internal, *size)
        GL.glFramebufferRenderbuffer(GL.GL_FRAMEBUFFER, point, GL.GL_RENDERBUFFER, buffer)
        made = Attached(None, buffer)
    else:
        texture = DeviceTexture.new("2D")
        GL_1_0.glTexImage2D(
            texture.target, 0, made_as.internal, *size, 0, made_as.components, made_as.type, None
        )
        GL.glTexParameteri(texture.target, GL.GL_TEXTURE_MIN_FILTER, GL.GL_NEAREST)
        GL.glTexParameteri(texture.target, GL.GL_TEXTURE_MAG_FILTER, GL.GL_NEAREST)
        GL.glBindTexture(texture.target, 0)
        GL.glFramebufferTexture2D(GL.GL_FRAMEBUFFER, point, texture.target, texture.glo, 0)
        made = Attached(texture)
    status = GL.glCheckFramebufferStatus(GL.GL_FRAMEBUFFER)
    if status != _COMPLETE:
        made.release()
        raise UnsupportedError(f"a framebuffer with {word} (status 0x{status:04X})")
    return made


def read_depth(framebuffer: Any, target: Target, name: str, size: tuple[int, int]) -> Image:
    """ "depth" as float32 in 0…1, or "stencil" as bytes: (height, width, 1).

    Raises:
        UnsupportedError: the target has several samples a pixel.
    """
    if target.samples:
        raise of_several_samples(name)
    assert target.depth is not None
    width, height = size
    of_depth = name == "depth"
    values = np.empty((height, width, 1), np.float32 if of_depth else np.uint8)
    framebuffer.use()
    place = (GL.GL_DEPTH_COMPONENT, GL.GL_FLOAT)
    if not of_depth:
        place = (GL.GL_STENCIL_INDEX, GL.GL_UNSIGNED_BYTE)
    with tightly_packed():
        GL_1_0.glReadPixels(0, 0, width, height, *place, address(values))
    return Image(values, target.depth if of_depth else "stencil8")
