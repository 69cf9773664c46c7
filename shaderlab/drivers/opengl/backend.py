"""OpenGL behind the protocol of `shaderlab.drivers`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import ClassVar

import numpy as np

from shaderlab.compiler.sources import Source
from shaderlab.errors import UnsupportedError
from shaderlab.model.calls import Call, CallEdit, Program
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, Fragments, PassDraw, Reply
from shaderlab.model.records import Verdict

from .. import Evaluation, Size
from ..device import DeviceBackend
from ..programs.prepare import Programs
from ..programs.storage import captured
from ..protocol import Answers
from . import calls, drawing, linking, queries, tracing
from .device import GL, Device
from .drawing import Drawing, Evaluator
from .linking import Linker


class OpenGLSession(Drawing):
    """One scene on an OpenGL device."""

    vertex_outputs = drawing.vertex_outputs

    def capture_fragments(self, key: PassDraw) -> Fragments:
        draw = self.programs[key[0]][key[1]]
        if draw.draw.compute:
            return captured(draw.draw, draw.interface, self.bindings[key])
        return super().capture_fragments(key)

    def _call(self, made: Sequence[Call], returns: Sequence[int | float | str]) -> Reply:
        def texts(program: Program) -> dict[str, str]:
            name, index = self.scene.draw_key(program.pass_name, program.draw)
            return self.programs[name][index].texts

        return calls.answer(self.device, made, returns, texts)

    def _errors(self, key: PassDraw) -> Sequence[int]:
        return self._gl_errors.get(key, ())

    answers: ClassVar[Answers] = {
        **Drawing.answers,
        "count": queries.counted,
        "time": queries.timed,
        "attributes": queries.attributes,
        "blocks": queries.block_readings,
        "locations": queries.locations,
        "trace": tracing.trace,
        "call": _call,
        "gl_errors": _errors,
    }


class OpenGLBackend(DeviceBackend):
    """Draws scenes on one device; keeps linked programs from one to the next."""

    linker_class = Linker
    session_class = OpenGLSession
    device: Device
    _linker: Linker

    def __init__(self, device: Device) -> None:
        super().__init__(device)
        self._evaluator = Evaluator(device, self._linker)

    def in_use(self) -> AbstractContextManager[object]:
        return self.device.in_use()

    @contextmanager
    def edited_session(
        self, scene: Scene, programs: Programs, size: Size, edit: CallEdit | None
    ) -> Iterator[OpenGLSession]:
        with (
            self.device.in_use(),
            tracing.recording_device(self.device, edit) as device,
            ExitStack() as stack,
        ):
            yield OpenGLSession(Linker(device), scene, programs, size, stack)

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        with self.device.in_use():
            return linking.driver_verdict(self.device, sources)

    def require_compute(self) -> None:
        if not drawing.has_compute(self.device):
            raise UnsupportedError("compute passes: this driver has no compute shaders")

    @contextmanager
    def storage(self, count: int) -> Iterator[Callable[[], Array]]:
        for name in ("GL_ARB_shader_storage_buffer_object", "GL_ARB_shader_image_load_store"):
            if name not in self.device.context.extensions:
                raise UnsupportedError(f"storage buffers: this driver lacks {name}")
        buffer = self.device.context.buffer(np.zeros(count, np.uint32))

        def read() -> Array:
            GL.glMemoryBarrier(GL.GL_BUFFER_UPDATE_BARRIER_BIT)
            return np.frombuffer(buffer.read(), np.uint32)

        try:
            buffer.bind_to_storage_buffer(0)
            yield read
        finally:
            buffer.release()

    def evaluate(self, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
        with self.device.in_use():
            self._evaluator.evaluate(evaluation, inputs, outputs)

    def close(self) -> None:
        # What outlives the context would be deleted by its number, in the context of another lab.
        self.device.context.gc_mode = None
        self.device.context.release()
