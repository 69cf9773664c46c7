"""The textures of one scene on the device: uploaded once, attachments of earlier passes among
them; what they hold as exact values, and their binding to a program's samplers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from shaderlab.backends.opengl import compressed, samplers, textures
from shaderlab.backends.opengl.device import Device
from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.backends.opengl.target import RenderTarget
from shaderlab.backends.opengl.textures import DeviceTexture
from shaderlab.errors import CaseError, nearest
from shaderlab.frame import Array, Image, Texels
from shaderlab.glsl.interface import Variable
from shaderlab.model import (
    CompressedTexture,
    CubeTexture,
    Output,
    Scene,
    Texture,
    TextureArray,
    TextureSource,
)
from shaderlab.model.textures import level_sizes
from shaderlab.programs.formats import DEPTH
from shaderlab.programs.textures import check_levels, check_sampler, kind_of, texel_values


class BoundTextures:
    """What a scene's samplers read.

    Args:
        device: where it is.
        scene: whose textures these are.
        images: what its passes have drawn so far, by (pass, output).
        targets: the passes' targets, likewise.
        stack: gives device memory back at the end of the scene.
    """

    def __init__(
        self,
        device: Device,
        scene: Scene,
        images: Mapping[tuple[str, str], Image],
        targets: Mapping[str, RenderTarget],
        stack: ExitStack,
    ) -> None:
        self._device = device
        self._folder = Path(scene.case.file).parent
        self._images = images
        self._targets = targets
        self._stack = stack
        self._samplers = samplers.Samplers()
        stack.callback(self._samplers.release)
        # The source is kept too, so that no other one gets its id.
        self._made: dict[int, tuple[TextureSource, DeviceTexture, Array, tuple[Array, ...]]] = {}
        self._smaller: dict[tuple[str, str], tuple[Array, ...]] = {}
        self._samples: dict[tuple[str, str], Array] = {}

    def texels(self, program: str, variable: Variable, source: TextureSource) -> Texels:
        """What a sampler will read, exactly.

        Raises:
            CaseError: the texture can't be made, or is none that such a sampler reads.
            AssetError: an image file can't be read.
        """
        kind = kind_of(source, variable.type, self._sample_count(source))
        format = self._format(source)
        check_sampler(program, variable, source, kind, format)
        values, smaller = self._values(source, kind)
        return Texels(
            values, source.filter, source.wrap, source.border,
            kind=kind, format=format, smaller=smaller, compare=source.compare, lod=source.lod,
            seamless=getattr(source, "seamless", True),
        )  # fmt: skip

    def bind(self, program: Any, unit: int, variable: Variable, source: TextureSource) -> bool:
        """Bind a texture to a unit, and the sampler to that; False if the program lacks it."""
        location = int(GL.glGetUniformLocation(program.glo, variable.name.encode()))
        if location < 0:
            return False
        kind = kind_of(source, variable.type, self._sample_count(source))
        texture = self._texture(source, kind)
        GL.glActiveTexture(GL.GL_TEXTURE0 + unit)
        GL.glBindTexture(texture.target, texture.glo)
        self._samplers.bind(unit, source)
        GL.glActiveTexture(GL.GL_TEXTURE0)
        GL.glUseProgram(program.glo)
        GL.glUniform1i(location, unit)
        if isinstance(source, CubeTexture):
            (GL.glEnable if source.seamless else GL.glDisable)(GL.GL_TEXTURE_CUBE_MAP_SEAMLESS)
        return True

    def _texture(self, source: TextureSource, kind: str) -> DeviceTexture:
        if not isinstance(source, Output):
            return self._upload(source)[0]
        self._image(source)
        self._levels_of(source)
        return self._targets[source.pass_name].texture(source.name, sampled=kind == "2DMS")

    def _values(self, source: TextureSource, kind: str) -> tuple[Array, tuple[Array, ...]]:
        if not isinstance(source, Output):
            _, values, smaller = self._upload(source)
            return values, smaller
        values = self._image(source).values
        if kind == "2DMS":
            return self._samples_of(source), ()
        return values, self._levels_of(source)

    def _format(self, source: TextureSource) -> str:
        if isinstance(source, CompressedTexture):
            return "rgba8"  # what its texels are once they are decoded
        return self._image(source).format if isinstance(source, Output) else source.format

    def _sample_count(self, source: TextureSource) -> int:
        if not isinstance(source, Output) or source.pass_name not in self._targets:
            return 0
        return self._targets[source.pass_name].samples

    def _samples_of(self, source: Output) -> Array:
        key = (source.pass_name, source.name)
        if key not in self._samples:
            self._samples[key] = self._targets[source.pass_name].read_samples(source.name)
        return self._samples[key]

    def _levels_of(self, source: Output) -> tuple[Array, ...]:
        """The smaller levels of an earlier output, made now if it is the first to need them."""
        if not source.mipmaps:
            return ()
        key = (source.pass_name, source.name)
        if key not in self._smaller:
            texture = self._targets[source.pass_name].texture(source.name)
            self._smaller[key] = _generated(
                texture, self._image(source).format, self._image(source).values
            )
        return self._smaller[key]

    def _upload(
        self, source: Texture | TextureArray | CubeTexture | CompressedTexture
    ) -> tuple[DeviceTexture, Array, tuple[Array, ...]]:
        if id(source) not in self._made:
            self._made[id(source)] = (source, *self._uploaded(source))
        return self._made[id(source)][1:]

    def _uploaded(
        self, source: Texture | TextureArray | CubeTexture | CompressedTexture
    ) -> tuple[DeviceTexture, Array, tuple[Array, ...]]:
        if isinstance(source, CompressedTexture):
            made, decoded = compressed.upload(self._device, source, self._folder)
            self._stack.callback(made.release)
            return made, decoded[0], tuple(decoded[1:])
        kind = kind_of(source, "", 0)
        given: list[Array] = []
        if isinstance(source, Texture):
            layers = [self._pixels(source.image, source.format, "Texture")]
            if not isinstance(source.mipmaps, bool):
                given = [
                    self._pixels(level, source.format, "Texture: a mipmap level")
                    for level in source.mipmaps
                ]
                check_levels(layers[0], given)
        elif isinstance(source, TextureArray):
            layers = self._stack_of(source.layers, source.format, "TextureArray: layer")
        else:
            layers = self._stack_of(source.faces, source.format, "CubeTexture: face")
            height, width = layers[0].shape[:2]
            if height != width:
                raise CaseError(f"CubeTexture: its faces are {width} × {height}, not square")
        made = textures.upload(self._device, kind, source.format, layers, given)
        self._stack.callback(made.release)
        values = layers[0]
        if kind != "2D" or source.format in DEPTH:
            # A depth is rounded to its format's codes on the way.
            size = (layers[0].shape[1], layers[0].shape[0], len(layers))
            values = textures.read_level(made, source.format, 0, size)
        smaller = tuple(given)
        if source.mipmaps is True:
            smaller = _generated(made, source.format, values)
        elif given and source.format in DEPTH:
            smaller = _read_smaller(made, source.format, values)
        return made, values, smaller

    def _stack_of(self, parts: Sequence[Any], format: str, owner: str) -> list[Array]:
        """The images of an array or a cube, all of one size."""
        found = [self._pixels(part, format, f"{owner} {n}") for n, part in enumerate(parts)]
        for index, image in enumerate(found):
            if image.shape != found[0].shape:
                raise CaseError(
                    f"{owner} {index} is {image.shape[1]} × {image.shape[0]}, "
                    f"the first one {found[0].shape[1]} × {found[0].shape[0]}"
                )
        return found

    def _pixels(self, image: Any, format: str, owner: str) -> Array:
        if isinstance(image, Output):
            image = self._image(image)
        return texel_values(image, format, self._folder, owner)

    def _image(self, source: Output) -> Image:
        key = (source.pass_name, source.name)
        if key not in self._images:
            known = [f"{p}.{n}" for p, n in self._images]
            raise CaseError(
                f"no earlier pass gives {source.pass_name}.{source.name}",
                remedy=nearest(f"{source.pass_name}.{source.name}", known),
            )
        return self._images[key]


def _generated(texture: DeviceTexture, format: str, values: Array) -> tuple[Array, ...]:
    textures.generate_levels(texture)
    return _read_smaller(texture, format, values)


def _read_smaller(texture: DeviceTexture, format: str, values: Array) -> tuple[Array, ...]:
    """The levels below the first, as the device has them."""
    count = values.shape[0] if values.ndim == 4 else 1
    height, width = values.shape[-3:-1]
    sizes = level_sizes(width, height)[1:]
    return tuple(
        textures.read_level(texture, format, level, (*size, count))
        for level, size in enumerate(sizes, start=1)
    )
