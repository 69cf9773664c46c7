"""A GLSL file's functions as Python callables."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

from shaderlab.compiler.sources import LineMap, Shaders, Source
from shaderlab.compiler.text import EXTENSIONS, version_of
from shaderlab.errors import ShaderError, nearest
from shaderlab.functions.calling import caller
from shaderlab.functions.declarations import declarations
from shaderlab.functions.function import Function
from shaderlab.functions.signatures import Signature, signatures
from shaderlab.functions.substitutes import loads
from shaderlab.settings import settings_of

# What a file without `#version` is read as. What it may need of later versions, the driver takes.
_READ_AS = 330


def load(
    shader: str | os.PathLike[str],
    *,
    defines: Mapping[str, str] | None = None,
    **given: Any,
) -> Library:
    """The functions of a GLSL file, of any dialect, or of a text.

    Args:
        shader: the file's path, found where the calling file's shaders are
            (`shaderlab.settings.Settings.shader_folders`), or in the working folder; or GLSL
            itself, which has a brace.
        defines: macros to put after its `#version`.
        given: values of uniforms and other globals that calls don't give themselves.

    Raises:
        ShaderError: there is no such file, or it or one of its includes can't be read.
    """
    if isinstance(shader, str) and "{" in shader:
        source = Shaders([], defines=defines).from_text(shader, "fragment", "text")
        return Library(source, "", given)
    calling: str | None = sys._getframe(1).f_globals.get("__file__")
    path = _find(Path(shader), Path(calling).parent if calling else None)
    return Library(_source(path, defines), str(path.parent), given)


class Library:
    """The functions of one GLSL file, as attributes; `dir()` lists them.

    Args:
        source: the file with its includes.
        folder: what paths of textures are relative to.
        given: values of its globals.
    """

    def __init__(self, source: Source, folder: str, given: Mapping[str, Any]) -> None:
        self._written = source
        self._source = source if (known := loads()) is None else known.take(source)
        self._folder = folder
        self._given = dict(given)

    def __getattr__(self, name: str) -> Function:
        if name.startswith("__"):
            raise AttributeError(name)
        return self[name]

    def __getitem__(self, name: str) -> Function:
        """The function of this name, also where Python has another use for it.

        Raises:
            AttributeError: the file has no such function.
        """
        found = self._functions.get(name)
        if found is None:
            message = f"{self._source.path} has no function {name!r}"
            raise AttributeError(f"{message}\n  → {nearest(name, self._functions)}")
        if (known := loads()) is not None:
            known.use(self._written, name)
        return Function(self._read, found, self._folder, self._given)

    def __iter__(self) -> Iterator[Function]:
        return (self[name] for name in self._functions)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._functions]

    def __repr__(self) -> str:
        return f"<{self._source.path}: {', '.join(self._functions)}>"

    @cached_property
    def _read(self) -> Source:
        return readable(self._source)

    @cached_property
    def _functions(self) -> dict[str, list[Signature]]:
        text = caller().preprocess(self._read)
        try:
            return signatures(declarations(text))
        except ShaderError as error:
            file, line = self._read.place(error.line or 1)
            raise ShaderError(error.message, file=file, line=line) from None


def readable(source: Source) -> Source:
    """A source with a `#version`, its own or a late one, as its functions are read."""
    if version_of(source.code) is not None:
        return source
    lines = LineMap(((source.path, 1, 1), *source.lines.spans))
    text = f"#version {_READ_AS} core\n{source.text}"
    return replace(source, text=text, lines=lines, stripped=None)


def _find(path: Path, beside: Path | None) -> Path:
    tried = [Path.cwd()]
    if beside is not None:
        tried[:0] = settings_of(beside).shader_folders(beside)
    for folder in tried:
        if (folder / path).is_file():
            return Path(os.path.abspath(folder / path))
    where = ", ".join(map(str, dict.fromkeys(tried)))
    raise ShaderError(f"no such shader file in {where}", file=path)


def _source(path: Path, defines: Mapping[str, str] | None) -> Source:
    """The file with its includes, which are searched for as a case's are."""
    folders = settings_of(path.parent).shader_folders(path.parent)
    outermost = min((f for f in folders if path.is_relative_to(f)), key=lambda f: len(f.parts))
    shaders = Shaders([outermost, *folders], defines=defines)
    stage = EXTENSIONS.get(path.suffix, "fragment")
    return shaders.load(path.relative_to(outermost).as_posix(), stage)
