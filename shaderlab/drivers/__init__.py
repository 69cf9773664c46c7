"""The graphics APIs that scenes are drawn by: the protocol of a driver, which is a device with
sessions that draw one scene each, and the drivers that implement it.

Each driver's package is imported when a device of it is opened.
"""

from __future__ import annotations

import functools
import importlib
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from shaderlab.compiler.sources import Source
from shaderlab.errors import OtherApiError, UnsupportedError, UsageError, Verdict, suggest
from shaderlab.model.frame import Array, Bindings, Fragments, Image, PassDraw, Samples

if TYPE_CHECKING:
    from shaderlab.model.calls import CallEdit
    from shaderlab.model.case import Scene
    from shaderlab.model.scene import Pass
    from shaderlab.model.textures import TextureSource

    from .programs.captures import Probed
    from .programs.prepare import Programs

Size = tuple[int, int]
Answers = Mapping[str, Callable[..., Any]]
"""What answers a session's queries, by their names: functions of the session and the arguments."""


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """What drawing a scene gave, as in `Frame`; `inactive` are the uniforms without any effect."""

    images: Mapping[tuple[str, str], Image]
    bindings: Mapping[PassDraw, Bindings]
    gl_errors: Mapping[PassDraw, tuple[int, ...]] = field(default_factory=dict)
    inactive: frozenset[str] = field(default_factory=frozenset)
    sample_positions: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """Fragment shaders that compute words (uint32) at each pixel of a grid.

    Attributes:
        passes: each shader, and how many words it writes, to locations 0, 1, …
        shared: the uniform array "shaderlab_shared", (count, 4) of uint32.
        uniforms: others, by name.
        textures: what samplers read, by name: the sampler's type, and the texture.
        folder: what textures' files are relative to.
    """

    passes: tuple[tuple[Source, int], ...]
    size: Size
    shared: Array
    uniforms: Mapping[str, Array] = field(default_factory=dict)
    textures: Mapping[str, tuple[str, TextureSource]] = field(default_factory=dict)
    folder: str = ""


class Session(ABC):
    """One scene on a device. `draw` comes first; the rest is about what it drew.

    A driver overrides what it can do. All else raises UnsupportedError; what is about OpenGL's own
    calls raises OtherApiError where another API draws.

    Attributes:
        programs: each pass's draws, compiled.
        subpixel_step: the grid that corners are moved to before they are rasterised, in pixels.
        answers: what answers each of QUERIES, as functions of the session and of the arguments.
    """

    # Of OpenGL's drivers: Mesa reports the least that is allowed, 4 bits, and has 8.
    subpixel_step: float = 2.0**-8
    answers: ClassVar[Answers] = {}

    def __init__(self, scene: Scene, programs: Programs) -> None:
        self.scene = scene
        self.programs = programs

    @abstractmethod
    def draw(self, only: Container[str] | None = None) -> Drawn:
        """Draw the passes in order, all or only these, and read their attachments. Raises
        CaseError: the scene's data do not fit its programs or each other; ShaderError: the driver
        refuses a program."""

    def capture_fragments(self, key: PassDraw) -> Fragments:
        """Capture what a draw's fragment shader got, at each pixel that it was last to write."""
        raise UnsupportedError("capturing fragments: this driver can't")

    def capture_vertices(self, key: PassDraw) -> Samples:
        """Capture each vertex that a draw rasterises: what its last stage got and gave."""
        raise UnsupportedError("capturing vertices: this driver can't")

    def probe(
        self, key: PassDraw, stage: Probed, runs: Sequence[Bindings], inputs: Mapping[str, Array]
    ) -> list[Samples]:
        """Run a stage of a draw once for each row of `inputs`, (count, components), with the
        uniforms and textures of each of the `runs`."""
        raise UnsupportedError(f"running a {stage} stage on given inputs: this driver can't")

    def redraw_pass(self, changed: Pass, output: str, largest: int) -> Array:
        """Draw a pass of the scene once more with other target values or states, and read one
        attachment; the longer side has at most `largest` pixels, unless a state counts pixels."""
        raise UnsupportedError("drawing a pass with other states: this driver can't")

    def redraw_with_text(
        self, key: PassDraw, text: str, outputs: Mapping[str, str]
    ) -> Mapping[str, Array]:
        """Draw a pass up to one draw, with another fragment shader for that, and read some outputs
        (format by name) of its fragments, (height, width, components); zeros elsewhere."""
        raise UnsupportedError("drawing with another text: this driver can't")

    def query(self, name: str, *arguments: Any) -> Any:
        """Answer one of QUERIES about what was drawn."""
        answer = self.answers.get(name)
        if answer is not None:
            return answer(self, *arguments)
        if name in OPENGL_QUERIES:
            raise OtherApiError(f"{QUERIES[name]}: this driver draws by another API than OpenGL")
        raise UnsupportedError(f"{QUERIES[name].format(*arguments)}: this driver can't")


