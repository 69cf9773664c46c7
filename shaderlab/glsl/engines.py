"""Two ways to ask the same compilers: their libraries in this process, or their commands.

Everything above this works with an `Engine` and gets the same data from either.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping, Sequence
from typing import Protocol

from shaderlab.errors import ShaderError, nearest
from shaderlab.glsl import frontend, library, tools
from shaderlab.glsl.frontend import ENVIRONMENTS, Checked, Linked
from shaderlab.glsl.sources import Source

ENGINES = ("library", "process")
COMMAND_VARIABLE = "SHADERLAB_GLSLANG"


class Engine(Protocol):
    """What the lab asks of a compiler. Nothing here raises for what a text says."""

    @property
    def name(self) -> str:
        """One of ENGINES."""

    def prepare(self, sources: Sequence[Source]) -> None:
        """Told which sources are about to be checked, an engine may do so all at once."""

    def check(self, source: Source) -> Checked:
        """One stage under plain GLSL rules, in the words of `glslangValidator -d`."""

    def preprocess(self, source: Source) -> str | None:
        """The text after the preprocessor, line for line, or None where that fails."""

    def link(self, sources: Sequence[Source], target: str) -> Linked:
        """All stages parsed and linked for a target, and turned into SPIR-V if it makes any."""

    def validate(self, module: bytes, environment: str) -> str | None:
        """SPIRV-Tools' message about an invalid module, or None where it is valid."""

    def versions(self) -> Mapping[str, str]:
        """What compiles: versions by "glslang" and "SPIRV-Tools", and where each comes from."""


_REMEMBERED = 8
"""How many answers a library keeps: a program's stages are asked about several times in a row."""


class Library:
    """glslang and SPIRV-Tools inside this process, from the wheels' shared libraries."""

    name = "library"

    def __init__(self) -> None:
        self._check = functools.lru_cache(_REMEMBERED)(frontend.check)
        self._validate = functools.lru_cache(_REMEMBERED)(tools.validate)

    def prepare(self, sources: Sequence[Source]) -> None:
        """Nothing: one by one costs no more."""

    def check(self, source: Source) -> Checked:
        return self._check(source)

    def preprocess(self, source: Source) -> str | None:
        return frontend.preprocess(source)

    def link(self, sources: Sequence[Source], target: str) -> Linked:
        return frontend.link(sources, ENVIRONMENTS[target])

    def validate(self, module: bytes, environment: str) -> str | None:
        return self._validate(module, environment)

    def versions(self) -> Mapping[str, str]:
        return library.versions()


def choose(name: str | None = None) -> Engine:
    """The engine to use.

    Args:
        name: one of ENGINES; None takes the commands where SHADERLAB_GLSLANG names one, else the
            libraries, else whatever commands the system has.

    Raises:
        ShaderError: no such engine, or nothing to drive it with; the remedy says what to install.
    """
    return _chosen(name, os.environ.get(COMMAND_VARIABLE) or None)


@functools.cache
def _chosen(name: str | None, command: str | None) -> Engine:
    # Late: the commands need subprocess and tempfile, which the libraries do without.
    from shaderlab.glsl.commands import Commands
    from shaderlab.glsl.programs import locate

    if name == "library":
        library.glslang()
        library.spirv_tools()
        return Library()
    if name == "process" or (name is None and command):
        return Commands(locate(command))
    if name is not None:
        raise ShaderError(f"no such engine: {name!r}", remedy=nearest(name, ENGINES))
    try:
        engine: Engine = _chosen("library", command)
        return engine
    except ShaderError as error:
        try:
            return Commands(locate(None))
        except ShaderError:
            raise error from None


def limited(engine: Engine, seconds: float) -> Engine:
    """The same engine, each of whose commands may take so long; a library can't be stopped."""
    from shaderlab.glsl.commands import Commands

    return engine.limited(seconds) if isinstance(engine, Commands) else engine
