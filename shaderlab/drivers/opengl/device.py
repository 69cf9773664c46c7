"""An OpenGL context on EGL, and OpenGL's functions and constants as PyOpenGL has them.

PyOpenGL chooses its platform once, from the environment, as it is imported: all modules of this
driver take it from here. `GL_1_0` and its like have the C functions, which move pixels as they are.
"""

from __future__ import annotations

import ctypes
import functools
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any

import glcontext

from shaderlab.errors import DriverError, UnsupportedError

from ..programs.prepare import PreparedDraw
from . import SPIRV, environment

if TYPE_CHECKING:
    from .tracing import CallRecorder

with environment():
    from OpenGL import GL as GL
    from OpenGL.error import GLError as GLError, NullFunctionError as NullFunctionError
    from OpenGL.raw.GL import _errors
    from OpenGL.raw.GL.ARB import gl_spirv as gl_spirv
    from OpenGL.raw.GL.VERSION import GL_1_0 as GL_1_0, GL_1_2 as GL_1_2, GL_1_3 as GL_1_3

ERROR_CHECKER = _errors._error_checker
"""What PyOpenGL checks errors with after each call, or None in a process without such checks."""


@functools.cache
def gl_constant(word: str) -> int:
    """Find a constant by its name as `shaderlab.model` has it: in lower case, bare. It is a number
    of PyOpenGL's, which knows its name.

    >>> hex(gl_constant("one_minus_src_alpha"))
    '0x303'
    """
    number: int = getattr(GL, f"GL_{word.upper()}")
    return number


def c_strings(texts: Sequence[str]) -> Any:
    """Return texts as C takes an array of them."""
    array = (ctypes.c_char_p * len(texts))(*(text.encode() for text in texts))
    return ctypes.cast(array, ctypes.POINTER(ctypes.POINTER(ctypes.c_char)))


INSTALL = (
    "Debian/Ubuntu: apt-get install libegl1 libgl1-mesa-dri · Fedora: dnf install "
    "mesa-libEGL mesa-dri-drivers · Arch: pacman -S mesa · or run `shaderlab doctor`"
)
REQUIRED_VERSION = 330
_TAKES_SPIRV = "GL_ARB_gl_spirv"
# As glcontext takes them. It would look for both in each context, which starts a program.
_LIBRARIES = {"libgl": "libGL.so.1", "libegl": "libEGL.so.1"}


class Device:
    """An open context. Several may be open in one process, and used in turn.

    Args:
        context: glcontext's.
        info: what the driver says of itself.
        driver: a name of `shaderlab.drivers.DRIVERS`.
        recorder: writes the context's calls down; None for a context that is the driver's own.

    Attributes:
        takes_spirv: whether it gets programs as SPIR-V modules.
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

    @cached_property
    def version(self) -> int:
        """OpenGL version as an integer: 450 for 4.5."""
        major, minor = map(int, self.info["version"].split()[0].split(".")[:2])
        return major * 100 + minor * 10

    @cached_property
    def extensions(self) -> frozenset[str]:
        """The names of the extensions that it has."""
        count = int(GL.glGetIntegerv(GL.GL_NUM_EXTENSIONS))
        return frozenset(GL.glGetStringi(GL.GL_EXTENSIONS, n).decode() for n in range(count))

    @property
    def glsl(self) -> int:
        """The newest GLSL it takes, as `#version` has it: 330 for "3.30"."""
        found = re.match(r"(\d+)\.(\d\d)", self.info["glsl"])
        return int(found[1]) * 100 + int(found[2]) if found else REQUIRED_VERSION

    def limit(self, word: str) -> int:
        """Return one of the driver's limits, such as "max_texture_size"."""
        return int(GL.glGetIntegerv(gl_constant(word)))

    def at(self, pass_name: str, draw: int | None = None) -> None:
        """Note the pass and the draw that calls are made for from now on."""
        if self.recorder is not None:
            self.recorder.place = (pass_name, draw)

    def reading(self) -> None:
        """Note that calls are the lab's own from now on: it reads what was drawn."""
        if self.recorder is not None:
            self.recorder.place = None

    def make_current(self) -> None:
        """Make the context the one that calls go to."""
        self.context.__enter__()

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """Make the context current for a while, and suspend PyOpenGL's check after each call, if
        the process has it on: the lab reads GL errors itself. Can be nested, in the use of another
        device too.

        The checks of compiling and linking can't be suspended: those two raise GLError.
        """
        _IN_USE.append(self)
        if ERROR_CHECKER is not None:
            ERROR_CHECKER.onBegin()  # as between glBegin and glEnd
        try:
            self.make_current()
            yield
        finally:
            del _IN_USE[max(n for n, device in enumerate(_IN_USE) if device is self)]
            if _IN_USE and _IN_USE[-1] is not self:
                _IN_USE[-1].make_current()
            # PyOpenGL's checks are the process's, not a context's.
            if ERROR_CHECKER is not None and not _IN_USE:
                ERROR_CHECKER.onEnd()


