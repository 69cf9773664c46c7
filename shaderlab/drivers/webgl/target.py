"""Render targets in WebGL2: a pass's attachments, cleared, drawn into, and read back."""

from collections.abc import Mapping

import numpy as np

from shaderlab.errors import DriverError, UnsupportedError
from shaderlab.model.frame import Array, Image

from ..programs.textures import COLOR, DEPTH
from ..resources import Attachments, multisampled_error
from . import textures
from .device import Device, Object, Objects


class RenderTarget(Attachments):
    _device: Device

    def _make(self) -> None:
        self._objects = Objects(self._device.gl)
        self.samples = self._sample_count()
        self.textures = {name: self._texture(word) for name, word in self.colors.items()}
        self.depth_texture: Object | None = None
        if self.depth and self.samples == 1:
            self.depth_texture = self._texture(self.depth)
        self._drawn, self._depth_buffer = self._make_buffers()
        self._frame = self._objects.new("Framebuffer")
        self._attached: dict[int, str] | None = None

    def release(self) -> None:
        self._objects.close()

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
        words = [f"COLOR_ATTACHMENT{n}" if n in locations else "NONE" for n in range(count)]
        gl.drawBuffers([getattr(gl, word) for word in words])
        self._attached = dict(locations)
        if locations:
            gl.ask_later(self._check, "checkFramebufferStatus", gl.FRAMEBUFFER)

    def _check(self, status: int) -> None:
        gl = self._device.gl
        if status != gl.FRAMEBUFFER_COMPLETE:
            # A format that is not drawn to makes an attachment incomplete; all else is a mistake.
            formats = (gl.FRAMEBUFFER_UNSUPPORTED, gl.FRAMEBUFFER_INCOMPLETE_ATTACHMENT)
            raise (UnsupportedError if status in formats else DriverError)(
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
        return measure_sample_positions(self._device, self.samples)

    def read(self, name: str) -> Image:
        if name in self.colors:
            word = self.colors[name]
            return Image(
                textures.read_attached(self._device, self.textures[name], word, self.size), word
            )
        if self.depth_texture is None:
            raise multisampled_error(name)
        if name == "stencil":
            own = {self._depth_point: self.depth_texture}
            return Image(textures.read_stencil(self._device, own, self.size), "stencil8")
        values = textures.fetch_texels(self._device, self.depth_texture, self.size)
        return Image(np.ascontiguousarray(values[..., :1]), self.depth)

    @property
    def _depth_point(self) -> str:
        stencil = DEPTH[self.depth].stencil
        return "DEPTH_STENCIL_ATTACHMENT" if stencil else "DEPTH_ATTACHMENT"

    def _texture(self, word: str) -> Object:
        gl, made = self._device.gl, self._objects.new("Texture")
        gl.activeTexture(gl.TEXTURE0)
        gl.bindTexture(gl.TEXTURE_2D, made)
        gl.texStorage2D(
            gl.TEXTURE_2D, 1, getattr(gl, textures.texture_format(word).internal), *self.size
        )
        return made

    def _make_buffers(self) -> tuple[dict[str, Object], Object | None]:
        """Buffers of several samples a pixel: the colours' and the depth's."""
        gl = self._device.gl
        if self.samples == 1:
            return {}, None

        def buffer(word: str) -> Object:
            made = self._objects.new("Renderbuffer")
            gl.bindRenderbuffer(gl.RENDERBUFFER, made)
            internal = getattr(gl, textures.texture_format(word).internal)
            gl.renderbufferStorageMultisample(gl.RENDERBUFFER, self.samples, internal, *self.size)
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
        """Return a pixel's samples: as in OpenGL, the next number offered for all formats."""
        asked = self._target.samples
        if not asked:
            return 1
        gl = self._device.gl
        words = [*self.colors.values(), *([self.depth] if self.depth else [])]
        offered = {1, 2, 4, 8, 16}
        for word in words:
            offered &= {1, *gl.ask("samples", getattr(gl, textures.texture_format(word).internal))}
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


def measure_sample_positions(device: Device, samples: int) -> Array:
    """Return the places of a pixel's samples, (samples, 2), from its lower left corner, by a shader
    that says it of one sample after the other. Source: Khronos, OES_sample_variables. Raises
    UnsupportedError: the browser does not say."""
    device.require(_EXTENSION, "sample positions")
    gl, found = device.gl, []
    with Objects(gl) as own:
        program = textures.use_own_program(device, _TELLING)
        # What is read is the average of all samples, of which one is not zero.
        frame = textures.draw_to_floats(device, own, (1, 1))
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
            x, y, _, share = textures.read_pixels(device, "rgba32f", (1, 1))[0, 0]
            found.append((x / share, y / share))
    return np.array(found, np.float32)
