"""Vulkan behind the protocol of `shaderlab.backends`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

from shaderlab.backends import Backend, Evaluation, Size
from shaderlab.backends.vulkan import queries, vertex_storage
from shaderlab.backends.vulkan.device import Device
from shaderlab.backends.vulkan.drawing import Drawing
from shaderlab.backends.vulkan.evaluating import evaluate
from shaderlab.backends.vulkan.linking import Linker
from shaderlab.backends.vulkan.verdict import driver_verdict
from shaderlab.compiler.sources import Source
from shaderlab.frame import Array
from shaderlab.model import Scene
from shaderlab.programs import captures
from shaderlab.programs.prepare import Programs
from shaderlab.records import Verdict


class VulkanBackend(Backend):
    """Draws scenes on one device; caches programs and captured fragments across scenes."""

    def __init__(self, device: Device) -> None:
        self.info = device.info
        self.device = device
        self.captures = captures.CaptureCache()
        self._linker = Linker(device)

    @contextmanager
    def session(
        self, scene: Scene, programs: Programs, size: Size, *, temporary_programs: bool = False
    ) -> Iterator[VulkanSession]:
        with ExitStack() as stack:
            linker = self._linker
            if temporary_programs:
                linker = Linker(self.device, self._linker)
                stack.callback(linker.release)
            session = VulkanSession(self.device, linker, scene, programs, size, stack)
            session.cache = self.captures
            yield session

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        return driver_verdict(self.device, sources)

    def evaluate(self, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
        evaluate(self._linker, evaluation, inputs, outputs)

    def close(self) -> None:
        self._linker.release()
        self.device.close()


class VulkanSession(Drawing):
    """One scene on a Vulkan device."""

    vertices = vertex_storage.vertices
    probe_vertices = vertex_storage.probe_vertices
    count = queries.counted
    time = queries.timed
    attributes = queries.attributes
    blocks = queries.block_readings
