"""OpenGL behind the protocol of `shaderlab.backends`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager

from shaderlab.backends import Backend, Drawn, Session, Size
from shaderlab.backends.opengl import calls as api, capture, feedback, queries, storage, verdict
from shaderlab.backends.opengl.device import Device
from shaderlab.backends.opengl.drawing import Drawing
from shaderlab.backends.opengl.linking import Linker
from shaderlab.frame import (
    Array,
    AttributeReading,
    Bindings,
    BlockReading,
    Fragments,
    PassDraw,
    Reply,
    Samples,
    Timing,
)
from shaderlab.glsl.sources import Source
from shaderlab.model import Call, Program, Scene
from shaderlab.programs import captures
from shaderlab.programs.prepare import Programs
from shaderlab.programs.vertices import probed_mesh
from shaderlab.records import Verdict


class OpenGLBackend(Backend):
    """Draws scenes on one device; caches linked programs and captured fragments across scenes."""

    def __init__(self, device: Device) -> None:
        self.info = device.info
        self.device = device
        self.captures = captures.CaptureCache()
        self._linker = Linker(device)

    @contextmanager
    def session(
        self, scene: Scene, programs: Programs, size: Size, *, temporary_programs: bool = False
    ) -> Iterator[OpenGLSession]:
        linker = Linker(self.device, self._linker) if temporary_programs else self._linker
        with self.device.unchecked(), ExitStack() as stack:
            drawing = Drawing(self.device, linker, scene, programs, size, stack)
            yield OpenGLSession(drawing, self.captures)

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        with self.device.unchecked():
            return verdict.driver_verdict(self.device, sources)

    def storage(self, count: int) -> AbstractContextManager[Callable[[], Array]]:
        return storage.bound(self.device, count)

    def close(self) -> None:
        self.device.context.release()


class OpenGLSession(Session):
    """One scene on an OpenGL device."""

    def __init__(self, drawing: Drawing, cache: captures.CaptureCache) -> None:
        super().__init__(drawing.scene, drawing.programs)
        self._drawing = drawing
        self._cache = cache

    def draw(self) -> Drawn:
        return self._drawing.run()

    def fragments(self, key: PassDraw) -> Fragments:
        """As `Session.fragments`. Arrays from the cache can't be written to (see
        `shaderlab.programs.captures`)."""
        same = captures.identity(self.scene, self.programs, key, self._drawing.size)
        return self._cache.get(same, lambda: capture.fragments(self._drawing, key))

    def vertices(self, key: PassDraw) -> Samples:
        return feedback.vertices(self._drawing, key)

    def probe_fragments(
        self, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
    ) -> Samples:
        return capture.probe_fragments(self._drawing, key, bindings, inputs)

    def probe_vertices(
        self, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
    ) -> Samples:
        mesh = probed_mesh(self.programs[key[0]][key[1]].draw, inputs)
        return feedback.vertices(self._drawing, key, bindings, mesh)

    def count(self, key: PassDraw, counter: str) -> int:
        return queries.counted(self._drawing, key, counter)

    def time(self, pass_name: str, repeats: int) -> Timing:
        return queries.timed(self._drawing, pass_name, repeats)

    def attributes(self, key: PassDraw) -> Mapping[str, AttributeReading]:
        return queries.attributes(self._drawing, key)

    def blocks(self, key: PassDraw) -> Mapping[str, BlockReading]:
        return queries.block_readings(self._drawing, key)

    def locations(self, key: PassDraw) -> Mapping[str, int]:
        return queries.locations(self._drawing, key)

    def call(self, calls: Sequence[Call], returns: Sequence[int | float | str]) -> Reply:
        return api.answer(self._drawing.device, calls, returns, self._texts)

    def _texts(self, program: Program) -> dict[str, str]:
        name, index = self.scene.draw_key(program.pass_name, program.draw)
        return {source.stage: source.text for source in self.programs[name][index].sources}
