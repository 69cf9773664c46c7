"""The compile targets, and two ways to call the same compilers: as libraries in this process, or as
commands. Code that compiles takes an `Engine` and gets the same data from either."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, Protocol

from shaderlab.errors import ShaderError, suggest

from .sources import Source

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

ENGINES = ("library", "process")
COMMAND_VARIABLE = "SHADERLAB_GLSLANG"


@dataclass(frozen=True)
class Checked:
    """The plain GLSL verdict on one stage, and the log as the command prints it."""

    ok: bool
    log: str


@dataclass(frozen=True)
class Linked:
    """The result of linking: each stage's parse log, the link's log, and the modules by stage.

    `ok` is glslang's own verdict; `modules` is empty if it is false or the target has none.
    """

    ok: bool
    stage_logs: Mapping[str, str]
    log: str
    modules: Mapping[str, bytes]


class CompilerDiedError(ShaderError):
    """A compiler's command crashed or timed out, as `status` says."""

    def __init__(self, status: Literal["crash", "timeout"], message: str) -> None:
        self.status: Literal["crash", "timeout"] = status
        super().__init__(message)


class Engine(Protocol):
    """A compiler and a validator. What is wrong with a text is never an exception."""

    @property
    def name(self) -> str:
        """One of ENGINES."""

    def check(self, source: Source) -> Checked:
        """Check one stage under plain GLSL rules, as `glslangValidator -d` does."""

    def preprocess(self, source: Source) -> str | None:
        """Return the text after the preprocessor, line for line, or None if that fails."""

    def link(self, sources: Sequence[Source], target: str, *, lines: bool = False) -> Linked:
        """Parse and link all stages for a target, and make SPIR-V if the target has it; with
        `lines` the modules say which line of the text each instruction comes from."""

    def validate(self, module: bytes, environment: str) -> str | None:
        """Return SPIRV-Tools' message about an invalid module, or None if it is valid."""

    def versions(self) -> Mapping[str, str]:
        """Return versions by "glslang" and "SPIRV-Tools", and the path of each file in use."""


def choose(name: str | None = None, seconds: float | None = None) -> Engine:
    """Choose the engine to use.

    Args:
        name: one of ENGINES. By default the command that SHADERLAB_GLSLANG names, else the
            libraries, else the system's commands.
        seconds: time limit for each command; a library can't be stopped.

    Raises:
        ShaderError: no such engine, or it is not installed; the remedy says what to install.
    """
    return _choose(name, os.environ.get(COMMAND_VARIABLE) or None, seconds)


@functools.cache
def _choose(name: str | None, command: str | None, seconds: float | None) -> Engine:
    # Imported late: commands need subprocess and tempfile, which the library does without.
    from .commands import Commands, locate
    from .library import Library

    if name == "library":
        return Library()
    if name == "process" or (name is None and command):
        return Commands(locate(command), seconds)
    if name is not None:
        raise ShaderError(f"no such engine: {name!r}", remedy=suggest(name, ENGINES))
    try:
        return choose("library")
    except ShaderError as error:
        try:
            return Commands(locate(None), seconds)
        except ShaderError:
            raise error from None
