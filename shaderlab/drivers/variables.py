"""Environment variables that a driver is opened with; the process gets them back as they were."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

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
