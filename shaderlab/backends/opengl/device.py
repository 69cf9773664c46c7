"""Opening OpenGL without a screen, beside what else the process does with OpenGL.

Mesa and PyOpenGL read how to open a driver from the environment. It is changed only while a
context is made, and put back. PyOpenGL's own check after each call is suspended only while the
lab draws, which reads GL errors itself. A process that is the lab's alone gives both up for good
(`prepare_process`).
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from shaderlab.errors import DriverError

SOFTWARE = ("llvmpipe", "softpipe")
INSTALL = (
    "Debian/Ubuntu: apt-get install libegl1 libgl1-mesa-dri · Fedora: dnf install "
    "mesa-libEGL mesa-dri-drivers · Arch: pacman -S mesa · or run `shaderlab doctor`"
)
REQUIRED_VERSION = 330


class Device:
    """An open context.

    Args:
        context: a `moderngl.Context`.
        info: what the driver says of itself.
        driver: a name of `shaderlab.backends.DRIVERS`.
    """

    def __init__(self, context: Any, info: Mapping[str, str], driver: str = "default") -> None:
        self.context = context
        self.info = info
        self.driver = driver
        self._suspended = 0

    @property
    def version(self) -> int:
        """OpenGL version as an integer: 450 for 4.5."""
        return int(self.context.version_code)

    @property
    def glsl(self) -> int:
        """The newest GLSL it takes, as `#version` has it: 330 for "3.30"."""
        found = re.match(r"(\d+)\.(\d\d)", self.info["glsl"])
        return int(found[1]) * 100 + int(found[2]) if found else REQUIRED_VERSION

    @contextmanager
    def unchecked(self) -> Iterator[None]:
        """Suspend PyOpenGL's check after each call, if the process has it on; can be nested.

        The checks of compiling and linking can't be suspended: those two raise GLError.
        """
        from OpenGL.raw.GL import _errors

        checker = _errors._error_checker
        self._suspended += 1
        if checker is not None:
            checker.onBegin()  # as between glBegin and glEnd
        try:
            yield
        finally:
            self._suspended -= 1
            if checker is not None and not self._suspended:
                checker.onEnd()

    def close(self) -> None:
        """Release the context."""
        self.context.release()


def open_device(driver: str) -> Device:
    """Open an OpenGL core context on EGL.

    Args:
        driver: a name of `shaderlab.backends.DRIVERS`. The choice holds for the process: Mesa
            reads it once.

    Raises:
        DriverError: there is no EGL, no driver, or none that offers OpenGL 3.3.
    """
    import moderngl

    with environment(driver):
        try:
            options: Any = {"standalone": True, "backend": "egl"}  # mistyped in moderngl's stubs
            context = moderngl.create_context(require=REQUIRED_VERSION, **options)
        except Exception as error:  # moderngl raises plain Exception for whatever EGL says
            raise DriverError(f"no OpenGL 3.3 context on EGL ({error})", remedy=INSTALL) from error
        context.gc_mode = "auto"
        return Device(context, _describe(context), driver)


@contextmanager
def environment(driver: str) -> Iterator[None]:
    """The environment variables that a context of this driver is made with, for a while."""
    wanted = _variables(driver)
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def prepare_process(driver: str) -> None:
    """Give this process to the lab: set the driver's environment and turn PyOpenGL's checks off,
    for good. To be called before anything imports PyOpenGL, by a process that nobody else uses."""
    os.environ.update(_variables(driver))
    import OpenGL

    OpenGL.ERROR_CHECKING = False


def _variables(driver: str) -> dict[str, str]:
    """What differs from the environment as it is."""
    wanted = {
        name: os.environ.get(name, value)
        for name, value in (("EGL_PLATFORM", "surfaceless"), ("PYOPENGL_PLATFORM", "egl"))
    }
    if driver in SOFTWARE:
        wanted |= {"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": driver}
    return wanted


def _describe(context: Any) -> Mapping[str, str]:
    from OpenGL import GL

    info = context.info
    return {
        "renderer": str(info["GL_RENDERER"]),
        "vendor": str(info["GL_VENDOR"]),
        "version": str(info["GL_VERSION"]),
        "glsl": GL.glGetString(GL.GL_SHADING_LANGUAGE_VERSION).decode(errors="replace"),
        "max_texture_size": str(info["GL_MAX_TEXTURE_SIZE"]),
        "max_samples": str(info["GL_MAX_SAMPLES"]),
    }
