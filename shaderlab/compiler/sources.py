"""`#include`: one text from a shader and the files it includes, with a map of its lines.

Expansion is textual and happens before the compiler's own preprocessor, so an include inside
an inactive `#if` is expanded as well (its text is then skipped like any other). A file with
`#pragma once` gets a guard macro, as C programmers expect.
"""

from __future__ import annotations

import functools
import itertools
import os
import posixpath
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.errors import Diagnostic, Severity, ShaderError, suggest
from shaderlab.files import display_path

from .shader_files import (
    OUTSIDE_REMEDY,
    SCRIPT,
    STAGES,
    File,
    OutsideError,
    Roots,
    find_sections,
    frame_text,
    normalise,
    normalise_name,
    rename_words,
    section_of,
    stage_of,
    strip_comments,
    version_of,
)

if TYPE_CHECKING:
    from .syntax import GlslDeclaration

MAX_DEPTH = 64
MAX_INCLUDES = 10_000

_DIRECTIVE = re.compile(r"[ \t]*#[ \t]*(include|pragma|line|extension)\b[ \t]*(.*)")
_ANY_DIRECTIVE = re.compile(r"#[ \t]*(?:include|pragma|line|extension|type|shader)\b|#\[")
_GODOT_DEFINES = "#VERSION_DEFINES"  # stands for the macros that the engine defines
_VERSION_LINE = re.compile(r"[ \t]*#[ \t]*version\b")
_ONCE = re.compile(r"^[ \t]*#[ \t]*pragma[ \t]+once[ \t]*$", re.MULTILINE)
_PATH = re.compile(r'"([^"]*)"[ \t]*|<([^>]*)>[ \t]*')
# glslify's modules: what is required by which name, with which names given, and what is exported.
_REQUIRED = re.compile(r"(.*glslify:\s*)(\w+)(\s*=\s*require\(\s*['\"]?([^'\",)\s]+)(.*))")
_GIVEN = re.compile(r"(\w+)\s*=\s*(\w+)")
_EXPORTED = re.compile(r"glslify:\s*export\(\s*(\w+)")
_DEFINED = re.compile(
    r"^(?!\s*(?:return|else)\b)[ \t]*\w[\w \t]*[ \t](\w+)[ \t]*\(|\bconst\s+\w+\s+(\w+)", re.M
)
_LINE = re.compile(r'(\d+)(?:[ \t]+(?:\d+|"([^"]*)"))?[ \t]*')
_ONE_COMMENT = re.compile(r"//[^\n]*|/\*.*?(?:\*/|\Z)", re.DOTALL)
_CONTINUED = re.compile(r"\\$", re.MULTILINE)
_NOT_FOR_COMPILERS = (
    "GL_GOOGLE_include_directive", "GL_ARB_shading_language_include", "glslify",
    "GL_EXT_draw_buffers", "once",
)  # fmt: skip

_Trail = tuple[tuple[File, int], ...]
"""The includes that lead to a place, the outermost first: the including file and the line."""


@dataclass(frozen=True)
class LineMap:
    """For each line of a text, by index, the author's file and line (counted from 1); `spans` are
    runs of lines: the file, the first line, and how many there are.

    >>> lines = LineMap.of([("main.frag", 1, 2), ("lib.glsl", 1, 1), ("main.frag", 4, 1)])
    >>> len(lines), lines[1], lines[2], lines[3]
    (4, ('main.frag', 2), ('lib.glsl', 1), ('main.frag', 4))
    """

    spans: tuple[tuple[str, int, int], ...] = ()

    @classmethod
    def of(cls, spans: Iterable[tuple[str, int, int]]) -> LineMap:
        """Return the map of these runs, joined where one continues another."""
        joined: list[tuple[str, int, int]] = []
        for file, line, count in spans:
            if joined and joined[-1][0] == file and sum(joined[-1][1:]) == line:
                joined[-1] = (file, joined[-1][1], joined[-1][2] + count)
            else:
                joined.append((file, line, count))
        return cls(tuple(joined))

    def __len__(self) -> int:
        return sum(count for _, _, count in self.spans)

    def __getitem__(self, index: int) -> tuple[str, int]:
        left = index
        for file, line, count in self.spans:
            if 0 <= left < count:
                return file, line + left
            left -= count
        raise IndexError(f"no line {index} in a text of {len(self)}")


