"""What the lab asks of a graphics API: a small protocol, and the drivers that answer it.

A backend is one module that this one names by driver and imports when it is asked for.
"""

from __future__ import annotations

import functools
import importlib
import os
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Protocol

from shaderlab.errors import UsageError, nearest
from shaderlab.frame import (
    Array,
    AttributeReading,
    Bindings,
    BlockReading,
    Fragments,
    Image,
    PassDraw,
    Reply,
    Samples,
    Timing,
)
from shaderlab.glsl.sources import Source
from shaderlab.model import GlCall, Scene
from shaderlab.programs.prepare import Programs
from shaderlab.records import Verdict

Size = tuple[int, int]

# The module that opens each driver, by the driver's name.
_MODULES = {
    "llvmpipe": "shaderlab.backends.opengl",
    "softpipe": "shaderlab.backends.opengl",
    "default": "shaderlab.backends.opengl",
}
DRIVERS = tuple(_MODULES)


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """What drawing a scene's passes gave, as in `Frame`; `inactive` are the uniforms without any
    effect."""

    images: Mapping[tuple[str, str], Image]
    bindings: Mapping[PassDraw, Bindings]
    gl_errors: Mapping[PassDraw, tuple[int, ...]] = field(default_factory=dict)
    inactive: frozenset[str] = field(default_factory=frozenset)
    sample_positions: Mapping[str, Array] = field(default_factory=dict)


class Session(Protocol):
    """One scene on a device. `draw` comes first; the rest answers questions about that draw.

    Every method raises UnsupportedError for what the backend or its driver can't do.
    """

    @property
    def scene(self) -> Scene:
        """What is drawn."""
        ...

    @property
    def programs(self) -> Programs:
        """Each pass's draws, compiled."""
        ...

    def draw(self) -> Drawn:
        """Draw all passes in order and read their attachments.

        Raises:
            CaseError: the scene's data do not fit its programs or each other.
            ShaderError: the driver refuses a program.
        """
        ...

    def fragments(self, key: PassDraw) -> Fragments:
        """What the fragment shader of a draw got, at each pixel that it was the last to write."""
        ...

    def vertices(self, key: PassDraw) -> Samples:
        """Every vertex that a draw hands to rasterisation: what its last stage got and gave."""
        ...

    def probe_fragments(
        self, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
    ) -> Samples:
        """Run a draw's fragment stage once for each row of `inputs`, (count, components)."""
        ...

    def probe_vertices(
        self, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
    ) -> Samples:
        """Run a draw's vertex stage once for each row of `inputs`, (count, components)."""
        ...

    def count(self, key: PassDraw, counter: str) -> int:
        """What a draw makes the driver count; `counter` as in `shaderlab.query`."""
        ...

    def time(self, pass_name: str, repeats: int) -> Timing:
        """How long a pass takes to draw, each of so many times."""
        ...

    def attributes(self, key: PassDraw) -> Mapping[str, AttributeReading]:
        """Where the API reads each attribute of a draw."""
        ...

    def blocks(self, key: PassDraw) -> Mapping[str, BlockReading]:
        """Where the driver has the members of each uniform block of a draw's program."""
        ...

    def locations(self, key: PassDraw) -> Mapping[str, int]:
        """Where the driver put each declared uniform; −1 for one without any effect."""
        ...

    def call(self, expectation: GlCall) -> Reply:
        """What the API itself answers to a call. OpenGL alone has an answer.

        Raises:
            CaseError: a function, a constant, an argument or a pass does not exist.
        """
        ...


class Backend(Protocol):
    """An open device."""

    @property
    def info(self) -> Mapping[str, str]:
        """What the driver says of itself: renderer, vendor, version, glsl, and its limits."""
        ...

    def session(
        self, scene: Scene, programs: Programs, size: Size, *, temporary_programs: bool = False
    ) -> AbstractContextManager[Session]:
        """A scene to draw and to ask about; its device memory is released at the end.

        Args:
            scene: what to draw.
            programs: each pass's draws, compiled.
            size: (width, height) in pixels of targets that do not say.
            temporary_programs: release what is linked for this session at its end too, as of
                shaders that are drawn only once.
        """
        ...

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        """The driver's own verdict on a program, as a target named "driver".

        Raises:
            DriverError: the driver has no such stage.
        """
        ...

    def close(self) -> None:
        """Give the device back."""
        ...


def known_driver(name: str | None = None) -> str:
    """The driver to use: `name`, or else SHADERLAB_DRIVER, or else "llvmpipe".

    Raises:
        UsageError: it is not one of DRIVERS.
    """
    chosen = name or os.environ.get("SHADERLAB_DRIVER") or DRIVERS[0]
    if chosen not in DRIVERS:
        raise UsageError(f"unknown driver {chosen!r}", remedy=nearest(chosen, DRIVERS))
    return chosen


def open_backend(driver: str | None = None) -> Backend:
    """Open a device, without a screen.

    Args:
        driver: one of DRIVERS; None reads SHADERLAB_DRIVER, then takes "llvmpipe", Mesa's
            software driver, which is the same everywhere. "default" is the machine's own.

    Raises:
        DriverError: there is no such driver here, or it offers too little.
        UsageError: `driver` is not one of DRIVERS.
    """
    chosen = known_driver(driver)
    backend: Backend = importlib.import_module(_MODULES[chosen]).open_backend(chosen)
    return backend


def prepare_process(driver: str | None = None) -> None:
    """Give this process to a driver for good, as only a process of the lab's own may: its
    environment and the checks of its packages are set for the driver. To be called first."""
    chosen = known_driver(driver)
    importlib.import_module(_MODULES[chosen]).prepare_process(chosen)


def probe() -> Mapping[str, str]:
    """Open a device, read what it is, close it. Raises DriverError as `open_backend` does."""
    backend = open_backend()
    try:
        return backend.info
    finally:
        backend.close()


def driver_verdict(sources: Sequence[Source]) -> Verdict:
    """`Backend.driver_verdict` on a device of this process's own, opened at the first call.

    For workers, which are told by name what to call: "shaderlab.backends:driver_verdict".
    """
    return _own_backend().driver_verdict(sources)


@functools.cache
def _own_backend() -> Backend:
    return open_backend()
