"""OpenGL behind the protocol of `shaderlab.drivers`: the backend, and its sessions' queries."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import ClassVar

import numpy as np

from shaderlab.compiler.sources import Source
from shaderlab.errors import UnsupportedError, Verdict
from shaderlab.model.calls import Call, CallEdit, Program
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, AttributeReading, BlockReading, Fragments, PassDraw, Reply

from .. import Answers, Evaluation, Size
from ..passes import DeviceBackend, PassSession
from ..programs.prepare import Programs
from ..programs.stages import PREFIX
from ..programs.storage import capture_invocations
from . import calls, drawing, linking, tracing
from .buffers import read_block, read_layout
from .device import GL, Device, gl_constant
from .drawing import Drawing, drain_errors, evaluate, submit
from .linking import Linker, uniform_location

# Source: OpenGL 4.6 core profile specification, tables 4.1 and 4.2; ARB_pipeline_statistics_query.
_SPELT = {"geometry_primitives_emitted": "geometry_shader_primitives_emitted"}
_ALWAYS = ("samples_passed", "primitives_generated")
_STATISTICS = "GL_ARB_pipeline_statistics_query"


def count_events(drawing: Drawing, key: PassDraw, counter: str) -> int:
    """Count what one draw makes the driver count; its pass is drawn once more. Raises
    UnsupportedError: the driver does not count this."""
    device = drawing.device
    if counter not in _ALWAYS and _STATISTICS not in device.context.extensions:
        raise UnsupportedError(f"counting {counter}: the driver has no {_STATISTICS}")
    made, what = np.atleast_1d(GL.glGenQueries(1)), gl_constant(_SPELT.get(counter, counter))
    try:
        with drawing.fresh_target(key[0]) as target:
            for index, draw in enumerate(drawing.programs[key[0]][: key[1] + 1]):
                program, vao = drawing.set_up(draw, drawing.bindings[key[0], index], target)
                if index == key[1]:
                    GL.glBeginQuery(what, made[0])
                submit(vao, program, draw)
            GL.glEndQuery(what)
            result = int(GL.glGetQueryObjectuiv(made[0], GL.GL_QUERY_RESULT))
    finally:
        GL.glDeleteQueries(1, made)
        drain_errors()
    return result


def read_attributes(drawing: Drawing, key: PassDraw) -> Mapping[str, AttributeReading]:
    draw = drawing.programs[key[0]][key[1]]
    if draw.draw.mesh is None:
        return {}
    with drawing.fresh_target(key[0]) as target:
        program, vao = drawing.set_up(draw, drawing.bindings[key], target)
        return read_layout(program, vao, draw.draw.mesh)


def read_blocks(drawing: Drawing, key: PassDraw) -> dict[str, BlockReading]:
    """Read where the driver has the members of each uniform or storage block of a draw."""
    draw = drawing.programs[key[0]][key[1]]
    program = drawing.linker.link(draw.texts)
    return {name: read_block(program, block) for name, block in draw.interface.blocks.items()}


def find_locations(drawing: Drawing, key: PassDraw) -> dict[str, int]:
    """Find where the driver put each uniform that a draw's program declares, samplers too; −1 for
    one that it left out."""
    draw = drawing.programs[key[0]][key[1]]
    program = drawing.linker.link(draw.texts)
    names = (name for name in draw.interface.uniforms if not name.startswith(PREFIX))
    return {name: uniform_location(program, name) for name in names}


class OpenGLSession(Drawing):
    capture_outputs = drawing.capture_outputs

    def capture_fragments(self, key: PassDraw) -> Fragments:
        draw = self.programs[key[0]][key[1]]
        if draw.draw.compute:
            return capture_invocations(draw.draw, draw.interface, self.bindings[key])
        return super().capture_fragments(key)

    def _call(self, made: Sequence[Call], returns: Sequence[int | float | str]) -> Reply:
        def texts(program: Program) -> dict[str, str]:
            name, index = self.scene.draw_key(program.pass_name, program.draw)
            return self.programs[name][index].texts

        return calls.answer(self.device, made, returns, texts)

    answers: ClassVar[Answers] = {
        **Drawing.answers,
        "count": count_events,
        "attributes": read_attributes,
        "blocks": read_blocks,
        "locations": find_locations,
        "trace": tracing.trace,
        "parameters": lambda _, function: tuple(calls.prototype(function).argNames),
        "call": _call,
        "gl_errors": PassSession.find_errors,
    }


class OpenGLBackend(DeviceBackend):
    linker_class = Linker
    session_class = OpenGLSession
    device: Device
    linker: Linker

    def in_use(self) -> AbstractContextManager[object]:
        return self.device.in_use()

    @contextmanager
    def edited_session(
        self, scene: Scene, programs: Programs, size: Size, edit: CallEdit | None
    ) -> Iterator[OpenGLSession]:
        with (
            self.device.in_use(),
            tracing.open_recording_device(self.device, edit) as device,
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
    def storage(self, count: int, binding: int = 0) -> Iterator[Callable[[], Array]]:
        for name in ("GL_ARB_shader_storage_buffer_object", "GL_ARB_shader_image_load_store"):
            if name not in self.device.context.extensions:
                raise UnsupportedError(f"storage buffers: this driver lacks {name}")
        buffer = self.device.context.buffer(np.zeros(count, np.uint32))

        def read() -> Array:
            GL.glMemoryBarrier(GL.GL_BUFFER_UPDATE_BARRIER_BIT)
            return np.frombuffer(buffer.read(), np.uint32)

        try:
            buffer.bind_to_storage_buffer(binding)
            yield read
        finally:
            buffer.release()

    def evaluate(self, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
        with self.device.in_use():
            evaluate(self.device, self.linker, evaluation, inputs, outputs)

    def close(self) -> None:
        # What outlives the context would be deleted by its number, in the context of another lab.
        self.device.context.gc_mode = None
        self.device.context.release()
