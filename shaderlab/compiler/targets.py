"""The compile targets in the terms of glslang and SPIRV-Tools."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

_SPV_RULES, _VULKAN_RULES = 1 << 3, 1 << 4
_MAP_BINDINGS, _MAP_LOCATIONS, _RELAXED = 1 << 0, 1 << 1, 1 << 2
_MAP = _MAP_BINDINGS | _MAP_LOCATIONS


@dataclass(frozen=True, kw_only=True)
class TargetSettings:
    """One target in the compilers' terms.

    Attributes:
        flags: glslangValidator's, before the files.
        client: glslang's number for who is to run the program, as are those that follow.
        messages: rules to report violations of.
        options: how numbers are assigned and rules relaxed.
        environment: SPIRV-Tools' name for the target, "" if it has no modules.
        api: the name in messages of the API that runs the modules.
        minimum: the lowest desktop `#version` that can become SPIR-V.
    """

    flags: tuple[str, ...]
    client: int = 0
    client_version: int = 0
    messages: int = 0
    options: int = 0
    environment: str = ""
    api: str = ""
    minimum: int = 0


_VULKAN = TargetSettings(
    flags=("-d", "-V", "-R", "--aml", "--amb"),
    client=1,
    client_version=1 << 22,
    messages=_SPV_RULES | _VULKAN_RULES,
    options=_MAP | _RELAXED,
    environment="vulkan1.0",
    api="Vulkan",
    minimum=140,
)

SETTINGS: Mapping[str, TargetSettings] = {
    "glsl": TargetSettings(flags=("-d", "-l")),
    "opengl": TargetSettings(
        flags=("-d", "-G", "--aml", "--amb"),
        client=2,
        client_version=450,
        messages=_SPV_RULES,
        options=_MAP,
        environment="opengl4.5",
        api="OpenGL",
        minimum=330,
    ),
    "vulkan": _VULKAN,
    "vulkan-strict": replace(_VULKAN, flags=("-d", "-V", "--aml", "--amb"), options=_MAP),
}

TARGETS = ("glsl", "opengl", "vulkan")
"""The targets that programs are compiled for by default."""

ALL_TARGETS = tuple(SETTINGS)
