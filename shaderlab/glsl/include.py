"""`#include`: one text out of a shader and the files it includes, with a map of its lines.

Expansion is textual and happens before the compiler's own preprocessor, so an include inside
an inactive `#if` is expanded as well (its text is then skipped like any other). A file with
`#pragma once` gets a guard macro, which gives it the meaning C programmers know.
"""

from __future__ import annotations

import posixpath
import re
from dataclasses import dataclass, field

from shaderlab.errors import ShaderError, nearest
from shaderlab.glsl.linemap import LineMap
from shaderlab.glsl.reading import version_of, without_comments
from shaderlab.glsl.roots import File, OutsideError, Roots, inside

MAX_DEPTH = 64
MAX_INCLUDES = 1000

_DIRECTIVE = re.compile(r"[ \t]*#[ \t]*(include|pragma|line|extension)\b[ \t]*(.*)")
_ANY_DIRECTIVE = re.compile(r"#[ \t]*(?:include|pragma|line|extension)\b")
_PATH = re.compile(r'"([^"]*)"[ \t]*|<([^>]*)>[ \t]*')
_LINE = re.compile(r'(\d+)(?:[ \t]+(?:\d+|"([^"]*)"))?[ \t]*')
_INCLUDE_EXTENSIONS = ("GL_GOOGLE_include_directive", "GL_ARB_shading_language_include")


@dataclass(frozen=True)
class Expanded:
    """Text with includes expanded, the same less its comments, each line's origin, and the files
    it is made of."""

    text: str
    code: str
    lines: LineMap
    parts: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class _Site:
    """Where an include stands: the file, the line in it, and where that file was included."""

    file: File
    line: int
    outer: _Site | None

    def chain(self) -> str:
        outer = f"{self.outer.chain()} → " if self.outer else ""
        return f"{outer}{self.file.path}:{self.line}"

    def depth(self) -> int:
        return 1 + (self.outer.depth() if self.outer else 0)

    def names(self) -> tuple[str, ...]:
        return (*(self.outer.names() if self.outer else ()), self.file.name)


@dataclass
class _Output:
    rows: list[str] = field(default_factory=list)
    codes: list[str] = field(default_factory=list)
    spans: list[tuple[str, int, int]] = field(default_factory=list)
    parts: dict[str, str] = field(default_factory=dict)
    includes: int = 0

    def add(self, row: str, code: str, place: tuple[str, int]) -> None:
        self.rows.append(row)
        self.codes.append(code)
        self.spans.append((*place, 1))


def expand(file: File, roots: Roots) -> Expanded:
    """The file's text with every `#include` replaced by the included file's text.

    Raises:
        ShaderError: an include is malformed, missing, circular, outside the roots, too deep,
            or can't be read; the message has the chain of includes that led there.
    """
    out = _Output()
    code = without_comments(file.text)
    version = version_of(code)
    _expand(file, code, roots, None, out, version[0] if version else 110)
    return Expanded(
        "\n".join(out.rows), "\n".join(out.codes), LineMap.of(out.spans), tuple(out.parts.items())
    )