def expand(file: File, roots: Roots, defines: Mapping[str, str], stage: str) -> Expansion:
    """Return the file's text with every `#include` replaced by the text of a file in the roots, and
    with macros after the first `#version` line, or first if there is none. A shader without one
    gets what its dialect implies (see `shader_files.frame_text`). Raises ShaderError: an include is
    malformed, missing, circular, outside the roots, too deep, or can't be read; the message has the
    chain of includes that led there."""
    code = strip_comments(file.text)
    version = version_of(code)
    expansion = Expansion(roots, defines, version[0] if version else 110, stage)
    expansion.append(file, code, ())
    before, after = ((), ()) if version else frame_text("\n".join(expansion.codes), stage)
    expansion.define_first(before)
    expansion.add((file.path, code.count("\n") + 1), *after)
    return expansion


class Expansion:
    """The text so far: its rows, the same without comments (`codes`), runs of each file's lines
    (as in `LineMap`), and the path and own text of each file it is made of."""

    def __init__(self, roots: Roots, defines: Mapping[str, str], version: int, stage: str) -> None:
        self._roots, self._version, self._includes = roots, version, 0
        self._own_section = ("", stage)  # rows before all sections, and of the stage's own
        self._section = ""
        self._defines = [f"#define {word} {value}".rstrip() for word, value in defines.items()]
        self.rows: list[str] = []
        self.codes: list[str] = []
        self.spans: list[tuple[str, int, int]] = []
        self.parts: dict[str, str] = {}

    def append(self, file: File, code: str, trail: _Trail) -> None:
        """Append a file; `code` is its text without comments, `trail` led to it."""
        self.parts.setdefault(file.path, file.text)
        text = file.text
        if "\\\n" in text and self._version < 420 and self._version != 300:
            # Lines can't be continued before GLSL 4.20 and ES 3.00, where glslang takes a backslash
            # in a comment for that.
            text = _ONE_COMMENT.sub(lambda match: _CONTINUED.sub(" ", match[0]), text)
            code = strip_comments(text)
        rows, codes = text.split("\n"), code.split("\n")
        if trail and rows[-1] == "":
            rows.pop()  # the file's last line end does not start another line
        shown = self._section in self._own_section
        guard = _once_macro(file, code) if trail and shown else None
        if guard:
            self.add((file.path, 1), f"#ifndef {guard}", f"#define {guard}")
        if not shown or _ANY_DIRECTIVE.search(code) or (self._defines and "version" in code):
            self._append_rows(file, rows, codes, trail)
        else:
            self.rows += rows
            self.codes += codes[: len(rows)]
            self.spans.append((file.path, 1, len(rows)))
        if guard:
            self.add((file.path, len(rows)), "#endif")

    def define_first(self, before: Sequence[str]) -> None:
        """Put these rows first, and macros if no `#version` line preceded them."""
        rows = [*before, *self._defines]
        self.rows[:0] = self.codes[:0] = rows
        self.spans[:0] = [(*self.spans[0][:2], 1)] * len(rows)

    def _append_rows(
        self, file: File, rows: Sequence[str], codes: Sequence[str], trail: _Trail
    ) -> None:
        origin, shift = file.path, 0  # file and line according to the author's own #line
        for number, (row, code) in enumerate(zip(rows, codes, strict=False), start=1):
            place = (origin, number + shift)
            directive = _DIRECTIVE.fullmatch(code) if "#" in code else None
            kind, rest = directive.groups() if directive else ("", "")
            line = _LINE.fullmatch(rest.strip()) if kind == "line" else None
            self._section = section_of(code) or self._section
            hidden = self._section not in self._own_section
            is_marker = section_of(code) or code.strip() == _GODOT_DEFINES
            if kind == "include":
                inner = self._find_included(rest.strip(), (*trail, (file, number)))
                self.append(inner, strip_comments(inner.text), (*trail, (file, number)))
            elif kind == "pragma" and (required := _REQUIRED.fullmatch(code)):
                self.add(place, "")
                _, name, _, path, given = required.groups()
                self._append_module(
                    name, path, dict(_GIVEN.findall(given)), (*trail, (file, number))
                )
            elif is_marker or (hidden and not rest.startswith("parameter")):
                self.add(place, "")
            elif rest.split(":")[0].strip() in _NOT_FOR_COMPILERS:
                self.add(place, "")  # drivers without the extension would refuse it
            elif line:
                self.add(place, "")
                # Up to GLSL 1.50 the line after `#line n` is n + 1, from 3.30 on it is n.
                shift = int(line[1]) - number - (1 if self._version >= 330 else 0)
                origin = line[2] or origin
            else:
                self.rows.append(row)
                self.codes.append(code)
                self.spans.append((*place, 1))
            if self._defines and _VERSION_LINE.match(self.codes[-1]):
                self.add(place, *self._defines)
                self._defines = []

    def add(self, place: tuple[str, int], *rows: str) -> None:
        """Append rows of our own, all from one place of the author's."""
        self.rows += rows
        self.codes += rows
        self.spans += [(*place, 1)] * len(rows)

    def _append_module(self, name: str, path: str, given: Mapping[str, str], trail: _Trail) -> None:
        """Append a module as glslify does: what it exports is called `name`, what it is `given` as
        it is here, and all else that it defines or requires as nothing else is."""
        path = f'"{path}"' if path.startswith(".") else f"<node_modules/{path}>"
        file = self._find_included(path, trail)
        self.parts.setdefault(file.path, file.text)
        code = strip_comments(file.text)
        own = {word for pair in _DEFINED.findall(code) for word in pair if word}
        own |= {word for _, word, *_ in _REQUIRED.findall(code)}
        names = {word: f"{word}_{self._includes}" for word in own} | {**given}
        names |= dict.fromkeys(_EXPORTED.findall(code), name)
        rows = [
            _REQUIRED.sub(lambda match: f"{match[1]}{names[match[2]]}{match[3]}", row)
            if "glslify" in row
            else rename_words(row, names)
            for row in file.text.split("\n")
        ]
        text = "\n".join(rows)
        self.append(File(file.name, file.path, text), strip_comments(text), trail)

    def _find_included(self, rest: str, trail: _Trail) -> File:
        """Return the file that the text after `#include` names."""
        self._includes += 1
        if self._includes > MAX_INCLUDES:
            remedy = "include files that are needed in many places once, from the main file"
            raise _error(f"includes more than {MAX_INCLUDES:,} times in all", trail, remedy)
        match = _PATH.fullmatch(rest)
        if match is None:
            remedy = 'write #include "file.glsl"'
            raise _error(f"malformed #include {rest}".rstrip(), trail, remedy)
        path = match[2] if match[1] is None else match[1]
        folder = "" if match[1] is None else posixpath.dirname(trail[-1][0].name)
        outside = refused = None
        # First with an ending: a folder may have the name itself.
        whole = posixpath.splitext(path)[1] or not path
        endings = ("",) if whole else (".glsl", SCRIPT, "/index.glsl", "")
        paths = [path + ending for ending in endings]
        # Last by the name of a shader folder itself, as those write who know it as a package.
        starts = dict.fromkeys([folder, "", ".."])
        if path.startswith("/"):  # from a shader folder, as in packs of shaders for Minecraft
            paths, starts = [*paths, *(one.lstrip("/") for one in paths)], {"": None}
        for start, tried in itertools.product(starts, paths):
            try:
                name = normalise_name(tried, start)
                file = self._roots.find(name)
            except OutsideError as error:
                outside = outside or (None if start == ".." else error)
                continue
            except ShaderError as error:
                chain = f"{error.message} (included by {_chain(trail)})"
                refused = ShaderError(chain, file=error.file, line=error.line, remedy=error.remedy)
                if not whole and tried == path and error.file and Path(error.file).is_dir():
                    continue
                raise refused from None
            found = name if file is None else file.name
            open_files = [one for one, _ in trail if one.name == found]
            if open_files and not _ONCE.search(strip_comments(open_files[0].text)):
                raise _error(f"{path!r} includes itself", trail, "break the cycle of includes")
            if file is not None and len(trail) > MAX_DEPTH:
                raise _error(f"includes nest deeper than {MAX_DEPTH}", trail, "include less deeply")
            if file is not None:
                return File(file.name, file.path, "\n") if open_files else file
        if refused is not None and match[1] is not None:  # a chunk, <common>, is no folder
            raise refused
        if outside is not None:
            remedy, here = OUTSIDE_REMEDY, os.path.dirname(os.path.abspath(trail[-1][0].path))
            both = os.path.commonpath([here, os.path.normpath(os.path.join(here, path))])
            if path.startswith("../") and both != "/":
                remedy = f"add the folder that has both files: --include {display_path(both)}"
            raise _error(f"#include {path!r} {outside}", trail, remedy)
        near = self._roots.suggest(path)
        near = near.removesuffix("?") + "; or " if near.endswith("?") else ""
        remedy = f"{near}add the folder that has it: --include DIR"
        raise _error(f"no file to #include: {path!r}", trail, remedy)


