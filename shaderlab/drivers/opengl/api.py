"""OpenGL's functions and constants by name, as PyOpenGL declares them, and contexts for them."""

from __future__ import annotations

import importlib
import os
import pkgutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from typing import Any

from shaderlab.errors import CaseError, DriverError, nearest

from . import environment
from .device import REQUIRED_VERSION, Device, declarations, libraries


def prototype(name: str) -> Any:
    """A C function by its name, with its argument names and types. Raises CaseError."""
    if name not in prototypes():
        raise CaseError(f"OpenGL has no function {name!r}", remedy=nearest(name, prototypes()))
    return prototypes()[name]


@cache
def prototypes() -> Mapping[str, Any]:
    """Each C function by its name, from the first version that has it."""
    from OpenGL.raw.GL import VERSION

    found: dict[str, Any] = {}
    for version in sorted(module.name for module in pkgutil.iter_modules(VERSION.__path__)):
        module = importlib.import_module(f"{VERSION.__name__}.{version}")
        for name, function in vars(module).items():
            if name.startswith("gl") and name[2:3].isupper():
                found.setdefault(name, function)
    return found


@cache
def constants() -> Mapping[str, int]:
    """The number of each constant by its name."""
    known = declarations().items()
    return {n: int(v) for n, v in known if n.startswith("GL_") and isinstance(v, int)}


def constant(words: str) -> int:
    """The number of a constant, or of several joined by "|".

    Raises:
        CaseError: OpenGL has no such constant.

    >>> hex(constant("GL_MAP_READ_BIT | GL_MAP_WRITE_BIT"))
    '0x3'
    """
    number = 0
    for word in (w.strip() for w in words.split("|")):
        if word not in constants():
            raise CaseError(f"OpenGL has no constant {word!r}", remedy=nearest(word, constants()))
        number |= constants()[word]
    return number


def name_of(number: int, like: str) -> str:
    """The name of a number among those that begin as another one does, or ""."""
    found = [name for name, value in constants().items() if value == number]

    def alike(name: str) -> tuple[int, int]:
        return len(os.path.commonprefix([name, like])), -len(name)  # noqa: RUF071 - these are words

    return max(found, key=alike, default="")


@contextmanager
def fresh_context(device: Device) -> Iterator[Any]:
    """A context of its own (glcontext's), current for a while, which takes with it what was made in
    it. The device's is untouched, and current again afterwards."""
    import glcontext

    names = {"glversion": REQUIRED_VERSION, "mode": "standalone", **libraries()}
    try:
        with environment(device.driver):
            fresh = glcontext.get_backend_by_name("egl")(**names)
    except Exception as error:  # glcontext raises plain Exception for whatever EGL says
        raise DriverError(f"no further OpenGL context on EGL ({error})") from error
    try:
        yield fresh
    finally:
        fresh.release()
        device.make_current()
