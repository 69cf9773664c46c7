"""Picture files of a run's folder as data URIs, so that the page is one file."""

from __future__ import annotations

import base64
import struct
from dataclasses import dataclass
from pathlib import Path

from shaderlab import pictures
from shaderlab.errors import AssetError

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
# Below this a picture is a table of pixels, to be enlarged with hard edges.
_SMALL = 200


@dataclass(frozen=True)
class Picture:
    """A PNG as a data URI with the size to show it at, or the reason why there is none."""

    uri: str = ""
    width: int = 0
    height: int = 0
    pixelated: bool = False
    missing: str = ""


class Pictures:
    """Reads the pictures of one folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder.resolve()
        self._thumbnails: dict[tuple[str, int], Picture] = {}

    def full(self, name: str) -> Picture:
        """The picture file `name` (relative to the folder), small ones enlarged."""
        try:
            path = self._inside(name)
            data = path.read_bytes()
        except (OSError, ValueError) as error:
            return Picture(missing=f"{name}: {_reason(error)}")
        return _picture(data, name)

    def small(self, name: str, side: int) -> Picture:
        """The same as a thumbnail of at most `side` pixels; each is made once."""
        key = (name, side)
        if key not in self._thumbnails:
            self._thumbnails[key] = self._small(name, side)
        return self._thumbnails[key]

    def _small(self, name: str, side: int) -> Picture:
        try:
            data = pictures.thumbnail(self._inside(name), side)
        except (OSError, ValueError, AssetError) as error:
            return Picture(missing=f"{name}: {_reason(error)}")
        return _picture(data, name)

    def _inside(self, name: str) -> Path:
        # A record may come from a file that somebody else wrote; it shows its folder only.
        path = (self._folder / name).resolve()
        if not path.is_relative_to(self._folder):
            raise ValueError("lies outside the run's folder")
        return path


def _picture(data: bytes, name: str) -> Picture:
    if data[:8] != _SIGNATURE or len(data) < 24:
        return Picture(missing=f"{name}: is no PNG file")
    width, height = struct.unpack(">II", data[16:24])
    uri = "data:image/png;base64," + base64.b64encode(data).decode("ascii")
    small = max(width, height) < _SMALL
    factor = max(1, -(-_SMALL // max(width, height, 1))) if small else 1
    return Picture(uri, width * factor, height * factor, pixelated=width <= 600)


def _reason(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return "the file is missing"
    if isinstance(error, OSError):
        return error.strerror or "can't be read"
    if isinstance(error, AssetError):
        return error.message
    return str(error)