def _once_macro(file: File, code: str) -> str | None:
    """Return a macro's name for a file with `#pragma once`, without two underscores in a row."""
    if not _ONCE.search(code):
        return None
    return "SHADERLAB_ONCE_" + "".join(
        c if c.isascii() and c.isalnum() else f"_{ord(c):x}Z" for c in file.name
    )


def _error(message: str, trail: _Trail, remedy: str) -> ShaderError:
    *outer, (file, line) = trail
    chain = f" (included by {_chain(outer)})" if outer else ""
    return ShaderError(message + chain, file=file.path, line=line, remedy=remedy)


def _chain(trail: Iterable[tuple[File, int]]) -> str:
    return " → ".join(f"{file.path}:{line}" for file, line in trail)


@dataclass(frozen=True)
class Source:
    """One shader after `#include`: the name that it was loaded by, such as
    "lamps/attenuation.frag", the file on disk (or the name if it is not a file's), what the
    compiler gets, with line ends "\\n", for each line of that the author's file and line, each
    contributing file's path and own text, the main file first, and in words what was added."""

    name: str
    path: str
    stage: str
    text: str
    lines: LineMap
    parts: tuple[tuple[str, str], ...]
    stripped: str | None = field(default=None, repr=False, compare=False)
    notes: tuple[str, ...] = ()

    @functools.cached_property
    def code(self) -> str:
        """The text with its comments blanked out; all other characters stay in place."""
        return strip_comments(self.text) if self.stripped is None else self.stripped

    @functools.cached_property
    def version(self) -> tuple[int, str]:
        """The `#version` as (330, "core"); (110, "") if there is none."""
        return version_of(self.code) or (110, "")

    @functools.cached_property
    def declarations(self) -> tuple[GlslDeclaration, ...]:
        """What the text declares outside of functions."""
        from .syntax import Syntax  # few programs are parsed

        return Syntax(self.code).declarations

    def place(self, line: int) -> tuple[str, int]:
        """Return the author's file and line for a line of `text` (both counted from 1)."""
        if not self.lines:
            return self.path, line
        return self.lines[min(max(line, 1), len(self.lines)) - 1]

    def diagnostic(
        self, message: str, at: int | None = None, *, severity: Severity = "error", token: str = ""
    ) -> Diagnostic:
        """Return a message about a line of `text` (counted from 1), or about the whole file."""
        file, line = (self.path, None) if at is None else self.place(at)
        return Diagnostic(file=file, line=line, severity=severity, message=message, token=token)


