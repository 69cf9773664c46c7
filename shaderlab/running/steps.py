"""A file in which workers note what they are about to do, for whoever outlives them.

Each job has a slot of fixed size in one file that is mapped into memory: a note costs no system
call, and it stays when the process that wrote it is gone.
"""

from __future__ import annotations

import contextlib
import mmap
from collections.abc import Iterator
from pathlib import Path

SLOT = 256


class Steps:
    """The notes of a run's jobs, by slot.

    Args:
        path: the file; it must have been made by `create`.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with open(path, "r+b") as file:
            self._map = mmap.mmap(file.fileno(), 0)

    @classmethod
    def create(cls, path: Path, slots: int) -> Steps:
        """Make the file, with room for this many jobs (at least one)."""
        with open(path, "wb") as file:
            file.truncate(SLOT * max(slots, 1))
        return cls(path)

    def write(self, slot: int, step: str) -> None:
        """Note that the job in `slot` is about to do `step`."""
        text = step.encode("utf-8", "replace")[:SLOT]
        self._map[slot * SLOT : (slot + 1) * SLOT] = text.ljust(SLOT, b"\0")

    def read(self, slot: int) -> str:
        """The job's last step; "" if it did not come to one."""
        raw = self._map[slot * SLOT : (slot + 1) * SLOT]
        return raw.rstrip(b"\0").decode("utf-8", "ignore")

    @contextlib.contextmanager
    def removed_at_end(self) -> Iterator[None]:
        """Remove the file in the end; notes that are mapped stay readable."""
        try:
            yield
        finally:
            with contextlib.suppress(OSError):  # Windows keeps what is mapped
                self.path.unlink()

    def close(self) -> None:
        """Let the file go."""
        self._map.close()
