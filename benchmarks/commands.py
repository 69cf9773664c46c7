"""The compilers' commands, which the benchmarks compare the lab with."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from shaderlab.compiler.glslang import GLSLANG_WHEEL, SPIRV_TOOLS_WHEEL, find

FLAGS = {
    "glsl": ["-d", "-l"],
    "opengl": ["-d", "-G", "--aml", "--amb"],
    "vulkan": ["-d", "-V", "-R", "--aml", "--amb"],
    "vulkan-strict": ["-d", "-V", "--aml", "--amb"],
}
"""glslangValidator's flags for each target."""


def glslang_command() -> Path:
    return find(GLSLANG_WHEEL, "glslangValidator", "bin")


def validator_command() -> Path:
    return find(SPIRV_TOOLS_WHEEL, "spirv-val", "bin")


def environment() -> Mapping[str, str]:
    """Variables for the commands, which need the path of their libraries."""
    return {**os.environ, "LD_LIBRARY_PATH": str(glslang_command().parent.parent / "lib")}
