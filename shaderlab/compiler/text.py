"""A shader file's text: encoding, line ends, comments, `#version`, stage."""

from __future__ import annotations

import codecs
import os
import posixpath
import re
from collections.abc import Mapping
from pathlib import Path

from shaderlab.errors import ShaderError, nearest
from shaderlab.files import open_regular

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

# A quoted include path may hold "//"; everything else that looks like a comment is one. Without
# groups the search skips to the next quote or slash, which is several times as fast.
_COMMENT = re.compile(r'"[^"\n]*"|//(?:\\\n|[^\n])*|/\*.*?(?:\*/|\Z)', re.DOTALL)
_VERSION = re.compile(r"#[ \t]*version[ \t]+(\d+)[ \t]*(\w*)")
MAX_BYTES = 4 << 20
"""The largest file accepted as a shader."""


def read_shader(path: str | Path) -> str:
    """The file's text with "\\n" line ends and no byte order mark.

    Raises:
        ShaderError: no such file, no regular file, unreadable, too large, empty, or not UTF-8.
    """
    try:
        with open(open_regular(path), "rb") as file:
            # Read by its size, since a buffer of the limit would be allocated for every file.
            size = os.fstat(file.fileno()).st_size
            data = file.read() if size <= MAX_BYTES else file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise ShaderError("no such shader file", file=path) from None
    except OSError as error:
        if os.path.isdir(path):
            raise ShaderError(
                "is a directory, not a shader", file=path, remedy="name a file in it"
            ) from None
        reason = error.strerror or str(error)
        raise ShaderError(f"can't read the shader: {reason}", file=path) from error
    if len(data) > MAX_BYTES:
        raise ShaderError(
            f"is larger than {MAX_BYTES >> 20} MiB, which no shader is",
            file=path,
            remedy="see whether this is a shader at all",
        )
    return normalise(decode(data, path), path)


def decode(data: bytes, path: str | Path) -> str:
    """UTF-8 bytes as text, without a byte order mark.

    Raises:
        ShaderError: the bytes are not UTF-8; the message names the first bad byte's offset.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        offset = error.start
        wide = data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
        raise ShaderError(
            f"is not UTF-8: byte {offset} is 0x{data[offset]:02x}"
            + (" (it looks like UTF-16)" if wide else ""),
            file=path,
            line=None if wide else data.count(b"\n", 0, offset) + 1,
            remedy="save the file as UTF-8",
        ) from None


def normalise(text: str, path: str | Path) -> str:
    """Text with "\\n" line ends.

    Raises:
        ShaderError: the text is empty or holds a NUL character, at which compilers stop reading.
    """
    text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    if not text.strip():
        raise ShaderError("the shader is empty", file=path)
    nul = text.find("\0")
    if nul >= 0:
        raise ShaderError(
            "holds a NUL character, at which compilers stop reading",
            file=path,
            line=text.count("\n", 0, nul) + 1,
            remedy="delete it",
        )
    return text


def without_comments(text: str) -> str:
    """The text with its comments blanked out; all other characters stay in place."""
    if "//" not in text and "/*" not in text:
        return text
    return _COMMENT.sub(_blank, text)


def _blank(match: re.Match[str]) -> str:
    comment = match.group()
    if comment[0] == '"':
        return comment
    return "\n".join(" " * len(row) for row in comment.split("\n"))


def version_of(code: str) -> tuple[int, str] | None:
    """The `#version` of comment-free text as (330, "core"), or None if it has none."""
    for match in _VERSION.finditer(code):
        if not code[code.rfind("\n", 0, match.start()) + 1 : match.start()].strip():
            return int(match.group(1)), match.group(2)
    return None


def stage_of(name: str, text: str, path: str | None = None) -> str:
    """The stage that a file's extension or its `#pragma shader_stage(…)` names.

    Raises:
        ShaderError: there is neither, or the pragma names no stage.
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
