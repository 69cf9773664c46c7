"""From a program's text to the ESSL 3.00 that WebGL2 runs, by way of its SPIR-V modules."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from shaderlab.compiler.reflection import Interface
from shaderlab.compiler.sources import Source
from shaderlab.errors import DriverError, UnsupportedError
from shaderlab.model.activity import doing

from ..programs import stages
from ..programs.module_texts import compiled_to_modules, counted_as_declared, numbered, sources_of

_INSTALL = (
    "Debian/Ubuntu: apt-get install spirv-cross · Fedora: dnf install spirv-tools · "
    "Arch: pacman -S spirv-cross"
)
_STAGES = ("vertex", "fragment")
_MOST_LOCATIONS = 32
_SECONDS = 30


@dataclass(frozen=True)
class Translated:
    """A program's stages in ESSL, and what it declares."""

    texts: Mapping[str, str]
    interface: Interface


def cross_compiler() -> str:
    """The command of SPIRV-Cross. Raises DriverError if it is not there."""
    found = shutil.which("spirv-cross")
    if found is None:
        raise DriverError("no spirv-cross, which makes ESSL of modules", remedy=_INSTALL)
    return found


def translated(
    texts: Mapping[str, str], known: Sequence[Source] = (), *, keep_names: bool = False
) -> Translated:
    """A program in ESSL.

    What one stage hands to the other goes by its location: of blocks and structs ESSL has none
    there, and SPIRV-Cross names their members by the instance, which stages name as they like.

    Args:
        texts: by stage, in GLSL.
        known: sources, some of whose texts these may be.
        keep_names: whether a vertex stage's outputs keep their names.

    Raises:
        ShaderError: it is no GLSL.
        UnsupportedError: ESSL 3.00 can't say it.
    """
    for stage in texts:
        if stage not in _STAGES:
            raise UnsupportedError(f"the {stage} stage: WebGL2 has none")
    own = {
        stage: numbered(counted_as_declared(text) if stage == "fragment" else text)
        for stage, text in texts.items()
    }
    with doing("compile"):
        compiled = compiled_to_modules(sources_of(own, known), "opengl", "WebGL2")
        assert compiled.interface is not None
        modules = compiled.spirv["opengl"]
        return Translated(
            {stage: _essl(stage, modules[stage], keep_names) for stage in own}, compiled.interface
        )


def _essl(stage: str, module: bytes, keep_names: bool) -> str:
    command = [cross_compiler(), "-", "--es", "--version", "300"]
    if not keep_names:
        direction = "out" if stage == "vertex" else "in"
        for place in range(_MOST_LOCATIONS):
            name = f"{stages.PREFIX}at{place}"
            command += ["--rename-interface-variable", direction, str(place), name]
    done = subprocess.run(command, input=module, capture_output=True, timeout=_SECONDS)
    if done.returncode:
        said = done.stderr.decode("utf-8", "replace").strip().splitlines()
        message = next((line for line in said if line.strip()), "it does not say why")
        raise UnsupportedError(f"the {stage} stage in ESSL 3.00: {message}")
    return done.stdout.decode("utf-8")
