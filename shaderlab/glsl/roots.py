"""The folders that shaders live in: from a name to a file inside them, and never outside."""

from __future__ import annotations

import functools
import os
import posixpath
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from shaderlab.errors import ShaderError, nearest
from shaderlab.glsl.reading import normalise, read_shader

_SHADER_SUFFIXES = re.compile(r"\.(vert|vs|frag|fs|geom|gs|tesc|tcs|tese|tes|comp|cs|glsl|inc|h)")


@dataclass(frozen=True)
class File:
    """A shader file: its name inside the roots, where it is on disk, and its text."""

    name: str
    path: str
    text: str


class OutsideError(ValueError):
    """A name that leads out of the shader roots; the message says how."""


@dataclass(frozen=True)
class Roots:
    """Shader folders in search order, with replacement texts or files for some names."""

    folders: tuple[Path, ...]
    overrides: Mapping[str, str | Path]
    _real_parents: dict[str, str] = field(default_factory=dict, repr=False, compare=False)

    def shader(self, name: str) -> File:
        """The shader of that name.

        Raises:
            ShaderError: it is in no root, leads out of them, or can't be read.
        """
        try:
            file = self.find(inside(name))
        except OutsideError as error:
            raise ShaderError(
                f"shader {name!r}: {error}",
                remedy="name it by its path inside a shader folder",
            ) from None
        if file is None:
            where = ", ".join(str(folder) for folder in self.folders) or "no folder"
            raise ShaderError(
                f"no shader {name!r} in {where}", file=name, remedy=nearest(name, self.names())
            )
        return file

    def find(self, name: str) -> File | None:
        """The file of a normalised name, or None where no root has it.

        Raises:
            OutsideError: a symbolic link leads out of the roots.
            ShaderError: the file can't be read.
        """
        if name in self.overrides:
            new = self.overrides[name]
            if isinstance(new, Path):
                return File(name, str(new), read_shader(new))
            return File(name, name, normalise(new, name))
        for folder in self._named_folders:
            path = os.path.join(folder, name)
            if os.path.lexists(path):
                self._refuse_escape(path)
                return File(name, path, read_shader(path))
        return None

    def names(self) -> tuple[str, ...]:
        """All shader files below the roots, sorted, and all overridden names."""
        found = {name for folder in self.folders for name in _below(folder)}
        return tuple(sorted(found | set(self.overrides)))

    def _real(self, path: str) -> str:
        """A file's place without links in its folder's name, which is resolved only once."""
        parent, name = os.path.split(path)
        if parent not in self._real_parents:
            self._real_parents[parent] = os.path.realpath(parent)
        return os.path.join(self._real_parents[parent], name)

    @functools.cached_property
    def _named_folders(self) -> tuple[str, ...]:
        """The folders as text: joining that is several times as fast as joining paths."""
        return tuple("" if folder == Path() else str(folder) for folder in self.folders)

    @functools.cached_property
    def _real_folders(self) -> tuple[str, ...]:
        """The folders without links in them, each ending in a separator."""
        return tuple(os.path.join(os.path.realpath(folder), "") for folder in self.folders)

    def _refuse_escape(self, path: str) -> None:
        real = os.path.realpath(path) if os.path.islink(path) else self._real(path)
        if not real.startswith(self._real_folders):
            raise OutsideError(f"a symbolic link leads out of the shader folders, to {real}")


def inside(name: str, folder: str = "") -> str:
    """`name`, seen from `folder` (itself a name inside the roots), normalised.

    Raises:
        OutsideError: it is absolute, has backslashes or a drive, or climbs out of the roots.
    """
    if "\\" in name:
        raise OutsideError("has a backslash; write / between folders")
    if name.startswith("/") or re.match(r"[A-Za-z]:", name):
        raise OutsideError("is an absolute path; only files inside the shader folders are read")
    joined = posixpath.normpath(posixpath.join(folder, name)) if name else "."
    if joined == "." or joined == ".." or joined.startswith("../"):
        raise OutsideError(
            "leads out of the shader folders" if name else "is empty; name a shader file"
        )
    return joined


def _below(folder: Path) -> Iterator[str]:
    if folder.is_dir():
        for path in folder.rglob("*"):
            if _SHADER_SUFFIXES.fullmatch(path.suffix) and path.is_file():
                yield path.relative_to(folder).as_posix()
