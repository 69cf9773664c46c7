"""Memory that the calling process and a worker share, so that arrays are not sent.

It has a path by which another process opens it: that of a file descriptor of this process on Linux,
where the memory has no name and no limit of its own, else that of a temporary file.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from dataclasses import dataclass

import numpy as np

from shaderlab.model.frame import Array


@dataclass(frozen=True)
class Region:
    """A piece of shared memory: the path and the size of the whole in bytes."""

    path: str
    size: int

    def opened(self) -> mmap.mmap:
        """The memory, in another process."""
        descriptor = os.open(self.path, os.O_RDWR)
        try:
            return mmap.mmap(descriptor, self.size)
        finally:
            os.close(descriptor)


class SharedMemory:
    """Shared memory that grows as it is asked for; what was in it is lost then."""

    def __init__(self) -> None:
        if hasattr(os, "memfd_create"):
            self._file = os.fdopen(os.memfd_create("shaderlab"), "r+b")
            self._path = f"/proc/{os.getpid()}/fd/{self._file.fileno()}"
        else:
            self._file = tempfile.NamedTemporaryFile()  # type: ignore[assignment]  # noqa: SIM115
            self._path = self._file.name
        self._size = 0
        self._map: mmap.mmap | None = None

    def words(self, count: int) -> Array:
        """The first `count` words, uint32."""
        if 4 * count > self._size or self._map is None:
            self._size = max(4 * count, 2 * self._size, mmap.PAGESIZE)
            os.ftruncate(self._file.fileno(), self._size)
            self._map = mmap.mmap(self._file.fileno(), self._size)
        return np.frombuffer(self._map, np.uint32, count)

    @property
    def region(self) -> Region:
        """How another process opens it."""
        return Region(self._path, self._size)
