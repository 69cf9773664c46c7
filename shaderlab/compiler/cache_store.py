"""Bytes by key in a folder. Nothing here raises: what can't be read is absent, what can't be
written is not stored.

Each entry is a file that is written whole or not at all, so several processes can share a folder.
It begins with a checksum of its key and content; a file that was cut short, changed or renamed is
absent. When the folder outgrows its limit the entries that were least recently used go first.

docs/internals/measurements.md compares it with sqlite3, of which one damaged page costs the whole
cache, and whose locks don't work on every network folder.
"""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from shaderlab.files import open_regular, write_bytes

LIMIT = 256 << 20
_BLOCK = 4096  # bytes of disk that the smallest file takes
_CHECKSUM = 32
_FOLDERS = 16
_HOUR = 3600.0
# Tells backup programs that this is a cache: Cache Directory Tagging Specification, B. Ford, 2004.
_SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55\n"


@dataclass(frozen=True)
class Usage:
    """How many entries a store has, and how many bytes of disk they take."""

    entries: int
    size: int


class Store:
    """A folder of entries, created when the first one is put into it.

    Args:
        folder: where entries lie, in sixteen folders by the first digit of their keys.
        limit: bytes of disk for all entries, exceeded by a few entries at most. Each of the
            sixteen folders may take a sixteenth of it; larger entries are not stored.
    """

    def __init__(self, folder: Path, limit: int = LIMIT) -> None:
        self.folder = folder
        self._name = str(folder)  # joining strings is several times as fast as joining paths
        self._share = limit // _FOLDERS

    def get(self, key: str) -> bytes | None:
        """The content stored under a hexadecimal key, or None."""
        path = self._path(key)
        try:
            with open(open_regular(path), "rb") as file:
                stat = os.fstat(file.fileno())
                data = file.read() if stat.st_size <= self._share else b""
        except OSError:
            return None
        content = data[_CHECKSUM:]
        if data[:_CHECKSUM] != _checksum(key, content):
            return None
        if time.time() - stat.st_mtime > _HOUR:  # so the time of use is known to the hour
            with suppress(OSError):
                os.utime(path)
        return content

    def put(self, key: str, content: bytes) -> None:
        """Store content under a hexadecimal key, removing old entries to make room."""
        data = _checksum(key, content) + content
        if _on_disk(len(data)) > self._share:
            return
        path = self._path(key)
        folder = os.path.dirname(path)
        with suppress(OSError):
            if not os.path.isdir(folder):
                self._make(folder)
            write_bytes(path, data)
            if key[1:3] == "00":  # one time in 256, since it looks at every file of the folder
                self._trim(folder)

    def usage(self) -> Usage:
        """What is stored now; looks at every file."""
        sizes: list[int] = []
        with suppress(OSError):
            for folder in list(os.scandir(self.folder)):
                sizes += [size for _, size, _ in _files(folder.path)] if folder.is_dir() else []
        return Usage(len(sizes), sum(sizes))

    def _path(self, key: str) -> str:
        return os.path.join(self._name, key[:1], key[1:])

    def _make(self, folder: str) -> None:
        if not self.folder.is_dir():
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / "CACHEDIR.TAG").write_text(_SIGNATURE, encoding="ascii")
        os.makedirs(folder, exist_ok=True)

    def _trim(self, folder: str) -> None:
        """Shrink a folder to 7/8 of its share, and remove drafts of processes that died."""
        found = sorted(_files(folder))
        total = sum(size for _, size, _ in found)
        for used, size, path in found:
            abandoned = os.path.basename(path).startswith(".") and time.time() - used > _HOUR
            if total > self._share * 7 // 8 or abandoned:
                with suppress(FileNotFoundError):
                    os.unlink(path)
                total -= size


def _files(folder: str) -> Iterator[tuple[float, int, str]]:
    """A folder's files: when each was last used, the bytes of disk it takes, its path."""
    with os.scandir(folder) as entries:
        for entry in entries:
            with suppress(FileNotFoundError):  # another process was faster
                stat = entry.stat(follow_symlinks=False)
                yield stat.st_mtime, _on_disk(stat.st_size), entry.path


def _on_disk(size: int) -> int:
    return -(-size // _BLOCK) * _BLOCK


def _checksum(key: str, content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_CHECKSUM, key=bytes.fromhex(key)).digest()
