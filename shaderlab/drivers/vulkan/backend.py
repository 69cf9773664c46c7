"""Vulkan behind the protocol of `shaderlab.drivers`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from shaderlab.compiler.diagnostics import DRIVER
from shaderlab.compiler.sources import Source
from shaderlab.errors import DriverError, ShaderError
from shaderlab.model.frame import Array
from shaderlab.model.records import Verdict

from .. import Evaluation
from ..passes import DeviceBackend
from ..protocol import Answers
from . import drawing, queries
from .device import Device
from .drawing import Drawing, evaluate
from .program import Linker, check_capabilities, modules_of


class VulkanSession(Drawing):
    """One scene on a Vulkan device."""

    vertex_outputs = drawing.vertex_outputs
    answers: ClassVar[Answers] = {
        **Drawing.answers,
        "count": queries.counted,
        "time": queries.timed,
        "attributes": queries.attributes,
        "blocks": queries.block_readings,
    }


class VulkanBackend(DeviceBackend):
    """Draws scenes on one device; keeps programs from one to the next."""

    linker_class = Linker
    session_class = VulkanSession
    device: Device
    _linker: Linker

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        """The device takes a program if it has each capability of its modules: it has no compiler
        for GLSL."""
        try:
            modules = modules_of(sources)
        except ShaderError as error:
            raise DriverError(
                "a Vulkan driver takes no GLSL, and of this program there are no modules",
                file=error.file, line=error.line,
            ) from error  # fmt: skip
        check_capabilities(self.device, modules)
        return Verdict(target=DRIVER, ok=True)

    def evaluate(self, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
        evaluate(self._linker, evaluation, inputs, outputs)

    def close(self) -> None:
        self._linker.release()
        self.device.close()
