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
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from . import environment

with environment():
    from OpenGL.error import GLError as GLError, NullFunctionError as NullFunctionError
    from OpenGL.raw.GL import VERSION, _errors
    from OpenGL.raw.GL.ARB import gl_spirv as gl_spirv
    from OpenGL.raw.GL.VERSION import GL_1_0 as GL_1_0, GL_1_2 as GL_1_2, GL_1_3 as GL_1_3

ERROR_CHECKER = _errors._error_checker
"""What PyOpenGL asks for errors after each call, or None in a process without such checks."""


class _Declarations(ModuleType):
    """Each function and constant, from the first version that has it. A version is imported once a
    name is asked for that no earlier one has."""

    def __init__(self) -> None:
        super().__init__("GL")
        self._later = sorted(module.name for module in pkgutil.iter_modules(VERSION.__path__))

    def __getattr__(self, name: str) -> Any:
        found = vars(self)
        while name.startswith(("gl", "GL")) and self._later:
            module = importlib.import_module(f"{VERSION.__name__}.{self._later.pop(0)}")
            for each, value in vars(module).items():
                if each.startswith(("gl", "GL")) and each not in found:
                    found[each] = _RETURNING[each](value) if each in _RETURNING else value
            if name in found:
                return found[name]
        raise AttributeError(name)


GL: Any = _Declarations()


def declarations() -> Mapping[str, Any]:
    """All functions and constants by their names."""
    getattr(GL, "gl", None)  # no version has that
    return {name: value for name, value in vars(GL).items() if name.startswith(("gl", "GL"))}


@functools.cache
def named(word: str) -> int:
    """The number of a constant by its name as `shaderlab.model` has it: in lower case, bare.

    >>> hex(named("one_minus_src_alpha"))
    '0x303'
    """
    return int(getattr(GL, f"GL_{word.upper()}"))


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
    kind = ctypes.c_uint if function.__name__.endswith("uiv") else ctypes.c_int

    def get(*arguments: int) -> int:
        number = kind()
        function(*arguments, ctypes.byref(number))
        return number.value

    return get


def _log(length: str) -> Callable[[Callable[..., None]], Callable[[int], bytes]]:
    """Of a function that writes a log: returns it. `length` is the function that tells its size."""

    def returning(function: Callable[..., None]) -> Callable[[int], bytes]:
        def log(number: int) -> bytes:
            size = getattr(GL, length)(number, GL.GL_INFO_LOG_LENGTH)
            if not size:
                return b""
            text = ctypes.create_string_buffer(size + 1)
            function(number, len(text), None, text)
            return text.value

        return log

    return returning


def _text(function: Any) -> Any:
    function.restype = ctypes.c_char_p  # as `OpenGL.GL` does; PyOpenGL reads them so itself
    return function


def _shader_source(function: Callable[..., None]) -> Callable[[int, str], None]:
    def set_source(shader: int, text: str) -> None:
        given = ctypes.c_char_p(text.encode())
        pointer = ctypes.cast(ctypes.pointer(given), ctypes.POINTER(ctypes.POINTER(ctypes.c_char)))
        function(shader, 1, pointer, None)

    return set_source


def _attached_shaders(function: Callable[..., None]) -> Callable[[int], list[int]]:
    def attached(program: int) -> list[int]:
        numbers = (ctypes.c_uint * GL.glGetProgramiv(program, GL.GL_ATTACHED_SHADERS))()
        function(program, len(numbers), None, numbers)
        return list(numbers)

    return attached


_OBJECTS = ("buffers", "queries", "renderbuffers", "samplers", "textures")
_ASKED = ("Integerv", "Programiv", "QueryObjectuiv", "Shaderiv", "VertexAttribiv")
_RETURNING: Mapping[str, Callable[[Any], Any]] = {
    **{f"glGen{name.capitalize()}": _generator for name in _OBJECTS},
    **{f"glDelete{name.capitalize()}": _deleter for name in _OBJECTS},
    **{f"glGet{name}": _getter for name in _ASKED},
    "glGetString": _text,
    "glGetStringi": _text,
    "glGetShaderInfoLog": _log("glGetShaderiv"),
    "glGetProgramInfoLog": _log("glGetProgramiv"),
    "glShaderSource": _shader_source,
    "glGetAttachedShaders": _attached_shaders,
}
