"""Images that a compute shader reads and writes: textures bound to image units, and read back."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from shaderlab.model.frame import Image, Texels

from ..programs.images import output_of
from ..programs.textures import Contents
from .linking import uniform_location
from .pyopengl import GL
from .textures import DeviceTexture, read_level, transfer, upload

if TYPE_CHECKING:
    from .device import Device


def bound_images(
    device: Device, program: Any, images: Mapping[str, Texels], stack: ExitStack
) -> dict[str, DeviceTexture]:
    """Textures of what the images hold, each bound to a unit of its own; those without any effect
    are left out.

    Args:
        device: where they are.
        program: the linked program.
        images: what they hold.
        stack: releases them.

    Raises:
        UnsupportedError: one is too large for the driver.
    """
    found: dict[str, DeviceTexture] = {}
    for name, image in images.items():
        location = uniform_location(program, name)
        if location < 0:
            continue
        layers = [image.values] if image.kind == "2D" else list(image.values)
        texture = upload(device, image.kind, image.format, Contents(layers))
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
    textures: Mapping[str, DeviceTexture], before: Mapping[str, Texels]
) -> dict[str, Image]:
    """What the images hold now, as outputs; of one without any effect what it held before."""
    left = {}
    for name, image in before.items():
        if name in textures:
            height, width = image.values.shape[-3:-1]
            count = 1 if image.kind == "2D" else len(image.values)
            values = read_level(textures[name], image.format, 0, (width, height, count))
            image = replace(image, values=values)
        left[name] = output_of(image)
    return left