def with_version(source: Source) -> Source:
    """Return a source with a `#version`, its own or the one that its functions are read as. What
    they may need of later versions, the driver takes."""
    if version_of(source.code) is not None:
        return source
    version = 430 if source.stage == "compute" else 330
    lines = LineMap(((source.path, 1, 1), *source.lines.spans))
    text = f"#version {version} core\n{source.text}"
    return replace(source, text=text, lines=lines, stripped=None)


class Shaders(Roots):
    """Loads shaders by name from a list of root folders. `overrides` has by a shader's name the
    text to use, or the file to read, in its place, where it is included as well, `defines` macros
    to put after each `#version` line, and `renames` what names in the files of `overrides` are
    called instead."""

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
        """Return the shader of that path inside the roots with its includes expanded. Its stage is
        one of `STAGES`; by default that of the extension or, in a .glsl file, of
        `#pragma shader_stage(fragment)`. Raises ShaderError: there is no such file in the roots, it
        or one of its includes can't be used, or the stage is unknown."""
        file = self.shader(name)
        return self._source(file, name, stage or stage_of(name, file.text, file.path))

    def load_stages(self, name: str, stage: str | None = None) -> list[Source]:
        """As `load`; without a stage, all of those that the file has sections for."""
        source = self.load(name, stage)
        others = [] if stage else find_sections(text for _, text in source.parts)
        return [self.load(name, each) for each in others] or [source]

    def from_text(self, text: str, stage: str, name: str) -> Source:
        """Return a shader that is not a file, such as a generated stage; it may include files.
        Raises ShaderError: the stage is unknown, or the text or one of its includes can't be
        used."""
        return self._source(File(name, name, normalise(text, name)), name, stage)

    def _source(self, file: File, name: str, stage: str) -> Source:
        if stage not in STAGES:
            raise ShaderError(
                f"no such stage: {stage!r}", file=file.path, remedy=suggest(stage, STAGES)
            )
        out = expand(file, self, self._defines, stage)
        text, code = "\n".join(out.rows), "\n".join(out.codes)
        parts = tuple(out.parts.items())
        return Source(name, file.path, stage, text, LineMap.of(out.spans), parts, code)
