"""OpenGL's functions and constants by name, and a case's calls of them in a separate context.

The C functions are called as they are (PyOpenGL's raw prototypes): its convenient wrappers look at
some arguments themselves, and would answer in the driver's place.
"""

import ctypes
import importlib
import os
import pkgutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any, TypeGuard

import numpy as np

from shaderlab.errors import CaseError, DriverError, ShaderError, UnsupportedError, suggest
from shaderlab.model.calls import Call, Location, Object, Program
from shaderlab.model.frame import Reply

from . import environment
from .device import GL, LIBRARIES, Device, GLError, NullFunctionError
from .drawing import drain_errors
from .linking import compile_shader, link_program


def prototype(name: str) -> Any:
    """Find a C function by its name, with its argument names and types. Raises CaseError."""
    if name not in prototypes():
        raise CaseError(f"OpenGL has no function {name!r}", remedy=suggest(name, prototypes()))
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
    known = vars(GL).items()
    return {n: int(v) for n, v in known if n.startswith("GL_") and isinstance(v, int)}


def constant(words: str) -> int:
    """Find the number of a constant, or of several joined by "|". Raises CaseError: OpenGL has no
    such constant.

    >>> hex(constant("GL_MAP_READ_BIT | GL_MAP_WRITE_BIT"))
    '0x3'
    """
    number = 0
    for word in (w.strip() for w in words.split("|")):
        if word not in constants():
            raise CaseError(f"OpenGL has no constant {word!r}", remedy=suggest(word, constants()))
        number |= constants()[word]
    return number


def name_of(number: int, like: str) -> str:
    """Find the name of a number that begins most like another name, or ""."""
    found = [name for name, value in constants().items() if value == number]

    def alike(name: str) -> tuple[int, int]:
        return len(os.path.commonprefix([name, like])), -len(name)  # noqa: RUF071 - these are words

    return max(found, key=alike, default="")


@contextmanager
def fresh_context(device: Device) -> Iterator[Any]:
    """Open a separate context (glcontext's), current for a while, which takes with it what was made
    in it. The device's is untouched, and current again afterwards."""
    import glcontext

    names = {"glversion": device.context.version_code, "mode": "standalone", **LIBRARIES}
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


Texts = Callable[[Program], Mapping[str, str]]
"""The stages' text of one of a case's programs, by stage."""

_ARRAYS: Mapping[str, type[np.generic]] = {
    "GLint": np.int32, "GLsizei": np.int32, "GLuint": np.uint32, "GLenum": np.uint32,
    "GLfloat": np.float32, "GLdouble": np.float64, "GLboolean": np.uint8, "GLubyte": np.uint8,
    "GLint64": np.int64, "GLuint64": np.uint64, "GLintptr": np.int64, "GLsizeiptr": np.int64,
    "GLchar": np.int8,
}  # fmt: skip
_READS_BYTES = ("glGetBufferSubData", "glGetTexImage", "glReadPixels")
_ROOM = 4096  # numbers that a call may write


def answer(
    device: Device, calls: Sequence[Call], returns: Sequence[int | float | str], texts: Texts
) -> Reply:
    """Make some calls in a separate context, up to the first that raises an error. Returns what the
    API answered to that one, or to the last; `returns` are the values expected of it. Raises
    CaseError: a function, a constant or an argument is none of OpenGL's; UnsupportedError: the
    driver has no such function."""
    wanted = tuple(constant(w) if _is_constant(w) else w for w in returns)
    *before, last = calls
    with fresh_context(device):
        maker = _Maker(texts)
        for step in before:
            maker.make(step, 0)
            errors = drain_errors()
            if errors:
                return Reply(errors=errors, at=str(step), wanted=wanted)
        returned = maker.make(last, len(wanted))
        errors = drain_errors()
    names: dict[int, str] = {}
    for word, *both in zip(returns, wanted, returned, strict=False):
        if _is_constant(word):
            names |= {int(n): name_of(int(n), word) for n in both}
    return Reply(errors=errors, at=str(last), wanted=wanted, returned=returned, names=names)


