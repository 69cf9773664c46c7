"""Opening OpenGL without a screen, and what the driver says of itself."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from shaderlab.errors import DriverError

SOFTWARE = ("llvmpipe", "softpipe")
INSTALL = (
    "Debian/Ubuntu: apt-get install libegl1 libgl1-mesa-dri · Fedora: dnf install "
    "mesa-libEGL mesa-dri-drivers · Arch: pacman -S mesa · or run `shaderlab doctor`"
)
REQUIRED_VERSION = 330


@dataclass(frozen=True)
class Device:
    """An open context (`moderngl.Context`), with what the driver says of itself."""

    context: Any
    info: Mapping[str, str]

    @property
    def version(self) -> int:
        """OpenGL version as an integer: 450 for 4.5."""
        return int(self.context.version_code)

    @property
    def glsl(self) -> int:
        """The newest GLSL it takes, as `#version` has it: 330 for "3.30"."""
        found = re.match(r"(\d+)\.(\d\d)", self.info["glsl"])
        return int(found[1]) * 100 + int(found[2]) if found else REQUIRED_VERSION

    def close(self) -> None:
        """Give the context back."""
        self.context.release()


def open_device(driver: str) -> Device:
    """Open an OpenGL core context on EGL.

    Args:
        driver: a name of `shaderlab.backends.DRIVERS`. The choice holds for the process: Mesa
            reads it once.

    Raises:
        DriverError: there is no EGL, no driver, or none that offers OpenGL 3.3.
    """
    if driver in SOFTWARE:
        os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"
        os.environ["GALLIUM_DRIVER"] = driver
    os.environ.setdefault("EGL_PLATFORM", "surfaceless")
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
    import moderngl

    try:
        options: Any = {"standalone": True, "backend": "egl"}  # mistyped in moderngl's stubs
        context = moderngl.create_context(require=REQUIRED_VERSION, **options)
    except Exception as error:  # moderngl raises plain Exception for whatever EGL says
        raise DriverError(f"no OpenGL 3.3 context on EGL ({error})", remedy=INSTALL) from error
    context.gc_mode = "auto"
    return Device(context, _describe(context))


def _describe(context: Any) -> Mapping[str, str]:
    info = context.info
    import OpenGL

    OpenGL.ERROR_CHECKING = False  # the runner drains errors itself, once a draw
    from OpenGL import GL

    return {
        "renderer": str(info["GL_RENDERER"]),
        "vendor": str(info["GL_VENDOR"]),
        "version": str(info["GL_VERSION"]),
        "glsl": GL.glGetString(GL.GL_SHADING_LANGUAGE_VERSION).decode(errors="replace"),
        "max_texture_size": str(info["GL_MAX_TEXTURE_SIZE"]),
        "max_samples": str(info["GL_MAX_SAMPLES"]),
    }