_IN_USE: list[Device] = []  # the innermost last


def _open_context(driver: str) -> Any:
    """Open a context of glcontext's, current from now on. Raises DriverError."""
    options = {"glversion": REQUIRED_VERSION, "mode": "standalone", **_LIBRARIES}
    try:
        with environment(driver):
            return glcontext.get_backend_by_name("egl")(**options)
    except Exception as error:  # glcontext raises plain Exception for whatever EGL says
        raise DriverError(f"no OpenGL 3.3 context on EGL ({error})", remedy=INSTALL) from error


@contextmanager
def fresh_context(device: Device) -> Iterator[Any]:
    """Open a separate context, current for a while, which takes with it what was made in it. The
    device's is untouched, and current again afterwards."""
    fresh = _open_context(device.driver)
    try:
        yield fresh
    finally:
        fresh.release()
        device.make_current()


def open_device(driver: str) -> Device:
    """Open an OpenGL core context on EGL.

    Args:
        driver: a name of `shaderlab.drivers.DRIVERS`. The choice holds for the process: Mesa
            reads it once.

    Raises:
        DriverError: there is no EGL, no driver, or none that offers OpenGL 3.3, or SPIR-V where
            the driver's name says so.
    """
    device = Device(_open_context(driver), {}, driver)

    def read(name: int) -> str:
        return str(GL.glGetString(name).decode(errors="replace"))

    renderer = read(GL.GL_RENDERER)
    if device.takes_spirv and _TAKES_SPIRV not in device.extensions:
        device.context.release()
        raise DriverError(
            f"driver {driver}: {renderer} takes no SPIR-V ({_TAKES_SPIRV})",
            remedy="Mesa's llvmpipe does, in version 21 or newer: --driver llvmpipe-spirv",
        )
    device.info = {
        "renderer": renderer + (", SPIR-V" if device.takes_spirv else ""),
        "vendor": read(GL.GL_VENDOR),
        "version": read(GL.GL_VERSION),
        "glsl": read(GL.GL_SHADING_LANGUAGE_VERSION),
        "max_texture_size": str(device.limit("max_texture_size")),
        "max_samples": str(device.limit("max_samples")),
    }
    return device


_READS_NUMBER = re.compile(r"\bgl_PrimitiveID\b")


def require_inputs(device: Device, draw: PreparedDraw) -> None:
    """Raise UnsupportedError for a fragment stage that reads a built-in input which the driver does
    not give it: softpipe (Mesa 22.3) draws nothing where gl_PrimitiveID is read."""
    fragment = next((s for s in draw.sources if s.stage == "fragment"), None)
    if fragment is None or "geometry" in draw.texts or not _READS_NUMBER.search(fragment.code):
        return
    if "softpipe" in device.info["renderer"]:
        raise UnsupportedError(
            "gl_PrimitiveID in a fragment stage: this driver draws nothing where it is read",
            file=fragment.path,
        )
