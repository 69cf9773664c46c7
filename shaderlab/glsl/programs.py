"""The compilers as commands: where they are, and running one with a time limit."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from shaderlab.errors import ShaderError
from shaderlab.glsl.wheels import GLSLANG_WHEEL, INSTALL, SPIRV_TOOLS_WHEEL, find

GLSLANG_NAMES = ("glslangValidator", "glslang")
VALIDATOR_NAME = "spirv-val"


class CompilerDiedError(ShaderError):
    """A compiler's command gave no answer; `status` says how."""

    def __init__(self, status: Literal["crash", "timeout"], message: str) -> None:
        self.status: Literal["crash", "timeout"] = status
        super().__init__(message)


@dataclass(frozen=True)
class Programs:
    """The two commands."""

    glslang: Path
    validator: Path


@dataclass(frozen=True)
class Ran:
    """What a command gave: its exit status, and standard output and error together."""

    code: int
    output: str


def locate(command: str | None) -> Programs:
    """The commands to drive.

    Args:
        command: a glslangValidator by its path or name; None looks in the wheels, on the PATH
            and in the Vulkan SDK.

    Raises:
        ShaderError: there is none; the remedy says what to install.
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
    beside = shutil.which(VALIDATOR_NAME, path=str(glslang.parent))
    validator = Path(beside) if beside else None
    validator = validator or next(_candidates((VALIDATOR_NAME,), SPIRV_TOOLS_WHEEL), None)
    if validator is None:
        raise ShaderError(f"there is no {VALIDATOR_NAME} command", remedy=INSTALL)
    return Programs(glslang, validator)


def run(
    program: Path,
    arguments: Sequence[str],
    *,
    folder: str | None = None,
    given: bytes | None = None,
    seconds: float | None = None,
) -> Ran:
    """A command run to its end.

    Raises:
        CompilerDiedError: it crashed or took longer than `seconds`.
        ShaderError: it can't be run.
    """
    try:
        done = subprocess.run(
            [str(program), *arguments],
            cwd=folder,
            input=b"" if given is None else given,
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
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        raise CompilerDiedError("crash", f"{program.name} died: {name}")
    if done.returncode in (126, 127):
        last = done.stdout.decode("utf-8", "replace").strip().rpartition("\n")[2]
        raise ShaderError(f"this command does not start: {last}", file=program, remedy=INSTALL)
    return Ran(done.returncode, done.stdout.decode("utf-8", "replace"))


def _candidates(names: Sequence[str], wheel: str) -> Iterator[Path]:
    for name in names:
        try:
            yield find(wheel, name, "bin")
        except ShaderError:
            continue
    sdk = os.environ.get("VULKAN_SDK")
    folders = [os.environ.get("PATH", os.defpath), *([str(Path(sdk) / "bin")] if sdk else [])]
    for folder in folders:
        for name in names:
            found = shutil.which(name, path=folder)
            if found:
                yield Path(found)


def _environment(program: Path) -> Mapping[str, str]:
    """The wheels' programs find their own libraries only if they are told where."""
    lib = program.parent.parent / "lib"
    if lib.parent.name != "cmeel.prefix":
        return os.environ
    paths = [str(lib), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
    return {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(paths)}
