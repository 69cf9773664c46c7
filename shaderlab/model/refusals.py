"""Expectations of what must be refused: by the compilers, by the driver, by the lab itself; and of
what the driver leaves out. Data only; `shaderlab.checks.refusals` judges them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from shaderlab.errors import CaseError

Place = tuple[str, int | None, str]
"""A shader's name, a line from 1 (None where a message has none), and the whole message."""


@dataclass(frozen=True, kw_only=True)
class CompileFails:
    """A shader, or a program of several, is refused with exactly these messages.

    `driver` says whether the driver must refuse it too; in which words is up to the driver.
    """

    shaders: tuple[str, ...]
    messages: tuple[Place, ...]
    driver: bool = True
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class Refused:
    """The lab itself refuses something, with exactly this message, place and remedy.

    `what` is a shader's name, to be read with its includes, or a function to be called.
    """

    what: str | Callable[[], Any]
    message: str
    file: str = ""
    line: int | None = None
    remedy: str = ""
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class InactiveUniforms:
    """Of all uniforms that a draw's program declares, exactly these have location −1."""

    uniforms: tuple[str, ...]
    pass_name: str | None = None
    draw: int = -1
    name: str = ""


def compile_fails(
    shader: str | Sequence[str],
    *messages: tuple[int | None, str] | Place,
    driver: bool = True,
    name: str = "",
) -> CompileFails:
    """`shader` is refused with these whole messages, each (line, text), in this order.

    Args:
        shader: one file, which is compiled by itself; or several, which are linked as well.
        messages: all errors of the plain GLSL compiler, in its words. For several files each is
            (file, line, text). A message of the linker that no declaration can be found for has
            the line None.
        driver: whether the driver must refuse it, too. Its words differ from those of another
            driver: they are shown, and not compared.
        name: how outcomes call it.

    Raises:
        CaseError: a message does not say which of several files it is about.
    """
    shaders = (shader,) if isinstance(shader, str) else tuple(shader)
    places: list[Place] = []
    for message in messages:
        place = (shaders[0], *message) if len(message) == 2 else message
        if (len(message) == 2 and len(shaders) > 1) or place[0] not in shaders:
            raise CaseError(
                f"compile_fails: {message!r} is about none of {', '.join(shaders)}",
                remedy="write (file, line, text)",
            )
        places.append(place)
    label = " + ".join(shaders)
    return CompileFails(
        shaders=shaders, messages=tuple(places), driver=driver, name=name or f"{label} is refused"
    )


def refused(
    what: str | Callable[[], Any],
    *,
    message: str,
    file: str | None = None,
    line: int | None = None,
    remedy: str = "",
    name: str = "",
) -> Refused:
    """The lab refuses `what` with this whole error: message, file, line and remedy.

    Args:
        what: a shader's name, which the lab is asked to read with its includes; or a function
            that must raise one of the lab's errors, such as one that reads a mesh.
        message: the error's message. Folders of the case and of the shaders are left out of
            paths, here and in `file`, so that they are the same on every machine.
        file: the file that the error names, "" for none; the shader itself by default.
        line: the line that it names, if it names one.
        remedy: what it advises, "" for nothing.
        name: how outcomes call it.
    """
    if not isinstance(what, str) and not callable(what):
        raise CaseError(f"refused: needs a shader's name or a function, not {what!r}")
    own = what if isinstance(what, str) else ""
    return Refused(
        what=what,
        message=message,
        file=own if file is None else file,
        line=line,
        remedy=remedy,
        name=name or f"{own or file or 'it'} is refused",
    )


def inactive_uniforms(
    *uniforms: str, pass_name: str | None = None, draw: int = -1, name: str = ""
) -> InactiveUniforms:
    """Exactly these of the uniforms that a draw's program declares are inactive: no output depends
    on them, and the driver gives them the location −1. All others have a location."""
    return InactiveUniforms(
        uniforms=uniforms, pass_name=pass_name, draw=draw, name=name or "inactive uniforms"
    )
