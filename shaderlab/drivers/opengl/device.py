"""An OpenGL context on EGL, its fixed-function state, and functions and constants of PyOpenGL's.

PyOpenGL chooses its platform once, from the environment, as it is imported: all modules of this
driver take it from here. `GL_1_0` and its like have the C functions, which move pixels as they are.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import moderngl

from shaderlab.errors import DriverError, UnsupportedError
from shaderlab.model.state import State

from ..gl_state import state_calls
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
    """Find the number of a constant by its name as `shaderlab.model` has it: in lower case, bare.

    >>> hex(gl_constant("one_minus_src_alpha"))
    '0x303'
    """
    return int(getattr(GL, f"GL_{word.upper()}"))


def resolve_call(name: str, *given: Any) -> tuple[str, Sequence[Any]]:
    """Name the function and the arguments of a call that `drivers.gl_state` describes."""
    return f"gl{name}", [gl_constant(each) if isinstance(each, str) else each for each in given]


INSTALL = (
    "Debian/Ubuntu: apt-get install libegl1 libgl1-mesa-dri · Fedora: dnf install "
    "mesa-libEGL mesa-dri-drivers · Arch: pacman -S mesa · or run `shaderlab doctor`"
)
REQUIRED_VERSION = 330
# Mesa gives its newest version in any case, NVIDIA's driver no more than was asked for.
_VERSIONS = (460, 450, 430, 410, REQUIRED_VERSION)
SPIRV_EXTENSION = "GL_ARB_gl_spirv"
_NOTHING = "#version 330 core\nvoid main() { gl_Position = vec4(0.0); }\n"


# As glcontext takes them. It would look for both in each context, which starts a program.
LIBRARIES = {"libgl": "libGL.so.1", "libegl": "libEGL.so.1"}


@dataclass(eq=False)
class Device:
    """An open `moderngl.Context`. Several may be open in one process, and used in turn; `recorder`
    writes the calls of one that is not the driver's own down."""

    context: Any
    info: Mapping[str, str]
    driver: str = "default"
    recorder: CallRecorder | None = None

    @property
    def takes_spirv(self) -> bool:
        """Whether it gets programs as SPIR-V modules."""
        return self.driver.endswith(SPIRV)

    @cached_property
    def any_program(self) -> Any:
        """A program without any inputs, for what moderngl makes only for one of its programs."""
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

    def at(self, pass_name: str | None, draw: int | None = None) -> None:
        """As `PassSession.at`."""
        if self.recorder is not None:
            self.recorder.place = None if pass_name is None else (pass_name, draw)

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
        """Make the context current for a while, and suspend PyOpenGL's check after each call, if
        the process has it on: the lab reads GL errors itself. Can be nested, over devices too.

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


def open_device(driver: str) -> Device:
    """Open an OpenGL core context on EGL. The choice of a driver holds for the process: Mesa reads
    it once. Raises DriverError: there is no EGL, no driver, or none that offers OpenGL 3.3, or
    SPIR-V where the driver's name says so."""
    # Any: mistyped in moderngl's stubs.
    options: Any = {"standalone": True, "backend": "egl", **LIBRARIES}
    with environment(driver):
        for version in _VERSIONS if driver == "default" else (REQUIRED_VERSION,):
            try:
                context = moderngl.create_context(require=version, **options)
                break
            except Exception as error:  # moderngl raises plain Exception for whatever EGL says
                if version == REQUIRED_VERSION:
                    raise DriverError(
                        f"no OpenGL 3.3 context on EGL ({error})", remedy=INSTALL
                    ) from error
    context.gc_mode = "context_gc"  # see Device.make_current
    if driver.endswith(SPIRV) and SPIRV_EXTENSION not in context.extensions:
        raise DriverError(
            f"driver {driver}: {context.info['GL_RENDERER']} takes no SPIR-V ({SPIRV_EXTENSION})",
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


def apply_state(state: State, size: tuple[int, int], version: int) -> None:
    """Make the current context's state what `state` says, for a target of `size` pixels.

    `version` is the context's OpenGL version: 450 for 4.5.
    """
    try:
        calls = _list_calls(state, size, version)
    except TypeError:  # rectangles may be lists, which no cache takes
        calls = _list_calls.__wrapped__(state, size, version)
    for name, given in calls:
        getattr(GL, name)(*given)


@functools.lru_cache(maxsize=512)
def _list_calls(
    state: State, size: tuple[int, int], version: int
) -> Sequence[tuple[str, Sequence[Any]]]:
    switches = {
        "polygon_offset_line": False,  # a driver may take it for that of filled polygons
        "framebuffer_srgb": state.srgb,
        "program_point_size": isinstance(state.point_size, str),
        "multisample": state.multisample,
    }
    calls: list[tuple[Any, ...]] = []
    if version >= 400:
        switches["sample_shading"] = state.sample_shading is not None
        calls.append(("MinSampleShading", state.sample_shading or 0.0))
    elif state.sample_shading is not None:
        raise UnsupportedError("shading each sample (sample_shading): it takes OpenGL 4.0")
    calls += state_calls(state, size, switches)
    calls.append(
        ("PointSize", state.point_size if isinstance(state.point_size, int | float) else 1.0)
    )
    return [resolve_call(*call) for call in calls]