QUERIES: Mapping[str, str] = {
    "count": "counting {1}",
    "time": "timing a pass",
    "attributes": "reading where attributes lie",
    "blocks": "reading where the members of blocks lie",
    "attachment": "reading an attachment once more",
    "locations": "locations of uniforms",
    "gl_errors": "errors of OpenGL",
    "trace": "calls of OpenGL",
    "parameters": "functions of OpenGL",
    "call": "calls of OpenGL",
}
"""The queries of a session, and how errors name them.

| query | arguments | answer |
|---|---|---|
| count | draw, counter as in `shaderlab.query` | what the draw makes the driver count |
| time | pass, repeats | `Timing` |
| attributes | draw | `AttributeReading` of each attribute |
| blocks | draw | `BlockReading` of each uniform block |
| attachment | pass, name | the `Image` of a colour, "depth" or "stencil" |
| locations | draw | the location of each declared uniform; −1 for one without any effect |
| gl_errors | draw | the errors that it raised |
| trace | | a `TracedCall` for each call that drawing takes, without the lab's own reading |
| parameters | a function's C name | the names of its parameters |
| call | calls, expected values | the `Reply` to the last one, or the first that raises an error |
"""
OPENGL_QUERIES = ("locations", "gl_errors", "trace", "parameters", "call")


STORAGE_OF_PROBES = 7
"""The binding of what the lab counts in a buffer: the last that every driver has."""


