"""From a program's text to the SPIR-V modules that Vulkan runs.

The text is the one that OpenGL gets, but for what Vulkan counts otherwise: pictures are kept with
their lowest row first, so a point's coordinates run the other way than Vulkan has them, and window
coordinates from the upper corner take the target's height; and a point has the size that its last
stage writes, in Vulkan always.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence

from shaderlab.backends.vulkan.device import Device
from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.module import parse
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.programs import stages

# Source: SPIR-V Specification 1.6 (Capability) and Vulkan 1.3 Specification, appendix Vulkan
# Environment for SPIR-V: what each capability takes; those without a feature are always there.
_CAPABILITIES = {
    0: "", 1: "", 40: "", 43: "", 44: "", 46: "", 47: "", 49: "", 50: "", 51: "",
    2: "geometryShader", 3: "tessellationShader", 10: "shaderFloat64", 11: "shaderInt64",
    22: "shaderInt16", 23: "shaderTessellationAndGeometryPointSize",
    24: "shaderTessellationAndGeometryPointSize", 25: "shaderImageGatherExtended",
    27: "shaderStorageImageMultisample", 28: "shaderUniformBufferArrayDynamicIndexing",
    29: "shaderSampledImageArrayDynamicIndexing", 30: "shaderStorageBufferArrayDynamicIndexing",
    31: "shaderStorageImageArrayDynamicIndexing", 32: "shaderClipDistance",
    33: "shaderCullDistance", 34: "imageCubeArray", 35: "sampleRateShading",
    45: "imageCubeArray", 55: "shaderStorageImageReadWithoutFormat",
    56: "shaderStorageImageWriteWithoutFormat", 57: "multiViewport",
}  # fmt: skip
HEIGHT = stages.PREFIX + "height"
"""The uniform that says how high the target is in pixels (float)."""
_COORD = re.compile(r"\blayout\s*\(([^)]*)\)\s*in\s+vec4\s+gl_FragCoord\s*;")
_POINT = re.compile(r"\bgl_PointCoord\b")
_LOCATED = re.compile(r"\blayout\s*\([^)]*\blocation\s*=\s*(\d+)[^)]*\)\s*out\b")
_ADDED = re.compile(rf"^out \w+ {stages.PREFIX}\w+;", re.MULTILINE)
_NO_FILES = Shaders(())


def for_vulkan(text: str) -> str:
    """A fragment shader's text as Vulkan is to get it; it may have a uniform HEIGHT more."""
    text = _POINT.sub("vec2(gl_PointCoord.x, 1.0 - gl_PointCoord.y)", text)
    return _numbered(_counted_as_declared(text))


def _counted_as_declared(text: str) -> str:
    """The text with window coordinates counted as its own declaration of gl_FragCoord says."""
    declared = _COORD.search(text)
    if declared is None:
        return text
    y = f"{HEIGHT} - gl_FragCoord.y" if "origin_upper_left" in declared[1] else "gl_FragCoord.y"
    half = " - 0.5" if "pixel_center_integer" in declared[1] else ""
    named = f"{stages.PREFIX}frag_coord"
    counted = (
        f"uniform float {HEIGHT}; vec4 {named}() "
        f"{{ return vec4(gl_FragCoord.x{half}, {y}{half}, gl_FragCoord.zw); }}"
    )
    after = re.sub(r"\bgl_FragCoord\b", f"{named}()", text[declared.end() :])
    return f"{text[: declared.start()]}{counted}{after}"


def _numbered(text: str) -> str:
    """The text, the outputs that the lab adds having locations where the author's have: glslang
    gives those without one the locations that others have already."""
    taken = {int(number) for number in _LOCATED.findall(text)}
    if not taken:
        return text
    free = itertools.filterfalse(taken.__contains__, itertools.count())
    return _ADDED.sub(lambda found: f"layout(location = {next(free)}) {found[0]}", text)


def sources_of(texts: Mapping[str, str], known: Sequence[Source] = ()) -> tuple[Source, ...]:
    """The stages with these texts, as compilers take them: the `known` ones where their text is the
    same."""
    own = {source.stage: source for source in known}
    return tuple(
        own[stage] if stage in own and own[stage].text == text else
        _NO_FILES.from_text(text, stage, own[stage].path if stage in own else f"<{stage}>")
        for stage, text in texts.items()
    )  # fmt: skip


def modules_of(sources: Sequence[Source]) -> Mapping[str, bytes]:
    """A program's modules by stage.

    Raises:
        ShaderError: it is no GLSL.
        UnsupportedError: it is GLSL, but none that can be made into modules for Vulkan.
    """
    compiling = cached_compiler()
    compiled = compiling(sources, ("vulkan",))
    if "vulkan" in compiled.spirv:
        return compiled.spirv["vulkan"]
    compiling(sources, ("glsl",)).require()
    try:
        compiled.require()
    except ShaderError as error:
        raise UnsupportedError(
            f"in Vulkan: {error.message}", file=error.file, line=error.line, remedy=error.remedy
        ) from error
    raise UnsupportedError("in Vulkan: the program has no modules", file=sources[0].path)


def check_capabilities(device: Device, modules: Mapping[str, bytes]) -> None:
    """Raise UnsupportedError where a module takes a feature that the device lacks."""
    for stage, data in modules.items():
        for number in sorted(parse(data).capabilities):
            feature = _CAPABILITIES.get(number)
            if feature is None:
                raise UnsupportedError(f"the {stage} stage takes SPIR-V capability {number}")
            if feature and feature not in device.features:
                raise UnsupportedError(f"the {stage} stage takes {feature}: this device has none")


def drawing_points(texts: Mapping[str, str], size: float | str | None) -> dict[str, str]:
    """The texts of a program that draws points: its last stage writes their size, and drops those
    that OpenGL clips. lavapipe (Mesa 22.3) and SwiftShader report that they do, and draw them.

    Args:
        texts: by stage.
        size: as in `State.point_size`.
    """
    last = "geometry" if "geometry" in texts else "vertex"
    if isinstance(size, str) or (size is None and "gl_PointSize" in texts[last]):
        given = None
    else:
        given = 1.0 if size is None else float(size)
    return {**texts, last: stages.drawing_points(texts[last], given)}
