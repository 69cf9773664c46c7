"""Which files of a project a process reads: what a verdict depends on."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from shaderlab.discovery import is_own


class OpenedFiles:
    """Notes the files that this process opens for reading, those that are not there too.

    Python can't take an audit hook back: a process has one of these, and keeps it.
    """

    def __init__(self) -> None:
        self._names: set[str] | None = None
        sys.addaudithook(self._hear)

    @contextmanager
    def noted(self) -> Iterator[set[Path]]:
        """The files of the project that the block reads; filled when it ends."""
        found: set[Path] = set()
        self._names = set()
        try:
            yield found
        finally:
            names, self._names = self._names, None
            found |= {path for path in map(_source, names) if is_own(path)}

    def _hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        if event != "open" or self._names is None:
            return
        name, _, flags = arguments
        if isinstance(name, str | bytes) and flags & os.O_ACCMODE == os.O_RDONLY:
            self._names.add(os.fsdecode(name))


def _source(name: str) -> Path:
    """A file's path; that of the source where Python reads what it has compiled."""
    if name.endswith(".pyc"):
        with contextlib.suppress(ValueError, NotImplementedError):
            name = importlib.util.source_from_cache(name)
    return Path(os.path.abspath(name))