def _expand(
    file: File, code: str, roots: Roots, outer: _Site | None, out: _Output, version: int
) -> None:
    out.parts.setdefault(file.path, file.text)
    rows = file.text.split("\n")
    if outer is not None and rows[-1] == "":
        rows.pop()  # the line end that closes the file starts no line of its own
    codes = code.split("\n")
    guard = _guard(file, codes) if outer is not None else None
    place = (file.path, 1)
    if guard:
        for row in (f"#ifndef {guard}", f"#define {guard}"):
            out.add(row, row, place)
    if not _ANY_DIRECTIVE.search(code):
        out.rows += rows
        out.codes += codes[: len(rows)]
        out.spans.append((file.path, 1, len(rows)))
        return
    said_file, shift = file.path, 0  # what the author's own #line makes of file and line
    for number, (row, code) in enumerate(zip(rows, codes, strict=False), start=1):
        place = (said_file, number + shift)
        directive = _DIRECTIVE.fullmatch(code) if "#" in code else None
        kind = directive.group(1) if directive else ""
        rest = directive.group(2).strip() if directive else ""
        said = _LINE.fullmatch(rest) if kind == "line" else None
        if kind == "include":
            site = _Site(file, number, outer)
            _check_count(site, out)
            inner = _included(rest, site, roots)
            _expand(inner, without_comments(inner.text), roots, site, out, version)
        elif kind == "extension" and rest.split(":")[0].strip() in _INCLUDE_EXTENSIONS:
            out.add("", "", place)  # drivers that lack the extension would refuse it
        elif said:
            out.add("", "", place)
            # Up to GLSL 1.50 the line after `#line n` is n + 1, from 3.30 on it is n.
            shift = int(said.group(1)) - number - (1 if version >= 330 else 0)
            said_file = said.group(2) or said_file
        else:
            out.add(row, code, place)
    if guard:
        out.add("#endif", "#endif", place)


def _included(rest: str, site: _Site, roots: Roots) -> File:
    """The file that the text after `#include` names."""
    match = _PATH.fullmatch(rest)
    if match is None:
        raise _error(f"malformed #include {rest}".rstrip(), site, 'write #include "file.glsl"')
    asked = match.group(1) if match.group(1) is not None else match.group(2)
    folder = posixpath.dirname(site.file.name)
    folders = [folder, ""] if match.group(1) is not None and folder else [""]
    outside = None
    for start in folders:
        try:
            name = inside(asked, start)
            if name in site.names() and not _is_once(site, name):
                raise _error(f"{asked!r} includes itself", site, "break the cycle of includes")
            file = roots.find(name)
        except OutsideError as error:
            outside = outside or error
            continue
        except ShaderError as error:
            raise _error_in(error, site) from None
        if file is not None:
            return _not_again(file, site)
    if outside is not None:
        raise _error(f"#include {asked!r} {outside}", site, "move the file into a shader folder")
    raise _error(f"no file to #include: {asked!r}", site, nearest(asked, roots.names()))


def _not_again(file: File, site: _Site) -> File:
    """The file, or nothing of it where it has `#pragma once` and is being expanded already."""
    if site.depth() > MAX_DEPTH:
        raise _error(f"includes nest deeper than {MAX_DEPTH}", site, "include less deeply")
    if file.name in site.names():
        return File(file.name, file.path, "\n")
    return file


def _is_once(site: _Site | None, name: str) -> bool:
    while site is not None:
        if site.file.name == name:
            return _has_once(without_comments(site.file.text).split("\n"))
        site = site.outer
    return False


def _has_once(codes: list[str]) -> bool:
    return any(re.fullmatch(r"[ \t]*#[ \t]*pragma[ \t]+once[ \t]*", code) for code in codes)


def _guard(file: File, codes: list[str]) -> str | None:
    """A macro's name for a file with `#pragma once`; two underscores in a row are reserved."""
    if not _has_once(codes):
        return None
    return "SHADERLAB_ONCE_" + "".join(
        c if c.isascii() and c.isalnum() else f"_{ord(c):x}Z" for c in file.name
    )


def _check_count(site: _Site, out: _Output) -> None:
    out.includes += 1
    if out.includes > MAX_INCLUDES:
        raise _error(
            f"includes more than {MAX_INCLUDES} times in all",
            site,
            "include files that are needed in many places once, from the main file",
        )


def _error(message: str, site: _Site, remedy: str) -> ShaderError:
    chain = f" (included by {site.outer.chain()})" if site.outer else ""
    return ShaderError(message + chain, file=site.file.path, line=site.line, remedy=remedy)


def _error_in(error: ShaderError, site: _Site) -> ShaderError:
    """An error of reading an included file, with the chain that led to it."""
    if "included by" in error.message or "includes itself" in error.message:
        return error
    message = f"{error.message} (included by {site.chain()})"
    return ShaderError(message, file=error.file, line=error.line, remedy=error.remedy)
