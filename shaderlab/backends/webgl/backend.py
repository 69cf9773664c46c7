"""WebGL2 behind the protocol of `shaderlab.backends`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager

from shaderlab.backends import Backend, Size
from shaderlab.backends.webgl import feedback, queries
from shaderlab.backends.webgl.device import Device
from shaderlab.backends.webgl.drawing import Drawing
from shaderlab.backends.webgl.linking import Linker
from shaderlab.backends.webgl.verdict import driver_verdict
from shaderlab.compiler.sources import Source
from shaderlab.errors import UnsupportedError
from shaderlab.frame import PassDraw
from shaderlab.model import Scene
from shaderlab.programs import captures
from shaderlab.programs.module_texts import as_drawn
from shaderlab.programs.prepare import Programs
from shaderlab.records import Verdict


class WebGLBackend(Backend):
    """Draws scenes in one browser; caches programs and captured fragments across scenes."""

    def __init__(self, device: Device) -> None:
        self.info = device.info
        self.device = device
        self.captures = captures.CaptureCache()
        self._linker = Linker(device)

    @contextmanager
    def session(
        self, scene: Scene, programs: Programs, size: Size, *, temporary_programs: bool = False
    ) -> Iterator[WebGLSession]:
        self.device.gl.start_afresh()
        with ExitStack() as stack:
            linker = self._linker
            if temporary_programs:
                linker = Linker(self.device, self._linker)
                stack.callback(linker.release)
            session = WebGLSession(self.device, linker, scene, programs, size, stack)
            session.cache = self.captures
            yield session

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        return driver_verdict(self.device, sources)

    def close(self) -> None:
        self.device.close()


class WebGLSession(Drawing):
    """One scene in a browser."""

    vertices = feedback.vertices
    probe_vertices = feedback.probe_vertices
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
