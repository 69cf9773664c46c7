"""From a program's text to the SPIR-V modules that Vulkan runs.

The text is the one that OpenGL gets, but for what Vulkan counts otherwise: pictures are kept with
their lowest row first, so a point's coordinates run the other way than Vulkan has them, and window
coordinates from the upper corner take the target's height; and a point has the size that its last
stage writes, in Vulkan always.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from shaderlab.compiler.module import parse
from shaderlab.compiler.sources import Source
from shaderlab.errors import UnsupportedError

from ..programs.module_texts import compiled_to_modules, counted_as_declared, numbered
from .device import Device

# Source: SPIR-V Specification 1.6 (Capability) and Vulkan 1.3 Specification, appendix Vulkan
# Environment for SPIR-V: what each capability takes; those without a feature are always there.
_CAPABILITIES = {
    0: "", 1: "", 40: "", 43: "", 44: "", 46: "", 47: "", 49: "", 50: "", 51: "",
    2: "geometryShader", 10: "shaderFloat64", 11: "shaderInt64",
    22: "shaderInt16", 23: "shaderTessellationAndGeometryPointSize",
    24: "shaderTessellationAndGeometryPointSize", 25: "shaderImageGatherExtended",
    27: "shaderStorageImageMultisample", 28: "shaderUniformBufferArrayDynamicIndexing",
    29: "shaderSampledImageArrayDynamicIndexing", 30: "shaderStorageBufferArrayDynamicIndexing",
    31: "shaderStorageImageArrayDynamicIndexing", 32: "shaderClipDistance",
    33: "shaderCullDistance", 34: "imageCubeArray", 35: "sampleRateShading",
    45: "imageCubeArray", 55: "shaderStorageImageReadWithoutFormat",
    56: "shaderStorageImageWriteWithoutFormat", 57: "multiViewport",
}  # fmt: skip
_POINT = re.compile(r"\bgl_PointCoord\b")


def for_vulkan(text: str) -> str:
    """A fragment shader's text as Vulkan is to get it; it may have a uniform HEIGHT more."""
    text = _POINT.sub("vec2(gl_PointCoord.x, 1.0 - gl_PointCoord.y)", text)
    return numbered(counted_as_declared(text))


def modules_of(sources: Sequence[Source]) -> Mapping[str, bytes]:
    """A program's modules by stage.

    Raises:
        ShaderError: it is no GLSL.
        UnsupportedError: it is GLSL, but none that can be made into modules for Vulkan.
    """
    return compiled_to_modules(sources, "vulkan", "Vulkan").spirv["vulkan"]


def check_capabilities(device: Device, modules: Mapping[str, bytes]) -> None:
    """Raise UnsupportedError where a module takes a feature that the device or the lab lacks."""
    for stage, data in modules.items():
        if stage.startswith("tess_"):
            raise UnsupportedError(f"the {stage} stage: the lab tessellates on OpenGL only")
        for number in sorted(parse(data).capabilities):
            feature = _CAPABILITIES.get(number)
            if feature is None:
                raise UnsupportedError(f"the {stage} stage takes SPIR-V capability {number}")
            if feature and feature not in device.features:
                raise UnsupportedError(f"the {stage} stage takes {feature}: this device has none")
