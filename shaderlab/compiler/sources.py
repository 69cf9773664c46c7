"""Loads shaders by name and makes the text that a compiler gets.

A name is a path inside one of the shader roots, with forward slashes, such as
"lamps/attenuation.frag". Nothing outside the roots is ever read.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from shaderlab.compiler.include import LineMap, expand
from shaderlab.compiler.shader_files import File, Roots
from shaderlab.compiler.text import STAGES, normalise, stage_of, version_of, without_comments
from shaderlab.errors import ShaderError, nearest
from shaderlab.model.records import Diagnostic, Severity


@dataclass(frozen=True)
class Source:
    """One shader after `#include`.

    Attributes:
        name: as it was loaded, e.g. "lamps/attenuation.frag".
        path: the file on disk, or the name if the text is not a file's.
        stage: one of `STAGES`.
        text: what the compiler gets, with line ends "\\n".
        lines: for each line of `text`, the author's file and line.
        parts: each contributing file's path and own text, the main file first.
        stripped: `code`, if it is known already.
    """

    name: str
    path: str
    stage: str
    text: str
    lines: LineMap
    parts: tuple[tuple[str, str], ...]
    stripped: str | None = field(default=None, repr=False, compare=False)

    @functools.cached_property
    def code(self) -> str:
        """The text with its comments blanked out; all other characters stay in place."""
        return without_comments(self.text) if self.stripped is None else self.stripped

    @functools.cached_property
    def version(self) -> tuple[int, str]:
        """The `#version` as (330, "core"); (110, "") if there is none."""
        return version_of(self.code) or (110, "")

    def place(self, line: int) -> tuple[str, int]:
        """The author's file and line for a line of `text` (both counted from 1)."""
        if not self.lines:
            return self.path, line
        return self.lines[min(max(line, 1), len(self.lines)) - 1]

    def diagnostic(
        self, message: str, at: int | None = None, *, severity: Severity = "error", token: str = ""
    ) -> Diagnostic:
        """A message about a line of `text` (counted from 1), or about the file as a whole."""
        file, line = (self.path, None) if at is None else self.place(at)
        return Diagnostic(file=file, line=line, severity=severity, message=message, token=token)


class Shaders(Roots):
    """Loads shaders by name from a list of root folders.

    Args:
        roots: folders, searched in order.
        overrides: by a shader's name, the text to use, or the file to read, in its place.
            Applies to included files as well.
        defines: macros to put after each shader's `#version` line; a value may be "".
        renames: names in the files of `overrides`, and what they are called instead.
    """

    def __init__(
        self,
        roots: Sequence[Path],
        *,
        overrides: Mapping[str, str | Path] | None = None,
        defines: Mapping[str, str] | None = None,
        renames: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(roots, overrides or {}, renames)
        self._defines = dict(defines or {})
        for word in self._defines:
            if not re.fullmatch(r"[A-Za-z_]\w*(\([\w, ]*\))?", word):
                raise ShaderError(f"can't define {word!r}: it is not a GLSL name")

    def load(self, name: str, stage: str | None = None) -> Source:
        """The named shader with its includes expanded.

        Args:
            name: the shader's path inside the roots.
            stage: one of `STAGES`; by default that of the extension or, in a .glsl file, of
                `#pragma shader_stage(fragment)`.

        Raises:
            ShaderError: there is no such file in the roots, it or one of its includes can't be
                used, or the stage is unknown.
        """
        file = self.shader(name)
        return self._source(file, name, stage or stage_of(name, file.text, file.path))

    def from_text(self, text: str, stage: str, name: str) -> Source:
        """A shader that is not a file, such as a generated stage; it may include files.

        Raises:
            ShaderError: the stage is unknown, or the text or one of its includes can't be used.
        """
        return self._source(File(name, name, normalise(text, name)), name, stage)

    def _source(self, file: File, name: str, stage: str) -> Source:
        if stage not in STAGES:
            raise ShaderError(
                f"no such stage: {stage!r}", file=file.path, remedy=nearest(stage, STAGES)
            )
        out = expand(file, self, self._defines)
        return Source(
            name,
            file.path,
            stage,
            "\n".join(out.rows),
            LineMap.of(out.spans),
            tuple(out.parts.items()),
            "\n".join(out.codes),
        )
