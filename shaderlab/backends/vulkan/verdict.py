"""Whether a Vulkan driver takes a program. It has no compiler for GLSL: it gets modules."""

from __future__ import annotations

from collections.abc import Sequence

from shaderlab.backends.vulkan.device import Device
from shaderlab.backends.vulkan.modules import check_capabilities, modules_of
from shaderlab.compiler.driver_verdict import DRIVER
from shaderlab.compiler.sources import Source
from shaderlab.errors import DriverError, ShaderError
from shaderlab.records import Verdict


def driver_verdict(device: Device, sources: Sequence[Source]) -> Verdict:
    """The device takes a program if it has each capability of its modules.

    Raises:
        DriverError: the program has no modules that a driver could be asked about.
        UnsupportedError: Vulkan has no such program, or the device lacks what it takes.
    """
    try:
        modules = modules_of(sources)
    except ShaderError as error:
        raise DriverError(
            "a Vulkan driver takes no GLSL, and of this program there are no modules",
            file=error.file, line=error.line,
        ) from error  # fmt: skip
    check_capabilities(device, modules)
    return Verdict(target=DRIVER, ok=True)
