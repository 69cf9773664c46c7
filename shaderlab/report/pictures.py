"""Files of a run's folder for its pages: linked, or as data where a page is to be one file.

Nothing is read before a page is written, and nothing is kept: a page may hold more pictures
than fit into memory.
"""

from __future__ import annotations

import base64
import os
import struct
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from urllib.parse import quote

from markupsafe import Markup

from shaderlab.files import read_regular
from shaderlab.model import pictures

# Below this a picture is a table of pixels, to be enlarged with hard edges.
_TABLE = 200
# The size of copies: the overview's, those of several variants side by side, a single file's.
SMALL = 320


@dataclass(frozen=True)
class Picture:
    """A PNG file with the size to show it at, or the reason why there is none.

    The page may show its small copy instead (`shaderlab.model.pictures.preview`).

    `side` is the most pixels that the page may have of it in each direction; 0 for all. `folder`
    is the run's, in which it is, with a slash at its end.
    """

    path: Path = Path()
    width: int = 0
    height: int = 0
    pixelated: bool = False
    missing: str = ""
    side: int = 0
    folder: str = ""

    @cached_property
    def link(self) -> str:
        """Where the page finds it in the run's folder, as a relative URL."""
        return self._below(pictures.preview(self.path, self.side))

    @property
    def original(self) -> str:
        """Where the PNG file itself is, likewise."""
        return self._below(self.path)

    @property
    def uri(self) -> Markup:
        """The picture as a data URI; an empty one if the file has gone or is damaged."""
        return self._data(self.side)

    @property
    def small_uri(self) -> Markup:
        """As `uri`, of the small copy where there is one."""
        return self._data(self.side or SMALL)

    def _below(self, path: Path) -> str:
        return quote(str(path).removeprefix(self.folder))

    def _data(self, side: int) -> Markup:
        try:
            data = read_regular(pictures.preview(self.path, side))
        except OSError:
            data = b""
        return "data:image/png;base64," + in_base64(data)


def read_numbers(path: Path) -> Markup:
    """Return the bytes of a file of packed values in base64; empty if the file has gone."""
    try:
        return in_base64(read_regular(path))
    except OSError:
        return Markup()


def in_base64(data: bytes) -> Markup:
    """Return bytes in base64, marked as safe: there is nothing to escape."""
    return Markup(base64.b64encode(data).decode("ascii"))


class Pictures:
    def __init__(self, folder: Path) -> None:
        self._root = os.path.join(os.path.realpath(folder), "")
        # A page's files lie in few folders.
        self._resolved = lru_cache(maxsize=64)(os.path.realpath)

    def find(self, name: str, side: int = 0) -> Picture:
        """Return the picture file `name` (relative to the folder), small ones enlarged.

        With a `side` it has at most so many pixels in each direction.
        """
        try:
            path = self._inside(name)
            head = read_regular(path, 24)
        except (OSError, ValueError) as error:
            return Picture(missing=f"{name}: {_reason(error)}")
        if not head.startswith(pictures.SIGNATURE) or len(head) < 24:
            return Picture(missing=f"{name}: is no PNG file")
        width, height = struct.unpack(">II", head[16:24])
        longest = max(width, height, 1)
        scale = float(max(1, -(-_TABLE // longest)) if longest < _TABLE else 1)
        side = side if longest > side else 0
        if side:
            scale = side / longest
        shown = max(1, round(width * scale)), max(1, round(height * scale))
        pixelated = scale >= 1 and width <= 600
        return Picture(path, *shown, pixelated=pixelated, side=side, folder=self._root)

    def find_numbers(self, name: str) -> Path | None:
        """Return the file of values `name`, or None if there is none."""
        try:
            path = self._inside(name)
        except ValueError:
            return None
        return path if name and path.is_file() else None

    def _inside(self, name: str) -> Path:
        # Records may come from an untrusted file: they can show files of their own folder only.
        folder, file = os.path.split(os.path.join(self._root, name))
        path = os.path.join(self._resolved(folder), file)
        if file in ("", ".", "..") or os.path.islink(path):
            path = os.path.realpath(path)
        if not os.path.join(path, "").startswith(self._root):
            raise ValueError("lies outside the run's folder")
        return Path(path)


def _reason(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return "the file is missing"
    if isinstance(error, OSError):
        return error.strerror or "can't be read"
    return str(error)