class _Maker:
    """Calls made one after the other, with the objects and programs that they name."""

    def __init__(self, texts: Texts) -> None:
        self._texts = texts
        self._objects: dict[Object, int] = {}
        self._programs: dict[Program, int] = {}

    def make(self, call: Call, returns: int) -> tuple[Any, ...]:
        """Make one call: the first `returns` values that it returned or wrote."""
        function = prototype(call.function)
        types = tuple(function.argtypes or ())
        kind = np.uint8 if call.function in _READS_BYTES else types and _element_type(types[-1])
        writes = len(call.arguments) == len(types) - 1 and bool(kind)
        if len(call.arguments) != len(types) and not writes:
            raise CaseError(
                f"{call}: {call.function} takes {len(types)} arguments",
                remedy=f"{call.function}({', '.join(function.argNames)})",
            )
        values = [self._resolve(call, a, t) for a, t in zip(call.arguments, types, strict=False)]
        room = np.zeros(_ROOM, kind) if writes else None
        if room is not None:
            values.append(room.ctypes.data_as(ctypes.c_void_p) if _is_address(types[-1]) else room)
        got = self._invoke(call, function, values)
        if room is not None:
            return tuple(room[:returns].tolist())
        got = got.decode(errors="replace") if isinstance(got, bytes) else got
        return (0 if got is None else got,) if function.restype is not None else ()

    def _invoke(self, call: Call, function: Any, values: Sequence[Any]) -> Any:
        try:
            return function(*values)
        except GLError as error:  # PyOpenGL's own check, of compiling and linking
            return error.result
        except NullFunctionError as error:
            raise UnsupportedError(f"{call.function}: this driver has no such function") from error
        except (ctypes.ArgumentError, TypeError, ValueError) as error:
            raise CaseError(
                f"{call}: {error}", remedy=f"{call.function}({', '.join(function.argNames)})"
            ) from error

    def _resolve(self, call: Call, argument: Any, kind: Any) -> Any:
        if isinstance(argument, Object):
            return self._object(argument)
        if isinstance(argument, Program):
            return self._program(argument)
        if isinstance(argument, Location):
            program = self._program(argument.program)
            GL.glUseProgram(program)
            return GL.glGetUniformLocation(program, argument.uniform.encode())
        if _is_constant(argument):
            return constant(argument)
        if isinstance(argument, tuple) and any(isinstance(each, Object) for each in argument):
            return np.array([self._resolve(call, each, kind) for each in argument], np.uint32)
        return _convert_argument(call, argument, kind)

    def _object(self, wanted: Object) -> int:
        if wanted.kind == "program":
            self._objects.setdefault(wanted, GL.glCreateProgram())
        elif wanted.kind.endswith("_shader"):
            kind = constant(f"GL_{wanted.kind.upper()}")
            self._objects.setdefault(wanted, GL.glCreateShader(kind))
        elif wanted not in self._objects:
            name = np.zeros(1, np.uint32)
            words = wanted.kind.title().replace("_", "")
            prototype(f"glGen{'Queries' if words == 'Query' else f'{words}s'}")(1, name)
            self._objects[wanted] = int(name[0])
        return self._objects[wanted]

    def _program(self, wanted: Program) -> int:
        if wanted not in self._programs:
            program = GL.glCreateProgram()
            self._programs[wanted] = program
            for stage, text in self._texts(wanted).items():
                compile_shader(program, stage, text)
            linked, log = link_program(program)
            if not linked:
                raise ShaderError(f"the driver refuses the {wanted}: {log!r}")
        return self._programs[wanted]


def _convert_argument(call: Call, argument: Any, kind: Any) -> Any:
    if isinstance(argument, int) and _is_address(kind):
        return ctypes.c_void_p(argument)  # an offset into the buffer that is bound
    if argument is None or isinstance(argument, bytes | int | float):
        return argument
    several = [argument] if isinstance(argument, str) else list(argument)
    if all(isinstance(word, str) for word in several):
        texts = [word.encode() for word in several]
        if "LP_LP" not in kind.__name__:
            return texts[0]
        return ctypes.cast((ctypes.c_char_p * len(texts))(*texts), kind)
    if _element_type(kind) is None:
        raise CaseError(f"{call}: {several} where no array is taken", remedy="bytes, or a number")
    return np.array(several, _element_type(kind))


def _is_address(kind: Any) -> bool:
    return bool(kind.__name__ == "c_void_p")


def _element_type(kind: Any) -> type[np.generic] | None:
    return _ARRAYS.get(kind.__name__.removesuffix("Array")) if "Array" in kind.__name__ else None


def _is_constant(word: Any) -> TypeGuard[str]:
    return isinstance(word, str) and word.startswith("GL_")
