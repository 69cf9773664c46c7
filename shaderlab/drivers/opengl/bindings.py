"""What a scene's samplers and images read: textures bound to their units, and their values."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Variable
from shaderlab.model.frame import Array, Image, Texels
from shaderlab.model.textures import (
    CompressedTexture,
    CubeTexture,
    Output,
    Sampling,
    Texture,
    TextureSource,
    level_sizes,
)

from ..programs.storage import image_output
from ..programs.textures import (
    DEPTH,
    Contents,
    find_image,
    load_blocks,
    split_layers,
    texture_contents,
    texture_kind,
)
from ..resources import DeviceTexels, SceneTextures
from .device import GL, Device, gl_constant
from .linking import uniform_location
from .target import RenderTarget
from .textures import (
    DeviceTexture,
    generate_levels,
    read_level,
    transfer,
    upload,
    upload_compressed,
)


@dataclass(eq=False)
class BoundTextures(SceneTextures[RenderTarget]):
    """What a scene's samplers read. Arguments as of `SceneTextures`, and besides:

    Args:
        device: where they are.
        stack: releases device memory at the end.
    """

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
        image = find_image(source, self.images)
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
            texture, levels = upload_compressed(self._device, load_blocks(source, self.folder))
            self._stack.callback(texture.release)
            return DeviceTexels(source, texture, "rgba8", levels[0], tuple(levels[1:]))
        if isinstance(source, Output):
            image = find_image(source, self.images)
            kind, format = texture_kind(source, "", 0, image.layers), image.format
            images = split_layers(image)
        else:
            kind, format = texture_kind(source, "", 0), source.format
            images = texture_contents(source, self.folder, self.images)
        mapped = isinstance(source, Texture) and source.upload == "map"
        texture = upload(self._device, kind, format, images, mapped=mapped)
        self._stack.callback(texture.release)
        values, smaller = images.layers[0], tuple(images.smaller)
        if kind != "2D" or format in DEPTH:
            # A depth is rounded to its format's codes on the way.
            size = (values.shape[1], values.shape[0], len(images.layers))
            values = read_level(texture, format, 0, size)
        if source.mipmaps is True:
            generate_levels(texture)
        if source.mipmaps is True or (smaller and format in DEPTH):
            smaller = _read_smaller(texture, format, values)
        return DeviceTexels(source, texture, format, values, smaller)

    def new_sampler(self, source: TextureSource) -> int:
        made = _new_sampler(source)
        self._stack.callback(GL.glDeleteSamplers, 1, [made])
        return made


def _read_smaller(texture: DeviceTexture, format: str, values: Array) -> tuple[Array, ...]:
    """Read the levels below the first, as the device has them."""
    count = values.shape[0] if values.ndim == 4 else 1
    height, width = values.shape[-3:-1]
    sizes = level_sizes(width, height)[1:]
    return tuple(
        read_level(texture, format, level, (*size, count))
        for level, size in enumerate(sizes, start=1)
    )


def _new_sampler(sampling: Sampling) -> int:
    """Make a sampler object. Source: OpenGL 4.5 core profile, table 8.15."""
    name = int(GL.glGenSamplers(1))
    compare = GL.GL_NONE if sampling.compare is None else GL.GL_COMPARE_REF_TO_TEXTURE
    along_r = [(GL.GL_TEXTURE_WRAP_R, gl_constant(word)) for word in sampling.wrap[2:]]
    for what, number in (
        (GL.GL_TEXTURE_MIN_FILTER, gl_constant(sampling.filter[0])),
        (GL.GL_TEXTURE_MAG_FILTER, gl_constant(sampling.filter[1])),
        (GL.GL_TEXTURE_WRAP_S, gl_constant(sampling.wrap[0])),
        (GL.GL_TEXTURE_WRAP_T, gl_constant(sampling.wrap[1])),
        *along_r,
        (GL.GL_TEXTURE_COMPARE_MODE, compare),
        (GL.GL_TEXTURE_COMPARE_FUNC, gl_constant(sampling.compare or "lequal")),
    ):
        GL.glSamplerParameteri(name, what, number)
    GL.glSamplerParameterf(name, GL.GL_TEXTURE_MIN_LOD, sampling.lod[0])
    GL.glSamplerParameterf(name, GL.GL_TEXTURE_MAX_LOD, sampling.lod[1])
    border = np.array(sampling.border, np.float32)
    GL.glSamplerParameterfv(name, GL.GL_TEXTURE_BORDER_COLOR, border)
    return name


def bind_images(
    device: Device, program: Any, images: Mapping[str, Texels], stack: ExitStack
) -> dict[str, DeviceTexture]:
    """Make textures of what the images hold, each bound to a separate unit, without those that have
    no effect.

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
    """Read what the images hold now, as outputs; of one without any effect what it held before."""
    left = {}
    for name, image in before.items():
        if name in textures:
            height, width = image.values.shape[-3:-1]
            count = 1 if image.kind == "2D" else len(image.values)
            values = read_level(textures[name], image.format, 0, (width, height, count))
            image = replace(image, values=values)
        left[name] = image_output(image)
    return left
