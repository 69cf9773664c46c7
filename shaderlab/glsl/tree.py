"""Which shaders there are under the paths that a person names, and each one's root and name."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from shaderlab.errors import ShaderError, UsageError
from shaderlab.glsl.reading import read_shader
from shaderlab.glsl.sources import EXTENSIONS, stage_of


@dataclass(frozen=True)
class ShaderFile:
    """A shader file: its path as the person would write it, its root, and its name inside it."""

    path: str
    root: str
    name: str


def find_shaders(
    paths: Sequence[str | Path], roots: Sequence[Path] = (), *, stage: str | None = None
) -> list[ShaderFile]:
    """The shaders at the paths, each once, sorted by path.

    Args:
        paths: files, taken as they are, and folders, searched for all files whose extension or
            `#pragma shader_stage` tells a stage; others in them are there to be included.
        roots: shader folders. A file in one of them includes from there; any other from the
            folder that was named, or its own.
        stage: where it is given, every file named is a shader of that stage.

    Raises:
        UsageError: nothing is there of that name, or a folder holds no shader.
    """
    real_roots = [(os.path.join(os.path.realpath(root), ""), str(root)) for root in roots]
    real_folders: dict[str, str] = {}  # each folder is resolved once
    found: dict[str, ShaderFile] = {}
    for path in map(Path, paths):
        if not path.exists():
            raise UsageError("there is no such file or folder", file=path)
        if not path.is_dir():
            files, folder = [str(path)], str(path.parent)
        else:
            folder = str(path)
            files = [file for file in _below(folder) if stage or _tells_stage(file)]
            if not files:
                raise UsageError(
                    "there is no shader in this folder",
                    file=path,
                    remedy=f"shaders are named {' '.join(EXTENSIONS)}, or say #pragma shader_stage",
                )
        for file in files:
            key = os.path.abspath(file) if len(paths) > 1 else file
            found.setdefault(key, _placed(file, folder, real_roots, real_folders))
    return sorted(found.values(), key=lambda shader: shader.path)


def _placed(
    file: str, folder: str, roots: Sequence[tuple[str, str]], real_folders: dict[str, str]
) -> ShaderFile:
    if roots:
        parent, name = os.path.split(file)
        if parent not in real_folders:
            real_folders[parent] = os.path.realpath(parent)
        real = os.path.join(real_folders[parent], name)
        for real_root, root in roots:
            if real.startswith(real_root):
                return ShaderFile(file, root, _slashes(real[len(real_root) :]))
    start = os.path.join(folder, "")
    name = file[len(start) :] if file.startswith(start) else os.path.relpath(file, folder)
    return ShaderFile(file, folder, _slashes(name))


def _below(folder: str) -> Iterator[str]:
    for where, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(files):
            yield os.path.join(where, name)


def _tells_stage(file: str) -> bool:
    stem, extension = os.path.splitext(file)
    if extension in EXTENSIONS:
        return True
    if extension != ".glsl":
        return False
    if os.path.splitext(stem)[1] in EXTENSIONS:
        return True
    try:
        stage_of(file, read_shader(Path(file)))
    except ShaderError as error:
        return "names no stage" in error.message  # a misspelt pragma is an error, not an include
    return True


def _slashes(name: str) -> str:
    return name.replace(os.sep, "/")
