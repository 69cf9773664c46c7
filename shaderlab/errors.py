"""The one tree of errors: each says what is wrong, where, and what to do about it.

Errors of other libraries are translated into these where they occur, so `except ShaderlabError`
catches everything that the lab raises. What compilers say is plain data, at the end.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal


def make_visible(text: str) -> str:
    """Return a text with names for characters that can't be seen, which could steer a terminal.

    >>> make_visible("a\\x1b[31m\\u202eb")
    'a[U+001B][31m[U+202E]b'
    """
    if text.isprintable():
        return text
    return "".join(
        char if char.isprintable() or char in "\n\t" else f"[U+{ord(char):04X}]" for char in text
    )


def significant(value: float) -> str:
    """A number in the nine digits that tell float32 values apart, or the ten of a 32-bit integer.

    >>> significant(0.1), significant(2654435761.0), significant(2.0**40)
    ('0.1', '2654435761', '1.09951163e+12')
    """
    whole = float(value).is_integer() and abs(value) < 2.0**32
    return f"{value:.{10 if whole else 9}g}"


class ShaderlabError(Exception):
    """Base of all errors of the lab.

    Args:
        message: what is wrong, in one sentence.
        file: the file that the reader has to open; None or "?" where there is none.
        line: the line in it, counted from 1.
        remedy: what to do about it.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        remedy: str | None = None,
    ) -> None:
        self.message = message
        self.file = None if file in (None, "?") else str(file)
        self.line = line
        self.remedy = remedy
        super().__init__(str(self))

    def __str__(self) -> str:
        place = "" if self.file is None else self.file.replace("\n", "[U+000A]")
        if place and self.line is not None:
            place += f":{self.line}"
        text = f"{place}: {self.message}" if place else self.message
        return make_visible(f"{text}\n  → {self.remedy}" if self.remedy else text)

    def __reduce__(self) -> tuple[object, ...]:
        # Keyword-only arguments do not survive the default pickling; errors cross processes.
        notes = {"__notes__": self.__notes__} if hasattr(self, "__notes__") else {}
        made = partial(type(self), file=self.file, line=self.line, remedy=self.remedy)
        return made, (self.message,), notes


class CaseError(ShaderlabError):
    """A case file, or the data in it, is wrong."""


class ShaderError(ShaderlabError):
    """A shader file can't be read, included, compiled or linked, or its interface doesn't fit."""


class DriverError(ShaderlabError):
    """No OpenGL driver, one that lacks what was asked for, or a GL error nobody expected."""


class UnsupportedError(DriverError):
    """This driver truly lacks a feature that the case needs; the message names the feature."""


class OtherApiError(UnsupportedError):
    """What is asked is about OpenGL's own calls, and this driver draws by another API."""


class DeviceLostError(DriverError):
    """The device is gone, and all that was on it; the message says what it was doing."""


class FormulaError(ShaderlabError):
    """A reference formula asks for an input that is not there, or fails on the inputs it got."""


class NotInterpretedError(ShaderlabError):
    """A shader does what the interpreter does not know, or does not end."""


class CallError(ShaderlabError):
    """A GLSL function can't be called with these arguments, or did not come back."""


class ArgumentsError(CallError, TypeError):
    """A call has too many arguments, lacks one, or has one of an unknown name."""


class NoFunctionError(CallError, AttributeError, KeyError):
    """A file of GLSL has no function of this name."""


class AssetError(ShaderlabError):
    """A mesh or an image can't be read or is not what its use requires."""


class UsageError(ShaderlabError):
    """The command line asks for something that does not exist."""


class MissingPackageError(UnsupportedError, UsageError):
    """Something needs a package that comes with an extra, which is not installed."""


def require_linux() -> None:
    """Raise UsageError on other systems, where only what needs no compiler and no driver works."""
    if sys.platform != "linux":
        raise UsageError(
            "compiling and drawing shaders needs Linux; shaderlab.bands, shaderlab.glslmath and "
            "shaderlab.reference work here as well",
            remedy="use WSL 2 on Windows, and a container on macOS",
        )


@contextmanager
def in_file(file: str) -> Iterator[None]:
    """Around work on a file: an error that names no file names this one."""
    try:
        yield
    except ShaderlabError as error:
        error.file = file if error.file is None else error.file
        raise


@contextmanager
def require_extra(name: str, what: str, file: str | Path | None = None) -> Iterator[None]:
    """Around the import of a package that `what` needs, and that comes with the extra `name`.
    Raises MissingPackageError: it is not installed; says how to install it."""
    try:
        yield
    except ImportError as error:
        remedy = f"pip install 'shaderlab[{name}]'"
        message = f"{what} needs {error.name or error}"
        raise MissingPackageError(message, file=file, remedy=remedy) from error


def suggest(word: str, choices: Iterable[str]) -> str:
    """A remedy for a misspelt word: the right spellings nearest to it, or all there are.

    >>> suggest("uniform", ["uniforms", "textures"])
    'did you mean uniforms?'
    """
    import difflib  # few commands have such a word

    known = list(dict.fromkeys(choices))
    close = difflib.get_close_matches(word, known, n=3, cutoff=0.6)
    if close:
        return f"did you mean {' or '.join(close)}?"
    if not known:
        return "there are none to choose from"
    shown = ", ".join(known[:24]) + (", …" if len(known) > 24 else "")
    return f"there is: {shown}"


Severity = Literal["error", "warning", "info"]


@dataclass(frozen=True, kw_only=True)
class Diagnostic:
    """One message of a compiler, at the author's own file and line (counted from 1)."""

    file: str
    line: int | None
    severity: Severity
    message: str
    token: str = ""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The verdict of one compile target, or of a driver, on one program.

    `ok` covers the compiler and, for SPIR-V targets, SPIRV-Tools' validator as well; the
    validator alone is in `valid`, None where there was no module to look at.
    `spirv_bytes` is the size of all its stages' modules and `instructions` how many SPIR-V
    instructions they have; both are 0 for plain GLSL. `assembly` is the file of the modules as
    text, those of the program's other targets among them, relative to the run's folder, or "".
    `status` is "" for an answer; "crash" or "timeout" where the compiler gave none, and
    "disagrees" where a driver's answer is not that of the plain GLSL compiler.
    """

    target: str
    ok: bool
    diagnostics: tuple[Diagnostic, ...] = ()
    spirv_bytes: int = 0
    instructions: int = 0
    valid: bool | None = None
    assembly: str = ""
    status: Literal["", "crash", "timeout", "disagrees"] = ""