class Backend(ABC):
    """An open device; `info` is the driver's "renderer", "vendor", "version", "glsl" and limits."""

    info: Mapping[str, str]

    @abstractmethod
    def session(
        self, scene: Scene, programs: Programs, size: Size
    ) -> AbstractContextManager[Session]:
        """A scene to draw and to ask about; its device memory is released at the end. `size` is
        (width, height) in pixels of targets that do not say."""

    def edited_session(
        self, scene: Scene, programs: Programs, size: Size, edit: CallEdit | None
    ) -> AbstractContextManager[Session]:
        """Open a session as `session` does, in a separate context, with one call changed.

        It holds for `draw` and for what `trace` tells of that; None changes no call. What the lab
        reads and captures is not touched. Raises ShaderlabError: the scene takes no such call."""
        raise UnsupportedError("changing calls of OpenGL: this driver can't")

    @abstractmethod
    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        """The driver's own verdict on a program, as a target named "driver". Raises DriverError:
        the driver has no such stage."""

    def require_compute(self) -> None:
        """Raise UnsupportedError where there are no compute passes."""
        raise UnsupportedError("compute passes run on OpenGL drivers only")

    def storage(self, count: int, binding: int = 0) -> AbstractContextManager[Callable[[], Array]]:
        """A storage buffer of `count` zeros (uint32), bound as this binding of all that is drawn
        meanwhile; gives a function that reads it, (count,). Raises UnsupportedError: there are no
        storage buffers."""
        raise UnsupportedError("storage buffers: this driver has none")

    def evaluate(self, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
        """Run an evaluation's passes on the texture array "shaderlab_input", `inputs`: (layers,
        height, width) of uint32. `outputs` gets the words, one after the other, (words, height,
        width) of uint32; 0 where a pixel was discarded. Raises ShaderError: the driver refuses a
        shader; CaseError: a texture does not fit its sampler."""
        raise UnsupportedError("calling functions: this driver can't")

    @abstractmethod
    def close(self) -> None:
        """Release the device."""


MODULES: Mapping[str, str] = {
    "llvmpipe": "shaderlab.drivers.opengl",
    "softpipe": "shaderlab.drivers.opengl",
    "default": "shaderlab.drivers.opengl",
    "llvmpipe-spirv": "shaderlab.drivers.opengl",
    "lavapipe": "shaderlab.drivers.vulkan",
    "swiftshader": "shaderlab.drivers.vulkan",
    "vulkan": "shaderlab.drivers.vulkan",
    "webgl2": "shaderlab.drivers.webgl",
}
"""Each driver's name, and the module that opens it: with `open_backend` and `prepare_process`,
both of which take the driver's name."""
DRIVERS = tuple(MODULES)


def known_driver(name: str | None = None) -> str:
    """The driver to use: `name`, or else SHADERLAB_DRIVER, or else "llvmpipe". Raises UsageError:
    it is not one of DRIVERS."""
    chosen = name or os.environ.get("SHADERLAB_DRIVER") or DRIVERS[0]
    if chosen not in MODULES:
        raise UsageError(f"unknown driver {chosen!r}", remedy=suggest(chosen, MODULES))
    return chosen


def open_backend(driver: str | None = None) -> Backend:
    """Open a device, without a screen.

    Args:
        driver: one of DRIVERS; None reads SHADERLAB_DRIVER, then takes "llvmpipe", Mesa's
            software driver, which is the same everywhere. "default" is the machine's own of
            OpenGL, "vulkan" that of Vulkan, "webgl2" that of a browser.

    Raises DriverError: there is no such driver here, or it offers too little; UsageError: `driver`
    is not one of DRIVERS."""
    chosen = known_driver(driver)
    backend: Backend = importlib.import_module(MODULES[chosen]).open_backend(chosen)
    return backend


def prepare_process(driver: str | None = None) -> None:
    """Set this process up for a driver, for good: its environment and its packages' checks.

    For a process that is the lab's alone; it is called before anything else opens a device.
    """
    chosen = known_driver(driver)
    importlib.import_module(MODULES[chosen]).prepare_process(chosen)


def preload(driver: str | None = None) -> None:
    """Import what a device of a driver needs, without opening one, where its module knows how to.

    For a process that is the lab's alone. What can't be imported is reported by opening a device.
    """
    with suppress(Exception):
        load = getattr(importlib.import_module(MODULES[known_driver(driver)]), "preload", None)
        if load is not None:
            load()


def record_calls(*given: Any) -> tuple[bytes, str]:
    """Return the calls of WebGL2 that draw a scene's picture, for a page to play, or why there are
    none; the arguments are those of `record_calls` in `webgl.live`."""
    made: tuple[bytes, str] = importlib.import_module(f"{__name__}.webgl.live").record_calls(*given)
    return made


def probe(driver: str | None = None) -> Mapping[str, str]:
    """Open a device, read what it is, close it. Takes and raises what `open_backend` does."""
    backend = open_backend(driver)
    try:
        return backend.info
    finally:
        backend.close()


def driver_verdict(sources: Sequence[Source], driver: str | None = None) -> Verdict:
    """`Backend.driver_verdict` on a device of this process's own, opened at the first call.

    Workers call it by its name: "shaderlab.drivers:driver_verdict".
    """
    return _own_backend(driver).driver_verdict(sources)


_own_backend = functools.cache(open_backend)


# More bytes than Mesa's index of its cache takes, 1.3 MB.
_INDEX_BYTES = 4 << 20


@contextmanager
def set_variables(wanted: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables, and restore them afterwards."""
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


def mesa_variables() -> dict[str, str]:
    """Return what keeps Mesa from caching shaders on a full disk: it maps a file there, and the
    kernel ends a process that writes to a page of it for which there is no space (SIGBUS)."""
    given = os.environ.get("MESA_SHADER_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    with suppress(OSError, RuntimeError):  # no home
        folder = Path(given) if given else Path.home() / ".cache"
        there = next(each for each in (folder, *folder.absolute().parents) if each.exists())
        disk = os.statvfs(there)
        if disk.f_bavail * disk.f_frsize < _INDEX_BYTES:
            return {"MESA_SHADER_CACHE_DISABLE": "true"}
    return {}
