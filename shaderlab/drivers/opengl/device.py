"""An open OpenGL context, and what the driver says of itself."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from ctypes.util import find_library
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

import moderngl

from shaderlab.errors import DriverError

from . import SPIRV, environment
from .pyopengl import ERROR_CHECKER, GL

if TYPE_CHECKING:
    from .call_recorder import CallRecorder

INSTALL = (
    "Debian/Ubuntu: apt-get install libegl1 libgl1-mesa-dri · Fedora: dnf install "
    "mesa-libEGL mesa-dri-drivers · Arch: pacman -S mesa · or run `shaderlab doctor`"
)
REQUIRED_VERSION = 330
_TAKES_SPIRV = "GL_ARB_gl_spirv"
_NOTHING = "#version 330 core\nvoid main() { gl_Position = vec4(0.0); }\n"


@cache
def libraries() -> Mapping[str, str]:
    """The libraries of GL and EGL as glcontext takes them. It would look for both in each context
    that it makes, which starts a program; so does Python where neither has its usual name."""
    found = {"libgl": _library("GL"), "libegl": _library("EGL")}
    return {name: file for name, file in found.items() if file}


def _library(name: str) -> str | None:
    usual = f"lib{name}.so.1"
    try:
        ctypes.CDLL(usual)
    except OSError:
        return find_library(name)
    return usual


class Device:
    """An open context. Several may be open in one process, and used in turn.

    Args:
        context: a `moderngl.Context`.
        info: what the driver says of itself.
        driver: a name of `shaderlab.drivers.DRIVERS`.
        recorder: writes the context's calls down; None for a context that is the driver's own.

    Attributes:
        takes_spirv: whether it gets programs as SPIR-V modules.
        probed: what `probes` found out so far.
    """

    def __init__(
        self,
        context: Any,
        info: Mapping[str, str],
        driver: str = "default",
        recorder: CallRecorder | None = None,
    ) -> None:
        self.context = context
        self.info = info
        self.driver = driver
        self.recorder = recorder
        self.takes_spirv = driver.endswith(SPIRV)
        self.probed: dict[str, bool] = {}

    @cached_property
    def any_program(self) -> Any:
        """A program without any inputs, for what moderngl makes for a program of its own only."""
        return self.context.program(vertex_shader=_NOTHING)

    @property
    def version(self) -> int:
        """OpenGL version as an integer: 450 for 4.5."""
        return int(self.context.version_code)

    @property
    def glsl(self) -> int:
        """The newest GLSL it takes, as `#version` has it: 330 for "3.30"."""
        found = re.match(r"(\d+)\.(\d\d)", self.info["glsl"])
        return int(found[1]) * 100 + int(found[2]) if found else REQUIRED_VERSION

    def at(self, pass_name: str, draw: int | None = None) -> None:
        """Note the pass and the draw that calls are made for from now on."""
        if self.recorder is not None:
            self.recorder.place = (pass_name, draw)

    def reading(self) -> None:
        """Note that calls are the lab's own from now on: it reads what was drawn."""
        if self.recorder is not None:
            self.recorder.place = None

    def make_current(self) -> None:
        """Make the context the one that calls go to, and give back what Python has dropped.

        Objects are deleted by their numbers, which mean something else in another context: what
        is dropped waits until its own one is current.
        """
        self.context.__enter__()
        waiting = self.context.objects
        while waiting:
            dropped = waiting.popleft()
            if hasattr(dropped, "release"):  # else it was released before Python dropped it
                dropped.release()

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """Make the context current for a while, and suspend checks as `unchecked` does. Can be
        nested, in the use of another device too."""
        self.make_current()
        _IN_USE.append(self)
        try:
            with self.unchecked():
                yield
        finally:
            del _IN_USE[max(n for n, device in enumerate(_IN_USE) if device is self)]
            if _IN_USE and _IN_USE[-1] is not self:
                _IN_USE[-1].make_current()

    @contextmanager
    def unchecked(self) -> Iterator[None]:
        """Suspend PyOpenGL's check after each call, if the process has it on: the lab reads GL
        errors itself. Can be nested.

        The checks of compiling and linking can't be suspended: those two raise GLError.
        """
        _UNCHECKED.append(self)
        if ERROR_CHECKER is not None:
            ERROR_CHECKER.onBegin()  # as between glBegin and glEnd
        try:
            yield
        finally:
            _UNCHECKED.pop()
            if ERROR_CHECKER is not None and not _UNCHECKED:
                ERROR_CHECKER.onEnd()


_IN_USE: list[Device] = []  # the innermost last
_UNCHECKED: list[Device] = []  # PyOpenGL's checks are the process's, not a context's


def open_device(driver: str) -> Device:
    """Open an OpenGL core context on EGL.

    Args:
        driver: a name of `shaderlab.drivers.DRIVERS`. The choice holds for the process: Mesa
            reads it once.

    Raises:
        DriverError: there is no EGL, no driver, or none that offers OpenGL 3.3, or SPIR-V where
            that is asked for.
    """
    # Any: mistyped in moderngl's stubs.
    options: Any = {"standalone": True, "backend": "egl", **libraries()}
    try:
        with environment(driver):
            context = moderngl.create_context(require=REQUIRED_VERSION, **options)
    except Exception as error:  # moderngl raises plain Exception for whatever EGL says
        raise DriverError(f"no OpenGL 3.3 context on EGL ({error})", remedy=INSTALL) from error
    context.gc_mode = "context_gc"  # see Device.make_current
    if driver.endswith(SPIRV) and _TAKES_SPIRV not in context.extensions:
        raise DriverError(
            f"driver {driver}: {context.info['GL_RENDERER']} takes no SPIR-V ({_TAKES_SPIRV})",
            remedy="Mesa's llvmpipe does, in version 21 or newer: --driver llvmpipe-spirv",
        )
    known = context.info
    info = {
        "renderer": str(known["GL_RENDERER"]) + (", SPIR-V" if driver.endswith(SPIRV) else ""),
        "vendor": str(known["GL_VENDOR"]),
        "version": str(known["GL_VERSION"]),
        "glsl": GL.glGetString(GL.GL_SHADING_LANGUAGE_VERSION).decode(errors="replace"),
        "max_texture_size": str(known["GL_MAX_TEXTURE_SIZE"]),
        "max_samples": str(known["GL_MAX_SAMPLES"]),
    }
    return Device(context, info, driver)
