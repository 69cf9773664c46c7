"""Reading a shader file into text, and looking at GLSL text without its comments."""

from __future__ import annotations

import os
import re
from pathlib import Path

from shaderlab.errors import ShaderError

# A quoted include path may hold "//"; everything else that looks like a comment is one. Without
# groups the search skips to the next quote or slash, which is several times as fast.
_COMMENT = re.compile(r'"[^"\n]*"|//(?:\\\n|[^\n])*|/\*.*?(?:\*/|\Z)', re.DOTALL)
_VERSION = re.compile(r"#[ \t]*version[ \t]+(\d+)[ \t]*(\w*)")
MAX_BYTES = 4 << 20
"""The largest file that is taken for a shader."""

_WIDE = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16"}


def read_shader(path: str | Path) -> str:
    """The file's text with "\\n" line ends and no byte order mark.

    Raises:
        ShaderError: no such file, a directory, unreadable, too large, empty, or not UTF-8.
    """
    try:
        with open(path, "rb") as file:
            # Read by its size: a limit as large as this would be allocated for every file.
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
    """UTF-8 bytes as text, less a byte order mark.

    Raises:
        ShaderError: the bytes are not UTF-8; the message names the first bad byte's offset.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        offset = error.start
        guess = _WIDE.get(data[:2])
        raise ShaderError(
            f"is not UTF-8: byte {offset} is 0x{data[offset]:02x}"
            + (f" (it looks like {guess})" if guess else ""),
            file=path,
            line=None if guess else data.count(b"\n", 0, offset) + 1,
            remedy="save the file as UTF-8",
        ) from None


def normalise(text: str, path: str | Path) -> str:
    """Text with "\\n" line ends, refused where no compiler could see all of it.

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
    """The text with every comment blanked out, all other characters where they were."""
    if "//" not in text and "/*" not in text:
        return text
    return _COMMENT.sub(_blank, text)


def _blank(match: re.Match[str]) -> str:
    comment = match.group()
    if comment[0] == '"':
        return comment
    if "\n" not in comment:
        return " " * len(comment)
    return "\n".join(" " * len(row) for row in comment.split("\n"))


def version_of(code: str) -> tuple[int, str] | None:
    """The `#version` of comment-free text as (330, "core"), or None where it gives none."""
    for match in _VERSION.finditer(code):
        if not code[code.rfind("\n", 0, match.start()) + 1 : match.start()].strip():
            return int(match.group(1)), match.group(2)
    return None
