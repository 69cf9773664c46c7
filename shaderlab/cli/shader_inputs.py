"""Shader files without a case, for commands that interpret them: which file, and which inputs."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from shaderlab.compiler.shader_files import EXTENSIONS
from shaderlab.errors import UsageError

if TYPE_CHECKING:
    from shaderlab.workers.compare_shaders import ShaderOfFile


def _range(word: str) -> tuple[str, str]:
    name, equals, values = word.partition("=")
    if not equals:
        raise UsageError(f"--range {word}", remedy="write --range NAME=A:B or NAME=unit")
    return name.strip(), values.strip()


RANGES = click.option(
    "--range", "ranges", multiple=True, metavar="NAME=A:B",
    callback=lambda context, option, words: dict(map(_range, words)),
    help="An input lies between A and B; NAME=unit: it has length 1. May be repeated.",
)  # fmt: skip


def shader_of_file(
    path: Path, includes: Sequence[Path], then: Callable[[Path], Path] | None = None
) -> ShaderOfFile:
    """A shader file with the folders that it includes from; `then` says where it and those are.

    Raises:
        UsageError: there is no such file, or it is a folder.
    """
    if path.is_dir():
        raise UsageError("this is a folder: name a shader file", file=path)
    (found,) = shaders_of_paths([path], includes, then)
    return found


def is_of_functions(shader: ShaderOfFile, stage: str | None) -> bool:
    """Whether a file has functions for others to include, and neither a stage nor a `main`."""
    path = Path(shader.file.path)
    if stage is not None or path.suffix in EXTENSIONS or not path.is_file():
        return False
    text = path.read_text(encoding="utf-8", errors="replace")
    return not re.search(r"#pragma\s+shader_stage|\bvoid\s+main\s*\(", text)


def shaders_of_paths(
    paths: Sequence[Path], includes: Sequence[Path], then: Callable[[Path], Path] | None = None
) -> list[ShaderOfFile]:
    """The shader files at paths, and in folders among them; as `shader_of_file`."""
    from shaderlab.compiler.shader_files import find_shaders
    from shaderlab.engine.discovery import data_folder
    from shaderlab.settings import settings_of
    from shaderlab.workers.compare_shaders import ShaderOfFile

    shipped = data_folder("shaders").resolve()
    found = []
    for path in paths:
        folder = path if path.is_dir() else path.parent
        own = settings_of(folder).shader_folders(folder)
        folders = tuple(str(then(f) if then else f) for f in [*includes, *own, shipped])
        files = find_shaders([then(path) if then else path], [shipped])
        found += [ShaderOfFile(file, folders) for file in files]
    return found
