"""Files of a run's folder for its pages: linked, or as data where a page is to be one file.

Nothing is read before a page is written, and nothing is kept: a page may hold more pictures
than fit into memory.
"""

from __future__ import annotations

import base64
import os
import struct
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from urllib.parse import quote

from markupsafe import Markup

from shaderlab.files import read_regular
from shaderlab.model import pictures

# Below this a picture is a table of pixels, to be enlarged with hard edges.
_TABLE = 200


@dataclass(frozen=True)
class Picture:
    """A PNG file with the size to show it at, or the reason why there is none.

    `folder` is the run's, in which it is, with a slash at its end.
    """

    path: Path = Path()
    width: int = 0
    height: int = 0
    pixelated: bool = False
    missing: str = ""
    folder: str = ""

    @property
    def link(self) -> str:
        """Where the page finds it in the run's folder, as a relative URL."""
        return quote(str(self.path).removeprefix(self.folder))

    @property
    def uri(self) -> Markup:
        """The picture as a data URI; an empty one if the file has gone or is damaged."""
        return "data:image/png;base64," + in_base64(self.path)


def in_base64(path: Path) -> Markup:
    """Return the bytes of a file in base64, marked as safe; empty if the file has gone."""
    try:
        return Markup(base64.b64encode(read_regular(path)).decode("ascii"))
    except OSError:
        return Markup()


class Pictures:
    def __init__(self, folder: Path) -> None:
        self._root = os.path.join(os.path.realpath(folder), "")
        # A page's files lie in few folders.
        self._resolved = lru_cache(maxsize=64)(os.path.realpath)

    def find(self, name: str) -> Picture:
        """Return the picture file `name` (relative to the folder), small ones enlarged."""
        try:
            path = self._inside(name)
            head = read_regular(path, 24)
        except (OSError, ValueError) as error:
            return Picture(missing=f"{name}: {_reason(error)}")
        if not head.startswith(pictures.SIGNATURE) or len(head) < 24:
            return Picture(missing=f"{name}: is no PNG file")
        width, height = struct.unpack(">II", head[16:24])
        longest = max(width, height, 1)
        scale = max(1, -(-_TABLE // longest))
        size = width * scale, height * scale
        return Picture(path, *size, pixelated=width <= 600, folder=self._root)

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
