"""OpenGL's functions and constants as PyOpenGL declares them, imported on EGL: it chooses its
platform once, from the environment, as it is imported.

All modules of this backend take them from here. `GL` has each C function as it is, and those that
give something back by a pointer as functions that return it. `OpenGL.GL` has such of all functions,
and takes three times as long to import.
"""

from __future__ import annotations

import ctypes
import functools
import importlib
import pkgutil
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from shaderlab.backends.opengl import environment

with environment():
    from OpenGL.error import GLError as GLError, NullFunctionError as NullFunctionError
    from OpenGL.raw.GL import VERSION, _errors
    from OpenGL.raw.GL.ARB import gl_spirv as gl_spirv
    from OpenGL.raw.GL.VERSION import GL_1_0 as GL_1_0, GL_1_2 as GL_1_2, GL_1_3 as GL_1_3

ERROR_CHECKER = _errors._error_checker
"""What PyOpenGL asks for errors after each call, or None in a process without such checks."""
GL: Any = ModuleType("GL")


@functools.cache
def named(word: str) -> int:
    """The number of a constant by its name as `shaderlab.model` has it: in lower case, bare.

    >>> hex(named("one_minus_src_alpha"))
    '0x303'
    """
    return int(getattr(GL, f"GL_{word.upper()}"))


def _declared() -> dict[str, Any]:
    """Each function and constant, from the first version that has it."""
    versions = sorted(module.name for module in pkgutil.iter_modules(VERSION.__path__))
    modules = [importlib.import_module(f"{VERSION.__name__}.{version}") for version in versions]
    found: dict[str, Any] = {}
    for module in reversed(modules):
        found.update((n, v) for n, v in vars(module).items() if n[:2] in ("gl", "GL"))
    return found


def _generator(function: Callable[..., None]) -> Callable[[int], Any]:
    """Of a glGen function: makes one object and returns its number, or several and an array."""

    def generate(count: int) -> Any:
        numbers = np.empty(count, np.uint32)
        function(count, numbers)
        return int(numbers[0]) if count == 1 else numbers

    return generate


def _deleter(function: Callable[..., None]) -> Callable[[int, Sequence[int]], None]:
    return lambda count, numbers: function(count, np.array(numbers, np.uint32))


def _getter(function: Callable[..., None]) -> Callable[..., int]:
    """Of a glGet function: returns the one number that it asks for."""

    def get(*arguments: int) -> int:
        number = np.zeros(1, np.uint32 if function.__name__.endswith("uiv") else np.int32)
        function(*arguments, number)
        return int(number[0])

    return get


def _log(function: Callable[..., None], length: Callable[..., int]) -> Callable[[int], bytes]:
    def log(number: int) -> bytes:
        text = ctypes.create_string_buffer(length(number, GL.GL_INFO_LOG_LENGTH) + 1)
        function(number, len(text), None, text)
        return text.value

    return log


def _shader_source(shader: int, text: str) -> None:
    given = ctypes.c_char_p(text.encode())
    pointer = ctypes.cast(ctypes.pointer(given), ctypes.POINTER(ctypes.POINTER(ctypes.c_char)))
    _DECLARED["glShaderSource"](shader, 1, pointer, None)


def _attached_shaders(program: int) -> list[int]:
    numbers = np.zeros(GL.glGetProgramiv(program, GL.GL_ATTACHED_SHADERS), np.uint32)
    _DECLARED["glGetAttachedShaders"](program, len(numbers), None, numbers)
    return [int(number) for number in numbers]


_DECLARED = _declared()
for _name in ("glGetString", "glGetStringi"):  # as `OpenGL.GL` does; PyOpenGL reads them so itself
    _DECLARED[_name].restype = ctypes.c_char_p
vars(GL).update(_DECLARED)
_OBJECTS = ("buffers", "queries", "renderbuffers", "samplers", "textures")
for _name in map(str.capitalize, _OBJECTS):
    setattr(GL, f"glGen{_name}", _generator(_DECLARED[f"glGen{_name}"]))
    setattr(GL, f"glDelete{_name}", _deleter(_DECLARED[f"glDelete{_name}"]))
for _name in ("Integerv", "Programiv", "QueryObjectuiv", "Shaderiv", "VertexAttribiv"):
    setattr(GL, f"glGet{_name}", _getter(_DECLARED[f"glGet{_name}"]))
GL.glGetShaderInfoLog = _log(_DECLARED["glGetShaderInfoLog"], GL.glGetShaderiv)
GL.glGetProgramInfoLog = _log(_DECLARED["glGetProgramInfoLog"], GL.glGetProgramiv)
GL.glShaderSource, GL.glGetAttachedShaders = _shader_source, _attached_shaders
