"""WebGL2 behind the protocol of `shaderlab.backends`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager

from shaderlab.backends.device_backend import DeviceBackend
from shaderlab.backends.webgl import feedback, queries
from shaderlab.backends.webgl.device import Device
from shaderlab.backends.webgl.drawing import Drawing
from shaderlab.backends.webgl.linking import Linker
from shaderlab.backends.webgl.verdict import driver_verdict
from shaderlab.compiler.sources import Source
from shaderlab.errors import UnsupportedError
from shaderlab.frame import PassDraw
from shaderlab.programs.module_texts import as_drawn
from shaderlab.records import Verdict


class WebGLSession(Drawing):
    """One scene in a browser."""

    vertex_outputs = feedback.vertex_outputs
    attributes = queries.attributes
    blocks = queries.block_readings
    time = queries.timed

    def count(self, key: PassDraw, counter: str) -> int:
        raise UnsupportedError(f"counting {counter}: WebGL2 only says whether there was any")

    def locations(self, key: PassDraw) -> Mapping[str, int]:
        """As `Session.locations`: WebGL2 only says whether there is one, so they are counted."""
        draw = self.programs[key[0]][key[1]]
        program = self.linker.link(as_drawn(draw.draw, draw.texts), draw.sources)
        active = list(program.locations)
        return {
            name: active.index(name) if name in active else -1 for name in draw.interface.uniforms
        }

    def gl_errors(self, key: PassDraw) -> Sequence[int]:
        return self._gl_errors.get(key, ())


class WebGLBackend(DeviceBackend):
    """Draws scenes in one browser; caches programs and captured fragments across scenes."""

    linker_class = Linker
    session_class = WebGLSession
    device: Device

    def in_use(self) -> AbstractContextManager[object]:
        self.device.gl.start_afresh()
        return super().in_use()

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        return driver_verdict(self.device, sources)

    def close(self) -> None:
        self.device.close()
