"""Render targets: a pass's attachments, cleared, drawn into, and read back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Variable
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Image
from shaderlab.model.scene import Target
from shaderlab.model.textures import CompressedTexture, Output, Sampling, TextureSource, level_sizes

from ..programs.textures import COLOR, DEPTH, blocks_of, contents, find_image, kind_of
from ..resources import UNREADABLE, Attachments, DeviceTexels, SceneTextures, multisampled_error
from .device import Device, Object, Objects
from .textures import (
    COMPRESSED,
    attached,
    draw_to_floats,
    fetched,
    program_of,
    read_pixels,
    require_filtered,
    stencil,
    stored,
    stored_depths,
    uploaded,
)


class RenderTarget(Attachments):
    """As `Attachments`, on a device."""

    def __init__(
        self, device: Device, target: Target, colors: Mapping[str, str], size: tuple[int, int]
    ) -> None:
        super().__init__(target, colors, size)
        self._device = device
        self._objects = Objects(device.gl)
        limit = int(device.info["max_texture_size"])
        if max(size) > limit:
            raise UnsupportedError(
                f"a target of {size[0]} × {size[1]}: this browser ends at {limit}"
            )
        self.samples = self._sample_count()
        self.textures = {name: self._texture(word) for name, word in self.colors.items()}
        self.depth_texture: Object | None = None
        if self.depth and self.samples == 1:
            self.depth_texture = self._texture(self.depth)
        self._drawn, self._depth_buffer = self._multisampled()
        self._frame = self._objects.new("Framebuffer")
        self._attached: dict[int, str] | None = None

    def release(self) -> None:
        self._objects.release()

    def bind(self, locations: Mapping[int, str]) -> None:
        """Draw into this target from now on, with a program that writes its outputs at these
        locations; outputs without an attachment here go nowhere."""
        gl = self._device.gl
        gl.bindFramebuffer(gl.FRAMEBUFFER, self._frame)
        if self._attached == locations:
            return
        for place in (self._attached or {}).keys() - locations.keys():
            self._attach(f"COLOR_ATTACHMENT{place}", None)
        for place, name in locations.items():
            images = self._drawn if self.samples > 1 else self.textures
            self._attach(f"COLOR_ATTACHMENT{place}", images[name])
        if self.depth and self._attached is None:
            self._attach(self._depth_point, self._depth_buffer or self.depth_texture)
        count = max(locations, default=-1) + 1
        gl.drawBuffers([
            getattr(gl, f"COLOR_ATTACHMENT{place}") if place in locations else gl.NONE
            for place in range(count)
        ])  # fmt: skip
        self._attached = dict(locations)
        if locations:
            gl.ask_later(self._check, "checkFramebufferStatus", gl.FRAMEBUFFER)

    def _check(self, status: int) -> None:
        if status != self._device.gl.FRAMEBUFFER_COMPLETE:
            raise UnsupportedError(
                f"drawing to {', '.join((*self.colors.values(), self.depth))}: WebGL2 says that "
                f"the framebuffer is incomplete ({status:#x})"
            )

    def clear(self) -> None:
        gl, target = self._device.gl, self._target
        gl.disable(gl.SCISSOR_TEST)
        gl.disable(gl.RASTERIZER_DISCARD)
        gl.colorMask(True, True, True, True)
        gl.depthMask(True)
        gl.stencilMask(0xFF)
        for start in range(0, len(self.colors), _AT_ONCE):
            names = list(self.colors)[start : start + _AT_ONCE]
            self.bind(dict(enumerate(names)))
            for place, name in enumerate(names):
                kind = COLOR[self.colors[name]]
                call = {"u": gl.clearBufferuiv, "i": gl.clearBufferiv}.get(
                    kind.scalar, gl.clearBufferfv
                )
                values = [int(v) if kind.integer else float(v) for v in target.clear]
                call(gl.COLOR, place, values)
        if not self.colors:
            self.bind({})
        if self.depth:
            gl.clearBufferfv(gl.DEPTH, 0, [target.clear_depth])
            if DEPTH[self.depth].stencil:
                gl.clearBufferiv(gl.STENCIL, 0, [target.clear_stencil])

    def resolve(self) -> None:
        if self.samples == 1:
            return
        gl = self._device.gl
        box = (0, 0, *self.size)
        gl.disable(gl.SCISSOR_TEST)
        for name in self.colors:
            with Objects(gl) as own:
                one, other = own.new("Framebuffer"), own.new("Framebuffer")
                gl.bindFramebuffer(gl.READ_FRAMEBUFFER, one)
                gl.framebufferRenderbuffer(
                    gl.READ_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, self._drawn[name]
                )
                gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, other)
                gl.framebufferTexture2D(
                    gl.DRAW_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, self.textures[name], 0
                )
                gl.blitFramebuffer(*box, *box, gl.COLOR_BUFFER_BIT, gl.NEAREST)

    def sample_positions(self) -> Array:
        return sample_positions(self._device, self.samples)

    def read(self, name: str) -> Image:
        if name in self.colors:
            word = self.colors[name]
            return Image(attached(self._device, self.textures[name], word, self.size), word)
        if self.depth_texture is None:
            raise multisampled_error(name)
        if name == "stencil":
            own = {self._depth_point: self.depth_texture}
            return Image(stencil(self._device, own, self.size), "stencil8")
        values = fetched(self._device, self.depth_texture, self.size)
        return Image(np.ascontiguousarray(values[..., :1]), self.depth)

    @property
    def _depth_point(self) -> str:
        stencil = DEPTH[self.depth].stencil
        return "DEPTH_STENCIL_ATTACHMENT" if stencil else "DEPTH_ATTACHMENT"

    def _texture(self, word: str) -> Object:
        gl, made = self._device.gl, self._objects.new("Texture")
        gl.activeTexture(gl.TEXTURE0)
        gl.bindTexture(gl.TEXTURE_2D, made)
        gl.texStorage2D(gl.TEXTURE_2D, 1, getattr(gl, stored(word).internal), *self.size)
        return made

    def _multisampled(self) -> tuple[dict[str, Object], Object | None]:
        """Buffers of several samples a pixel: the colours' and the depth's."""
        gl = self._device.gl
        if self.samples == 1:
            return {}, None

        def buffer(word: str) -> Object:
            made = self._objects.new("Renderbuffer")
            gl.bindRenderbuffer(gl.RENDERBUFFER, made)
            gl.renderbufferStorageMultisample(
                gl.RENDERBUFFER, self.samples, getattr(gl, stored(word).internal), *self.size
            )
            return made

        colors = {name: buffer(word) for name, word in self.colors.items()}
        return colors, buffer(self.depth) if self.depth else None

    def _attach(self, point: str, image: Object | None) -> None:
        gl = self._device.gl
        place = getattr(gl, point)
        if self.samples > 1:
            gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, image)
        else:
            gl.framebufferTexture2D(gl.FRAMEBUFFER, place, gl.TEXTURE_2D, image, 0)

    def _sample_count(self) -> int:
        """How many samples a pixel gets: as many as are asked for, or as OpenGL has it, the next
        number above that the device offers for all formats."""
        asked = self._target.samples
        if not asked:
            return 1
        gl = self._device.gl
        words = [*self.colors.values(), *([self.depth] if self.depth else [])]
        offered = {1, 2, 4, 8, 16}
        for word in words:
            own = self._device.samples_offered(getattr(gl, stored(word).internal))
            offered &= {1, *own}
        found = sorted(count for count in offered if count >= asked)
        if not found:
            what = ", ".join(words)
            raise UnsupportedError(f"{asked} samples of {what}: WebGL2 offers {max(offered)} here")
        return found[0]


_AT_ONCE = 8


_EXTENSION = "OES_sample_variables"
_TELLING = """#version 300 es
#extension GL_OES_sample_variables : require
precision highp float;
uniform int number;
out vec4 color;
void main() {
    if (gl_SampleID != number) discard;
    color = vec4(gl_SamplePosition, 0.0, 1.0);
}
"""


def sample_positions(device: Device, samples: int) -> Array:
    """The places of a pixel's samples, (samples, 2), from its lower left corner, by a shader that
    says it of one sample after the other. Source: Khronos, OES_sample_variables.

    Raises:
        UnsupportedError: the browser does not say.
    """
    device.require(_EXTENSION, "sample positions")
    gl, found = device.gl, []
    with Objects(gl) as own:
        program = program_of(device, _TELLING)
        # What is read is the average of all samples, of which one is not zero.
        frame = draw_to_floats(device, own, (1, 1))
        several, buffer = own.new("Framebuffer"), own.new("Renderbuffer")
        gl.bindRenderbuffer(gl.RENDERBUFFER, buffer)
        gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, gl.RGBA32F, 1, 1)
        location = gl.new("getUniformLocation", program, "number")
        for number in range(samples):
            gl.bindFramebuffer(gl.FRAMEBUFFER, several)
            gl.framebufferRenderbuffer(
                gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, buffer
            )
            gl.clearBufferfv(gl.COLOR, 0, [0.0, 0.0, 0.0, 0.0])
            gl.uniform1i(location, number)
            gl.drawArrays(gl.TRIANGLES, 0, 3)
            gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, frame)
            gl.blitFramebuffer(0, 0, 1, 1, 0, 0, 1, 1, gl.COLOR_BUFFER_BIT, gl.NEAREST)
            gl.bindFramebuffer(gl.FRAMEBUFFER, frame)
            x, y, _, share = read_pixels(device, "rgba32f", (1, 1))[0, 0]
            found.append((x / share, y / share))
    return np.array(found, np.float32)


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
