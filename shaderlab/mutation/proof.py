"""Whether a mutant is proved to be the same program: once optimised, its SPIR-V is the same."""

from __future__ import annotations

import functools
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.library import SPIRV_TOOLS_WHEEL, find
from shaderlab.compiler.sources import Source
from shaderlab.compiler.verdicts import with_interface
from shaderlab.errors import ShaderError

_PASSES = ("--strip-debug", "-O", "--compact-ids")


def same_program(mutant: Sequence[Source], original: Sequence[Source]) -> bool:
    """Whether the optimiser makes the same modules of both programs' stages. False where there is
    no optimiser and the modules differ."""
    one, other = _modules(mutant), _modules(original)
    return one.keys() == other.keys() and all(_same(one[stage], other[stage]) for stage in one)


def _modules(stages: Sequence[Source]) -> Mapping[str, bytes]:
    """Each stage's module for OpenGL."""
    newer = [with_interface(stage) for stage in stages]
    return compile_program(newer, ("glsl", "opengl")).spirv["opengl"]


def _same(one: bytes, other: bytes) -> bool:
    return one == other or _optimised(one) == _optimised(other) != b""


@functools.lru_cache(maxsize=64)
def _optimised(module: bytes) -> bytes:
    """The module after spirv-opt; nothing if that can't be run or refuses it."""
    command = _optimiser()
    if command is None:
        return b""
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder, "given.spv"), Path(folder, "made.spv")
        given.write_bytes(module)
        run = subprocess.run(
            [command, *_PASSES, str(given), "-o", str(made)],
            capture_output=True, timeout=20.0, check=False,
        )  # fmt: skip
        return made.read_bytes() if run.returncode == 0 else b""


@functools.cache
def _optimiser() -> str | None:
    """The command spirv-opt: the wheel's, or the one on the PATH."""
    try:
        return str(find(SPIRV_TOOLS_WHEEL, "spirv-opt", "bin"))
    except ShaderError:
        return shutil.which("spirv-opt")
