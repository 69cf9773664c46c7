"""The compilers' commands: finding them, and running one with a time limit."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from shaderlab.errors import ShaderError
from shaderlab.glsl.library import GLSLANG_WHEEL, INSTALL, SPIRV_TOOLS_WHEEL, find

GLSLANG_NAMES = ("glslangValidator", "glslang")
VALIDATOR_NAME = "spirv-val"


class CompilerDiedError(ShaderError):
    """A compiler's command crashed or timed out, as `status` says."""

    def __init__(self, status: Literal["crash", "timeout"], message: str) -> None:
        self.status: Literal["crash", "timeout"] = status
        super().__init__(message)


@dataclass(frozen=True)
class Executables:
    """The two commands' files."""

    glslang: Path
    validator: Path


def locate(command: str | None) -> Executables:
    """Finds the commands.

    Args:
        command: a glslangValidator by its path or name. By default the wheels, the PATH and the
            Vulkan SDK are searched.

    Raises:
        ShaderError: a command is missing; the remedy says what to install.
    """
    if command is None:
        glslang = next(_candidates(GLSLANG_NAMES, GLSLANG_WHEEL), None)
        if glslang is None:
            raise ShaderError("there is no glslangValidator command", remedy=INSTALL)
    else:
        named = shutil.which(command)
        if named is None:
            raise ShaderError(
                f"SHADERLAB_GLSLANG names no program: {command}",
                remedy="set it to the path of glslangValidator, or unset it",
            )
        glslang = Path(named)
    neighbour = shutil.which(VALIDATOR_NAME, path=str(glslang.parent))
    validator = Path(neighbour) if neighbour else None
    validator = validator or next(_candidates((VALIDATOR_NAME,), SPIRV_TOOLS_WHEEL), None)
    if validator is None:
        raise ShaderError(f"there is no {VALIDATOR_NAME} command", remedy=INSTALL)
    return Executables(glslang, validator)


def run(
    program: Path,
    arguments: Sequence[str],
    *,
    folder: str | None = None,
    given: bytes = b"",
    seconds: float | None = None,
) -> tuple[int, str]:
    """Runs a command; returns its exit status, and standard output and error together.

    Raises:
        CompilerDiedError: it crashed or took longer than `seconds`.
        ShaderError: it can't be run.
    """
    try:
        done = subprocess.run(
            [str(program), *arguments],
            cwd=folder,
            input=given,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=_environment(program),
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise CompilerDiedError(
            "timeout", f"{program.name} took longer than {seconds:g} s"
        ) from None
    except OSError as error:
        raise ShaderError(
            f"can't run this command: {error.strerror or error}", file=program
        ) from None
    output = done.stdout.decode("utf-8", "replace")
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        raise CompilerDiedError("crash", f"{program.name} died: {name}")
    if done.returncode in (126, 127):
        last = output.strip().rpartition("\n")[2]
        raise ShaderError(f"this command does not start: {last}", file=program, remedy=INSTALL)
    return done.returncode, output


def _candidates(names: Sequence[str], wheel: str) -> Iterator[Path]:
    for name in names:
        with suppress(ShaderError):
            yield find(wheel, name, "bin")
    sdk = os.environ.get("VULKAN_SDK")
    folders = [os.environ.get("PATH", os.defpath), *([str(Path(sdk) / "bin")] if sdk else [])]
    found = (shutil.which(name, path=folder) for folder in folders for name in names)
    yield from map(Path, filter(None, found))


def _environment(program: Path) -> Mapping[str, str]:
    """Variables for a command; the wheels' commands must be told where their libraries are."""
    lib = program.parent.parent / "lib"
    if lib.parent.name != "cmeel.prefix":
        return os.environ
    paths = [str(lib), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
    return {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(paths)}
