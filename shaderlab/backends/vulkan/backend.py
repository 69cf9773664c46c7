"""Vulkan behind the protocol of `shaderlab.backends`."""

from __future__ import annotations

from collections.abc import Sequence

from shaderlab.backends import Evaluation
from shaderlab.backends.device_backend import DeviceBackend
from shaderlab.backends.vulkan import queries, vertex_storage
from shaderlab.backends.vulkan.device import Device
from shaderlab.backends.vulkan.drawing import Drawing
from shaderlab.backends.vulkan.evaluating import evaluate
from shaderlab.backends.vulkan.linking import Linker
from shaderlab.backends.vulkan.verdict import driver_verdict
from shaderlab.compiler.sources import Source
from shaderlab.frame import Array
from shaderlab.records import Verdict


class VulkanSession(Drawing):
    """One scene on a Vulkan device."""

    vertex_outputs = vertex_storage.vertex_outputs
    count = queries.counted
    time = queries.timed
    attributes = queries.attributes
    blocks = queries.block_readings


class VulkanBackend(DeviceBackend):
    """Draws scenes on one device; caches programs and captured fragments across scenes."""

    linker_class = Linker
    session_class = VulkanSession
    device: Device
    _linker: Linker

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        return driver_verdict(self.device, sources)

    def evaluate(self, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
        evaluate(self._linker, evaluation, inputs, outputs)

    def close(self) -> None:
        self._linker.release()
        self.device.close()
