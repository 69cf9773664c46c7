"""Bytes by key in a folder, for whoever can do without them: what can't be read is not there, what
can't be written is not kept, and nothing here raises.

Each entry is a file, written beside its place and then moved there, so that processes can read and
write at once. It begins with a seal of its key and its content: a file that was cut short, changed
or put in another one's place is as good as none. What was not used for longest goes when the
folder grows beyond its limit; use is noted to the hour.
"""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from shaderlab.files import write_bytes

LIMIT = 256 << 20
_BLOCK = 4096  # what the smallest file takes of a disk
_SEAL = 32
_SHELVES = 16
_HOUR = 3600.0
_SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55\n"
"""What backup programs know a cache by: Cache Directory Tagging Specification, B. Ford, 2004."""


@dataclass(frozen=True)
class Usage:
    """How many entries a store has, and the bytes that they take of the disk."""

    entries: int
    size: int


class Store:
    """A folder of entries, made when the first is put into it.

    Args:
        folder: where they lie, in sixteen folders by the first digit of their keys.
        limit: bytes of disk that all may take, give or take a few entries; a sixteenth of it is
            each folder's share, and what is larger than that is not kept.
    """

    def __init__(self, folder: Path, limit: int = LIMIT) -> None:
        self.folder = folder
        self._name = str(folder)  # joining text is several times as fast as joining paths
        self._share = limit // _SHELVES

    def get(self, key: str) -> bytes | None:
        """The content that was put there, or None. `key` is hexadecimal."""
        path = self._path(key)
        try:
            with open(path, "rb") as file:
                known = os.fstat(file.fileno())
                data = file.read() if known.st_size <= self._share else b""
        except OSError:
            return None
        content = data[_SEAL:]
        if data[:_SEAL] != _seal(key, content):
            return None
        if time.time() - known.st_mtime > _HOUR:
            with suppress(OSError):
                os.utime(path)
        return content

    def put(self, key: str, content: bytes) -> None:
        """Keep content for a key, and let go of what was not used for longest."""
        data = _seal(key, content) + content
        if _on_disk(len(data)) > self._share:
            return
        path = self._path(key)
        try:
            try:
                write_bytes(path, data)
            except FileNotFoundError:
                self._make(os.path.dirname(path))
                write_bytes(path, data)
            if key[1:3] == "00":  # one time in 256, since all of the folder is looked at
                self._trim(os.path.dirname(path))
        except OSError:
            return

    def usage(self) -> Usage:
        """What is kept now, all files looked at."""
        count = size = 0
        with suppress(OSError):
            for shelf in list(os.scandir(self.folder)):
                for _, taken, _ in _files(shelf.path) if shelf.is_dir() else ():
                    count, size = count + 1, size + taken
        return Usage(count, size)

    def _path(self, key: str) -> str:
        return os.path.join(self._name, key[:1], key[1:])

    def _make(self, shelf: str) -> None:
        if not self.folder.is_dir():
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / "CACHEDIR.TAG").write_text(_SIGNATURE, encoding="ascii")
        os.makedirs(shelf, exist_ok=True)

    def _trim(self, shelf: str) -> None:
        """Bring a folder below its share, so that there is room till the next time; drafts that
        nobody will finish go too."""
        kept = sorted(_files(shelf))
        total = sum(size for _, size, _ in kept)
        room = self._share * 7 // 8
        for used, size, path in kept:
            abandoned = os.path.basename(path).startswith(".") and time.time() - used > _HOUR
            if total > room or abandoned:
                with suppress(FileNotFoundError):
                    os.unlink(path)
                total -= size


def _files(shelf: str) -> Iterator[tuple[float, int, str]]:
    """A folder's files: when each was last used, the bytes of disk it takes, its path."""
    with os.scandir(shelf) as entries:
        for entry in entries:
            with suppress(FileNotFoundError):  # another process was faster
                known = entry.stat(follow_symlinks=False)
                yield known.st_mtime, _on_disk(known.st_size), entry.path


def _on_disk(size: int) -> int:
    return -(-size // _BLOCK) * _BLOCK


def _seal(key: str, content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_SEAL, key=bytes.fromhex(key)).digest()
