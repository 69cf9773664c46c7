"""A backend's sessions and what they share, the same for every graphics API."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any, Protocol

from shaderlab.model.case import Scene

from . import Backend, Size
from .passes import PassSession, ProgramCache
from .programs.prepare import Programs


class Device(Protocol):
    """What a backend opens; `info` as in `Backend`."""

    @property
    def info(self) -> Mapping[str, str]: ...


class DeviceBackend(Backend):
    """Draws scenes on one device; keeps programs from one to the next.

    A backend names the classes of its linker and of its sessions.
    """

    linker_class: type[ProgramCache[Any]]
    session_class: type[PassSession[Any, Any]]

    def __init__(self, device: Device) -> None:
        self.device: Any = device
        self.info = device.info
        self._linker = self.linker_class(device)

    @contextmanager
    def session(
        self, scene: Scene, programs: Programs, size: Size
    ) -> Iterator[PassSession[Any, Any]]:
        with self.in_use(), ExitStack() as stack:
            yield self.session_class(self._linker, scene, programs, size, stack)

    def release_caches(self) -> None:
        with self.in_use():
            self._linker.release()

    def in_use(self) -> AbstractContextManager[object]:
        """What a scene is drawn inside of, so that this thread may use the device."""
        return nullcontext()


_ROOM = 4 << 20
"""More bytes than Mesa's index of its cache takes, 1.3 MB."""


@contextmanager
def variables_set(wanted: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables for a while."""
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
    """What keeps Mesa from using its cache of shaders on a disk that is full: it maps a file there,
    and the kernel ends a process that writes to a page of it which finds no room (SIGBUS)."""
    given = os.environ.get("MESA_SHADER_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    with suppress(OSError, RuntimeError):  # no home
        folder = Path(given) if given else Path.home() / ".cache"
        there = next(each for each in (folder, *folder.absolute().parents) if each.exists())
        disk = os.statvfs(there)
        if disk.f_bavail * disk.f_frsize < _ROOM:
            return {"MESA_SHADER_CACHE_DISABLE": "true"}
    return {}
