"""OpenGL on EGL, without a screen, beside what else the process does with OpenGL.

Mesa and PyOpenGL read how to open a driver from the environment. It is changed only while they
do, and put back. A process that is the lab's alone is prepared for good. Nothing here imports a
graphics API before a device is opened.
"""

import os
from contextlib import AbstractContextManager

from .. import Backend, mesa_variables, set_variables

SOFTWARE = ("llvmpipe", "softpipe")
SPIRV = "-spirv"
"""What the name of a driver ends with that gets programs as SPIR-V modules instead of text."""


def open_backend(driver: str) -> Backend:
    """Open an OpenGL device. Raises DriverError as `device.open_device` does."""
    from .backend import OpenGLBackend
    from .device import open_device

    return OpenGLBackend(open_device(driver))


def prepare_process(driver: str) -> None:
    """Set the driver's environment for good and turn PyOpenGL's checks off; to be called before
    anything imports PyOpenGL, in a process that nobody else uses."""
    os.environ.update(_variables(driver))
    _turn_checks_off()


def preload() -> None:
    """Import what `open_backend` needs, PyOpenGL without its checks, for a process of the lab."""
    _turn_checks_off()
    from . import backend

    _ = backend


def _turn_checks_off() -> None:
    import OpenGL

    OpenGL.ERROR_CHECKING = False


def environment(driver: str = "default") -> AbstractContextManager[None]:
    """The environment variables that a context of this driver is made with, for a while."""
    return set_variables(_variables(driver))


def _variables(driver: str) -> dict[str, str]:
    wanted = {
        name: os.environ.get(name, value)
        for name, value in (("EGL_PLATFORM", "surfaceless"), ("PYOPENGL_PLATFORM", "egl"))
    }
    mesas = driver.removesuffix(SPIRV)
    if mesas in SOFTWARE:
        wanted |= {"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": mesas}
    return wanted | mesa_variables()
