"""Finding shaders by name and turning each into the text that a compiler gets.

A name is a path inside one of the shader roots, with forward slashes, such as
"ch05_lighting/attenuation.frag". Nothing outside the roots is ever read.
"""

from __future__ import annotations

import functools
import posixpath
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from shaderlab.errors import ShaderError, nearest
from shaderlab.glsl.include import Expanded, expand
from shaderlab.glsl.linemap import LineMap
from shaderlab.glsl.reading import normalise, version_of, without_comments
from shaderlab.glsl.roots import File, Roots

STAGES = ("vertex", "tess_control", "tess_evaluation", "geometry", "fragment", "compute")

EXTENSIONS: Mapping[str, str] = {
    ".vert": "vertex",
    ".vs": "vertex",
    ".tesc": "tess_control",
    ".tcs": "tess_control",
    ".tese": "tess_evaluation",
    ".tes": "tess_evaluation",
    ".geom": "geometry",
    ".gs": "geometry",
    ".frag": "fragment",
    ".fs": "fragment",
    ".comp": "compute",
    ".cs": "compute",
}
_PRAGMA = re.compile(r"^[ \t]*#[ \t]*pragma[ \t]+shader_stage[ \t]*\([ \t]*(\w*)[ \t]*\)", re.M)
_PRAGMA_NAMES = {"tesscontrol": "tess_control", "tesseval": "tess_evaluation"}


@dataclass(frozen=True)
class Source:
    """One shader after `#include`.

    Attributes:
        name: as asked for, e.g. "ch05_lighting/attenuation.frag".
        path: the file on disk, or the name where the text came from elsewhere.
        stage: one of `STAGES`.
        text: what the compiler gets, line ends "\\n".
        lines: for each line of `text`, the author's file and line, counted from 1.
        parts: each contributing file's path and own text, the main file first.
        stripped: `code`, where it is known already.
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
        """The text with its comments blanked out, all other characters where they were."""
        return without_comments(self.text) if self.stripped is None else self.stripped

    @functools.cached_property
    def version(self) -> tuple[int, str]:
        """The `#version` as (330, "core"); (110, "") where there is none."""
        return version_of(self.code) or (110, "")

    def place(self, line: int) -> tuple[str, int]:
        """The author's file and line of a line of `text` (both counted from 1)."""
        if not self.lines:
            return self.path, line
        return self.lines[min(max(line, 1), len(self.lines)) - 1]


class Shaders:
    """Loads shaders by name from a list of root folders.

    Args:
        roots: folders, searched in order.
        overrides: for a shader's name, the text to use instead of the file's, or another file
            to read instead. Applies to included files as well.
        defines: macros put after every shader's `#version` line; the value may be "".
    """

    def __init__(
        self,
        roots: Sequence[Path],
        *,
        overrides: Mapping[str, str | Path] | None = None,
        defines: Mapping[str, str] | None = None,
    ) -> None:
        self._roots = Roots(tuple(Path(root) for root in roots), dict(overrides or {}))
        self._defines = dict(defines or {})
        for word in self._defines:
            if not re.fullmatch(r"[A-Za-z_]\w*(\([\w, ]*\))?", word):
                raise ShaderError(f"can't define {word!r}: it is not a GLSL name")

    @property
    def folders(self) -> tuple[Path, ...]:
        """The root folders, in the order they are searched."""
        return self._roots.folders

    def load(self, name: str, stage: str | None = None) -> Source:
        """The named shader with its includes expanded.

        Args:
            name: the shader's path inside the roots.
            stage: one of `STAGES`; by default told from the extension or, in a .glsl file,
                from `#pragma shader_stage(fragment)`.

        Raises:
            ShaderError: the name leads nowhere or out of the roots, the file or one of its
                includes can't be used, or the stage is unknown.
        """
        file = self._roots.shader(name)
        return self._source(file, name, stage or stage_of(name, file.text, file.path))

    def from_text(self, text: str, stage: str, name: str) -> Source:
        """A shader that is not a file, such as a generated stage; it may include files.

        Raises:
            ShaderError: the stage is unknown, or the text or one of its includes can't be used.
        """
        return self._source(File(name, name, normalise(text, name)), name, stage)

    def names(self) -> tuple[str, ...]:
        """All shader files below the roots, as names that `load` and `#include` take."""
        return self._roots.names()

    def _source(self, file: File, name: str, stage: str) -> Source:
        if stage not in STAGES:
            raise ShaderError(
                f"no such stage: {stage!r}", file=file.path, remedy=nearest(stage, STAGES)
            )
        expanded = _define(expand(file, self._roots), self._defines)
        return Source(
            name,
            file.path,
            stage,
            expanded.text,
            expanded.lines,
            expanded.parts,
            expanded.code,
        )


def stage_of(name: str, text: str, path: str | None = None) -> str:
    """The stage that a file's extension, or `#pragma shader_stage(…)` in its text, tells.

    Raises:
        ShaderError: neither tells, or the pragma names no stage.
    """
    stem, suffix = posixpath.splitext(name)
    if suffix == ".glsl":
        suffix = posixpath.splitext(stem)[1]
    if suffix in EXTENSIONS:
        return EXTENSIONS[suffix]
    pragma = _PRAGMA.search(without_comments(text))
    if pragma is None:
        raise ShaderError(
            "can't tell the shader's stage from its name",
            file=path or name,
            remedy=f"name it with {' '.join(EXTENSIONS)}, or add #pragma shader_stage(fragment)",
        )
    word = pragma.group(1)
    stage = _PRAGMA_NAMES.get(word, word)
    if stage not in STAGES:
        line = text.count("\n", 0, pragma.start()) + 1
        raise ShaderError(
            f"#pragma shader_stage({word}) names no stage",
            file=path or name,
            line=line,
            remedy=nearest(word, STAGES),
        )
    return stage


def _define(expanded: Expanded, defines: Mapping[str, str]) -> Expanded:
    """The text with `#define` lines put after its `#version` line, or first without one."""
    if not defines:
        return expanded
    rows = expanded.text.split("\n")
    codes = expanded.code.split("\n")
    is_version = re.compile(r"[ \t]*#[ \t]*version\b").match
    at = next((i + 1 for i, row in enumerate(codes) if is_version(row)), 0)
    place = expanded.lines[max(at - 1, 0)]
    new = [f"#define {word} {value}".rstrip() for word, value in defines.items()]
    return Expanded(
        "\n".join([*rows[:at], *new, *rows[at:]]),
        "\n".join([*codes[:at], *new, *codes[at:]]),
        expanded.lines.with_inserted(at, len(new), place),
        expanded.parts,
    )
