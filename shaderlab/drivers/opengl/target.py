"""Render targets: what draws write into, and what is read of it."""

from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

import moderngl
import numpy as np

from shaderlab.errors import DriverError, UnsupportedError
from shaderlab.model.frame import Array, Image
from shaderlab.model.state import State

from ..programs.textures import COLOR, DEPTH
from ..resources import UNREADABLE, Attachments, multisampled_error
from .device import GL, GL_1_0, Device, apply_state, gl_constant
from .textures import DeviceTexture, address, depth_storage, fetch_texels, tightly_packed


class RenderTarget(Attachments):
    _device: Device

    def _make(self) -> None:
        samples, most = self._target.samples, self._device.context.max_samples
        if samples > most:
            raise UnsupportedError(f"{samples} samples: this driver offers {most}")
        self.samples = samples
        words = self.colors.values()
        self.textures = {name: self._texture(word) for name, word in self.colors.items()}
        self._sampled = [self._texture(word, samples) for word in words if samples]
        self._resolved = self._framebuffer(list(self.textures.values()))
        self._drawn = self._framebuffer(self._sampled) if samples else self._resolved
        self._made = ExitStack()
        for made in (*self.textures.values(), *self._sampled, self._resolved, self._drawn):
            self._made.callback(made.release)
        self._depth: DeviceTexture | None = None
        if self.depth:
            self._attach_depth()

    def release(self) -> None:
        self._made.close()

    def texture(self, name: str, *, sampled: bool = False) -> DeviceTexture:
        """A colour attachment, or "depth", as a texture; `sampled`: that of all samples. Raises
        UnsupportedError: it is kept in a way that no sampler can read."""
        if name in self.colors:
            if sampled:
                index = list(self.colors).index(name)
                return DeviceTexture(self._sampled[index].glo, "2DMS")
            return DeviceTexture(self.textures[name].glo, "2D")
        if name == "depth" and self._depth is not None:
            return self._depth
        remedy = UNREADABLE if self.samples else NO_TEXTURE
        raise UnsupportedError(f"sampling the {name} of this target", remedy=remedy)

    def clear(self) -> None:
        self.bind({name: index for index, name in enumerate(self.colors)})
        apply_state(State(), self.size, self._device.version)
        for index, word in enumerate(self.colors.values()):
            if COLOR[word].integer:
                values = np.array(self._target.clear, np.int32)
                GL.glClearBufferiv(GL.GL_COLOR, index, values)
            else:
                GL.glClearBufferfv(GL.GL_COLOR, index, np.array(self._target.clear, np.float32))
        if "depth" in self.attached:
            GL.glClearBufferfv(GL.GL_DEPTH, 0, np.array([self._target.clear_depth], np.float32))
        if "stencil" in self.attached:
            GL.glClearBufferiv(GL.GL_STENCIL, 0, np.array([self._target.clear_stencil], np.int32))
        # Bound again after the clear, or softpipe (Mesa 22.3.6) counts gl_FragCoord.y of a program
        # that drew before from the height that it drew into then.
        GL.glBindFramebuffer(GL.GL_DRAW_FRAMEBUFFER, 0)
        self._drawn.use()

    def bind(self, locations: Mapping[str, int]) -> None:
        """Draw into this target from now on, with a program that writes its outputs at these
        locations; outputs without an attachment here go nowhere."""
        self._drawn.use()
        places = [(locations.get(name, -1), n) for n, name in enumerate(self.colors)]
        attachments = {at: GL.GL_COLOR_ATTACHMENT0 + n for at, n in places if at >= 0}
        count = max(attachments, default=-1) + 1
        buffers = [attachments.get(location, GL.GL_NONE) for location in range(count)]
        GL.glDrawBuffers(count, np.array(buffers, np.uint32))

    def resolve(self) -> None:
        if self._drawn is self._resolved:
            return
        width, height = self.size
        GL.glDisable(GL.GL_SCISSOR_TEST)
        for index in range(len(self.colors)):
            GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, self._drawn.glo)
            GL.glBindFramebuffer(GL.GL_DRAW_FRAMEBUFFER, self._resolved.glo)
            GL.glReadBuffer(GL.GL_COLOR_ATTACHMENT0 + index)
            GL.glDrawBuffer(GL.GL_COLOR_ATTACHMENT0 + index)
            box = (0, 0, width, height)
            GL.glBlitFramebuffer(*box, *box, GL.GL_COLOR_BUFFER_BIT, GL.GL_NEAREST)

    def sample_positions(self) -> Array:
        self._drawn.use()
        found = np.empty((int(GL.glGetIntegerv(GL.GL_SAMPLES)), 2), np.float32)
        for index, position in enumerate(found):
            GL.glGetMultisamplefv(GL.GL_SAMPLE_POSITION, index, position)
        return found

    def read(self, name: str) -> Image:
        width, height = self.size
        if name in self.colors:
            kind = COLOR[self.colors[name]]
            values = np.empty((height, width, kind.components), kind.numpy)
            self.textures[name].read_into(values, alignment=1)
            return Image(values, self.colors[name])
        if self.samples:
            raise multisampled_error(name)
        values = np.empty((height, width, 1), np.float32 if name == "depth" else np.uint8)
        place = (GL.GL_DEPTH_COMPONENT, GL.GL_FLOAT)
        if name == "stencil":
            place = (GL.GL_STENCIL_INDEX, GL.GL_UNSIGNED_BYTE)
        self._drawn.use()
        with tightly_packed():
            GL_1_0.glReadPixels(0, 0, width, height, *place, address(values))
        return Image(values, self.depth if name == "depth" else "stencil8")

    def read_samples(self, name: str) -> Array:
        """Read all samples of a colour attachment: (samples, height, width, components)."""
        kind = COLOR[self.colors[name]]
        texture = self.texture(name, sampled=True)
        try:
            found = fetch_texels(self._device, "2DMS", texture.glo, [self.size] * self.samples)
        except moderngl.Error as error:
            raise UnsupportedError(f"fetching single samples: {str(error).strip()}") from error
        return np.stack(found)[..., : kind.components]

    def _texture(self, word: str, samples: int = 0) -> Any:
        # moderngl's word for the type of a component; sRGB is another format of the same.
        dtype = np.dtype(COLOR[word].numpy).str[1:].replace("u1", "f1")
        internal = {"internal_format": gl_constant(word)} if word == "srgb8_alpha8" else {}
        texture = self._device.context.texture(
            self.size, COLOR[word].components, dtype=dtype, samples=samples, **internal
        )
        if not samples:
            texture.filter = (self._device.context.NEAREST,) * 2
            texture.repeat_x = texture.repeat_y = False  # later passes read its edge beyond it
        return texture

    def _framebuffer(self, textures: list[Any]) -> Any:
        if not textures:
            # moderngl makes none without a colour; nothing is drawn into this one.
            least = self._device.context.renderbuffer(self.size, components=1)
            return self._device.context.framebuffer(least)
        try:
            return self._device.context.framebuffer(textures)
        except moderngl.Error as error:
            raise self._explain_incomplete(str(error)) from error

    def _attach_depth(self) -> None:
        form, samples, kind = depth_storage(self.depth), self.samples, GL.GL_RENDERBUFFER
        stencil = DEPTH[self.depth].stencil
        point = GL.GL_DEPTH_STENCIL_ATTACHMENT if stencil else GL.GL_DEPTH_ATTACHMENT
        self._drawn.use()
        if samples or self._target.depth_storage == "renderbuffer":
            buffer = int(GL.glGenRenderbuffers(1))
            self._made.callback(lambda: GL.glDeleteRenderbuffers(1, [buffer]))
            GL.glBindRenderbuffer(kind, buffer)
            if samples:
                GL.glRenderbufferStorageMultisample(kind, samples, form.internal, *self.size)
            else:
                GL.glRenderbufferStorage(kind, form.internal, *self.size)
            GL.glFramebufferRenderbuffer(GL.GL_FRAMEBUFFER, point, kind, buffer)
        else:
            self._depth = made = DeviceTexture.new("2D")
            self._made.callback(made.release)
            GL_1_0.glTexImage2D(
                made.target, 0, form.internal, *self.size, 0, form.components, form.type, None
            )
            GL.glTexParameteri(made.target, GL.GL_TEXTURE_MIN_FILTER, GL.GL_NEAREST)
            GL.glTexParameteri(made.target, GL.GL_TEXTURE_MAG_FILTER, GL.GL_NEAREST)
            GL.glBindTexture(made.target, 0)
            GL.glFramebufferTexture2D(GL.GL_FRAMEBUFFER, point, made.target, made.glo, 0)
        status = GL.glCheckFramebufferStatus(GL.GL_FRAMEBUFFER)
        if status != GL.GL_FRAMEBUFFER_COMPLETE:
            # What is said of another framebuffer tells nothing of what the driver lacks.
            own = int(GL.glGetIntegerv(GL.GL_FRAMEBUFFER_BINDING)) == self._drawn.glo
            lacking = own and status == GL.GL_FRAMEBUFFER_UNSUPPORTED
            self.release()
            kind = UnsupportedError if lacking else DriverError
            which = (
                "a framebuffer" if own else "another framebuffer than the target's is bound: one"
            )
            raise kind(f"{which} with {self.depth} (status 0x{status:04X})")

    def _explain_incomplete(self, said: str) -> Exception:
        """Explain why the framebuffer is not complete: memory, most of the time."""
        size = self.size[0] * self.size[1] * max(self._target.samples, 1)
        kinds = [COLOR[word] for word in self.colors.values()]
        wanted = size * sum(kind.components * np.dtype(kind.numpy).itemsize for kind in kinds)
        what = f"a target of {self.size[0]} × {self.size[1]} with {len(kinds)} attachments"
        if GL.GL_OUT_OF_MEMORY in iter(GL.glGetError, GL.GL_NO_ERROR) or wanted >= 1 << 30:
            return MemoryError(f"{what} takes {wanted / (1 << 30):.3g} GB")
        return (UnsupportedError if "UNSUPPORTED" in said else DriverError)(f"{what}: {said}")


NO_TEXTURE = 'Target(depth_storage="texture"): no sampler reads a renderbuffer'
