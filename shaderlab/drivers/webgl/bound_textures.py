"""The textures of one scene on the device: uploaded once, attachments of earlier passes among
them; what they hold as exact values, and the samplers that read them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.compiler.interface import Variable
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array
from shaderlab.model.textures import CompressedTexture, Output, Sampling, TextureSource, level_sizes

from ..attachments import UNREADABLE
from ..programs.compressed import blocks_of
from ..programs.formats import DEPTH
from ..programs.textures import contents, find_image, kind_of
from ..scene_textures import DeviceTexels, SceneTextures
from .calls import Object, Objects
from .device import Device
from .formats import COMPRESSED, require_filtered, stored, stored_depths, uploaded
from .reading import attached, fetched
from .target import RenderTarget

_TARGETS = {"2D": "TEXTURE_2D", "Cube": "TEXTURE_CUBE_MAP", "2DArray": "TEXTURE_2D_ARRAY"}
_NO_LEVELS = ("rgb32f", "r32i", "rg32i", "rgba32i", "r32ui", "rg32ui", "rgba32ui")


@dataclass(frozen=True)
class DeviceTexture:
    """A texture: `kind` as in `Texels.kind`, `size` (width, height) of its largest level."""

    handle: Object
    kind: str
    word: str
    size: tuple[int, int]
    layers: int = 1

    @property
    def target(self) -> str:
        """The constant of what it is bound as."""
        return _TARGETS[self.kind]


@dataclass(eq=False)
class BoundTextures(SceneTextures[RenderTarget]):
    """What a scene's samplers read. Arguments as of `SceneTextures`, and besides:

    Args:
        device: where they are made.
        own: what they are released with.
    """

    _device: Device
    _own: Objects
    _attachments: dict[tuple[str, str, bool], DeviceTexels] = field(
        default_factory=dict, init=False
    )
    _samplers: dict[tuple[Any, ...], Object] = field(default_factory=dict, init=False)

    def bind(self, unit: int, variable: Variable, source: TextureSource) -> None:
        """Bind a texture that `texels` has looked at to a unit, and its sampler."""
        gl, found = self._device.gl, self.find(source, self.kind(source, variable))
        require_filtered(self._device, found.format, source.filter, source.compare is not None)
        if "clamp_to_border" in source.wrap:
            raise UnsupportedError("clamp_to_border: textures have no border in WebGL2")
        if not getattr(source, "seamless", True):
            raise UnsupportedError("seamless=False: WebGL2 filters every cube across its edges")
        gl.activeTexture(gl.TEXTURE0 + unit)
        gl.bindTexture(getattr(gl, found.handle.target), found.handle.handle)
        gl.bindSampler(unit, self._sampler(source))

    def attachment(self, source: Output, kind: str) -> DeviceTexels:
        key = (source.pass_name, source.name, source.mipmaps)
        if key not in self._attachments:
            self._attachments[key] = self._attachment(source, kind)
        return self._attachments[key]

    def _attachment(self, source: Output, kind: str) -> DeviceTexels:
        if kind == "2DMS":
            raise UnsupportedError("sampler2DMS: WebGL2 has no multisampled textures")
        image, target = find_image(source, self.images), self.targets[source.pass_name]
        if source.name == "stencil":
            raise UnsupportedError("sampling the stencil of this target")
        drawn = target.textures.get(source.name, target.depth_texture)
        if drawn is None:
            raise UnsupportedError(
                f"sampling the {source.name} of this target",
                remedy=UNREADABLE,
            )
        texture = DeviceTexture(drawn, "2D", image.format, target.size)
        if not source.mipmaps:
            return DeviceTexels(source, texture, image.format, image.values)
        texture = self._new("2D", image.format, target.size, len(level_sizes(*target.size)))
        self._copy(drawn, texture)
        self._generate(texture)
        levels = self._smaller(texture)
        return DeviceTexels(source, texture, image.format, image.values, levels)

    def upload(self, source: TextureSource) -> DeviceTexels:
        assert not isinstance(source, Output)
        if isinstance(source, CompressedTexture):
            return self._compressed(source)
        kind, word = kind_of(source, "", 0), source.format
        if kind == "3D":
            raise UnsupportedError("sampler3D on this backend", remedy="--driver opengl draws it")
        images = contents(source, self.folder, self.images)
        height, width = images.layers[0].shape[:2]
        given: list[Sequence[Array]] = [images.layers, *([level] for level in images.smaller)]
        whole = source.mipmaps is True
        count = len(level_sizes(width, height)) if whole else len(given)
        texture = self._new(kind, word, (width, height), count, len(images.layers))
        for level, layers in enumerate(given):
            for layer, values in enumerate(layers):
                self._write(texture, level, layer, uploaded(word, values))
        values, smaller = images.layers[0], tuple(images.smaller)
        if kind != "2D":
            values = np.stack([stored_depths(word, each) for each in images.layers])
        elif word in DEPTH:  # a depth is rounded to its format's codes on the way
            values = fetched(self._device, texture.handle, texture.size)[..., :1]
            sizes = level_sizes(width, height)[1:count]
            smaller = tuple(
                fetched(self._device, texture.handle, size, level)[..., :1]
                for level, size in enumerate(sizes, start=1)
            )
        if whole:
            self._generate(texture)
            smaller = self._smaller(texture)
        return DeviceTexels(source, texture, word, values, smaller)

    def _compressed(self, source: CompressedTexture) -> DeviceTexels:
        gl, blocks = self._device.gl, blocks_of(source, self.folder)
        name, extension = COMPRESSED[blocks.format]
        self._device.require(extension, blocks.format)
        texture = DeviceTexture(self._own.new("Texture"), "2D", "rgba8", blocks.size)
        gl.activeTexture(gl.TEXTURE0)
        gl.bindTexture(gl.TEXTURE_2D, texture.handle)
        sizes = level_sizes(*blocks.size)[: len(blocks.levels)]
        constant = getattr(gl, name)
        gl.texStorage2D(gl.TEXTURE_2D, len(sizes), constant, *blocks.size)
        for level, (size, data) in enumerate(zip(sizes, blocks.levels, strict=True)):
            gl.compressedTexSubImage2D(gl.TEXTURE_2D, level, 0, 0, *size, constant, data)
        first, *smaller = (
            np.rint(fetched(self._device, texture.handle, size, level) * 255.0).astype(np.uint8)
            for level, size in enumerate(sizes)
        )
        return DeviceTexels(source, texture, "rgba8", first, tuple(smaller))

    def _new(
        self, kind: str, word: str, size: tuple[int, int], levels: int, layers: int = 1
    ) -> DeviceTexture:
        gl = self._device.gl
        texture = DeviceTexture(self._own.new("Texture"), kind, word, size, layers)
        gl.activeTexture(gl.TEXTURE0)
        target = getattr(gl, texture.target)
        gl.bindTexture(target, texture.handle)
        internal = getattr(gl, stored(word).internal)
        if kind == "2DArray":
            gl.texStorage3D(target, levels, internal, *size, layers)
        else:
            gl.texStorage2D(target, levels, internal, *size)
        return texture

    def _write(self, texture: DeviceTexture, level: int, layer: int, values: Array) -> None:
        """Write a level of one layer or face of the texture that is bound."""
        gl, word = self._device.gl, stored(texture.word)
        height, width = values.shape[:2]
        how = (getattr(gl, word.format), getattr(gl, word.type), values)
        if texture.kind == "2DArray":
            gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, level, 0, 0, layer, width, height, 1, *how)
        else:
            face = gl.TEXTURE_CUBE_MAP_POSITIVE_X + layer
            target = face if texture.kind == "Cube" else gl.TEXTURE_2D
            gl.texSubImage2D(target, level, 0, 0, width, height, *how)

    def _copy(self, drawn: Object, texture: DeviceTexture) -> None:
        """Copy an attachment to the first level of a texture, which is bound."""
        gl = self._device.gl
        with Objects(gl) as own:
            gl.bindFramebuffer(gl.FRAMEBUFFER, own.new("Framebuffer"))
            gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, drawn, 0)
            gl.copyTexSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 0, 0, *texture.size)

    def _generate(self, texture: DeviceTexture) -> None:
        """Halve each level into the next one."""
        gl = self._device.gl
        if texture.word in _NO_LEVELS or texture.word in DEPTH:
            raise UnsupportedError(f"mipmaps=True: WebGL2 makes no levels of {texture.word}")
        require_filtered(self._device, texture.word, ("linear", "linear"), False)
        gl.bindTexture(getattr(gl, texture.target), texture.handle)
        gl.generateMipmap(getattr(gl, texture.target))

    def _smaller(self, texture: DeviceTexture) -> tuple[Array, ...]:
        """The levels below the first, as the device has them."""
        if texture.kind == "2DArray":
            raise UnsupportedError("mipmaps=True of a texture array: WebGL2 can't read its levels")
        sizes = level_sizes(*texture.size)
        faces = ["2D"]
        if texture.kind == "Cube":
            faces = [f"CUBE_MAP_{way}_{axis}" for axis in "XYZ" for way in ("POSITIVE", "NEGATIVE")]
        found = []
        for level, size in enumerate(sizes[1:], start=1):
            each = [
                attached(self._device, texture.handle, texture.word, size, level=level, face=face)
                for face in faces
            ]
            found.append(each[0] if texture.kind == "2D" else np.stack(each))
        return tuple(found)

    def _sampler(self, sampling: Sampling) -> Object:
        """The sampler object of these filters and wraps, made once."""
        key = (sampling.filter, sampling.wrap, sampling.compare, sampling.lod)
        if key not in self._samplers:
            self._samplers[key] = self._new_sampler(sampling)
        return self._samplers[key]

    def _new_sampler(self, sampling: Sampling) -> Object:
        gl, made = self._device.gl, self._own.new("Sampler")
        compare = "NONE" if sampling.compare is None else "COMPARE_REF_TO_TEXTURE"
        for what, word in (
            ("MIN_FILTER", sampling.filter[0]), ("MAG_FILTER", sampling.filter[1]),
            ("WRAP_S", sampling.wrap[0]), ("WRAP_T", sampling.wrap[1]),
            ("WRAP_R", sampling.wrap[1]), ("COMPARE_MODE", compare),
            ("COMPARE_FUNC", sampling.compare or "lequal"),
        ):  # fmt: skip
            gl.samplerParameteri(made, getattr(gl, f"TEXTURE_{what}"), getattr(gl, word.upper()))
        gl.samplerParameterf(made, gl.TEXTURE_MIN_LOD, sampling.lod[0])
        gl.samplerParameterf(made, gl.TEXTURE_MAX_LOD, sampling.lod[1])
        return made
