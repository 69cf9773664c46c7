"""The graphics APIs that scenes are drawn by: the protocol, and the drivers that implement it.

Each driver's package is imported when a device of it is opened.
"""

from __future__ import annotations

import functools
import importlib
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from shaderlab.compiler.sources import Source
from shaderlab.errors import UsageError, suggest
from shaderlab.model.records import Verdict

from .protocol import (
    Backend as Backend,
    Drawn as Drawn,
    Evaluation as Evaluation,
    Session as Session,
    Size as Size,
)

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
    """The driver to use: `name`, or else SHADERLAB_DRIVER, or else "llvmpipe".

    Raises:
        UsageError: it is not one of DRIVERS.
    """
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

    Raises:
        DriverError: there is no such driver here, or it offers too little.
        UsageError: `driver` is not one of DRIVERS.
    """
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

    For a process that is the lab's alone and forks others. What can't be imported is left to those
    who open a device, and who say so.
    """
    with suppress(Exception):
        load = getattr(importlib.import_module(MODULES[known_driver(driver)]), "preload", None)
        if load is not None:
            load()


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


@functools.cache
def _own_backend(driver: str | None) -> Backend:
    return open_backend(driver)


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
