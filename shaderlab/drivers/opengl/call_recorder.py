"""A context whose calls of OpenGL are written down: moderngl's, and those made through PyOpenGL.

moderngl asks its context for each function's address, and gets one that writes the call down and
passes it on. PyOpenGL's functions are replaced while calls are recorded, and put back. What is
written down is what the driver gets: an edit of one call (`edited_calls`) comes before that.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np

from shaderlab.model.call_edits import CallEdit

from .api import prototypes
from .edited_calls import VECTOR, Editor, numbers_of
from .pyopengl import GL, GL_1_0, GL_1_2, GL_1_3

_NUMBERS: Mapping[str, Any] = {"f": ctypes.c_float, "i": ctypes.c_int, "ui": ctypes.c_uint}
# What only asks, or waits: it changes nothing that is drawn.
_SILENT = ("glGet", "glIs", "glCheck", "glFinish", "glFlush", "glReadPixels", "glReadBuffer")


Place = tuple[str, int | None]
"""A pass, and a draw of it; None for its target."""


@dataclass(frozen=True)
class Recorded:
    """One call: its place as `CallRecorder.place` was then, the C name, the arguments as they were
    passed, and what was returned."""

    place: Place | None
    function: str
    arguments: tuple[Any, ...]
    returned: Any


class CallRecorder:
    """Stands for a context of glcontext when moderngl asks for one.

    Args:
        context: the real one.
        edit: a call that is made otherwise while calls are recorded.

    Attributes:
        calls: what was recorded.
        place: the pass and the draw that calls are made for; None for the lab's own reading.
    """

    def __init__(self, context: Any, edit: CallEdit | None = None) -> None:
        self.calls: list[Recorded] = []
        self.place: Place | None = ("", None)
        self._context = context
        self._edit = edit
        self._editor = Editor(edit)

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Record what is called meanwhile, in place of what was recorded before.

        Raises:
            ShaderlabError: the call of the edit was not made.
        """
        self.calls.clear()
        self._editor = Editor(self._edit)
        own = {(module, name): getattr(module, name) for module, name in _imported()}
        for (module, name), function in own.items():
            setattr(module, name, _recorded(name, function))
        _RECORDING.append(self)
        try:
            yield
        finally:
            _RECORDING.remove(self)
            for (module, name), function in own.items():
                setattr(module, name, function)
        self._editor.require_made()

    def load_opengl_function(self, name: str) -> int:
        """The address of a function that records its calls; 0 where the driver has none."""
        address = int(self._context.load_opengl_function(name) or 0)
        known = prototypes().get(name)
        if not address or known is None or _is_silent(name):
            return address
        return int(ctypes.cast(_callback(name, address), ctypes.c_void_p).value or 0)

    def __enter__(self) -> Any:
        return self._context.__enter__()

    def __exit__(self, *error: object) -> Any:
        return self._context.__exit__(*error)

    def release(self) -> None:
        """Give the context back."""
        self._context.release()

    def make(self, name: str, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        """Make a call, or what the edit makes of it, and record it; returns what it returned."""

        def made(*arguments: Any) -> Any:
            returned = function(*arguments)
            kept, came = arguments, returned
            if name.startswith(("glGen", "glDrawBuffers")) and _has_address(arguments):
                numbers = list((ctypes.c_uint * arguments[0]).from_address(arguments[1]))
                kept, came = (arguments[0], numbers), numbers
            elif name.startswith("glUniform"):
                kept = _with_values(name, arguments)
            self.calls.append(Recorded(self.place, name, kept, came))
            return returned

        if self.place is None:
            return made(*arguments)
        return self._editor.make(name, arguments, made, self.place[0])


@cache
def _imported() -> Sequence[tuple[ModuleType, str]]:
    """The functions to record, in the modules from which the lab imports them."""
    return [
        (module, name)
        for module in (GL, GL_1_0, GL_1_2, GL_1_3)
        for name in prototypes()
        if hasattr(module, name) and not _is_silent(name)
    ]


_RECORDING: list[CallRecorder] = []
"""The recorders that are recording; the last one gets the calls."""


@cache
def _callback(name: str, address: int) -> Any:
    """A function that passes calls on to the one at `address`, and has them recorded while a
    recorder is recording. It stays for good: contexts have its address only, and a driver gives
    each context the same functions."""
    known = prototypes()[name]
    kind = ctypes.CFUNCTYPE(_plain(known.restype), *map(_plain, known.argtypes or ()))
    return kind(_recorded(name, kind(address)))


def _recorded(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def recorded(*arguments: Any) -> Any:
        if not _RECORDING:
            return function(*arguments)
        return _RECORDING[-1].make(name, function, arguments)

    return recorded


def _is_silent(name: str) -> bool:
    return name.startswith(_SILENT)


def _has_address(arguments: tuple[Any, ...]) -> bool:
    """Whether these are a count and an address, as of a caller in C; one in Python has arrays."""
    return len(arguments) == 2 and isinstance(arguments[1], int)


def _with_values(name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """The arguments of a glUniform…v function with the values themselves for their address."""
    found = VECTOR.fullmatch(name)
    if found is None or not isinstance(arguments[-1], int):
        return arguments
    count = numbers_of(name, arguments[1])
    values = (_NUMBERS[found["kind"]] * count).from_address(arguments[-1])
    return (*arguments[:-1], np.array(values))


def _plain(kind: Any) -> Any:
    """A C type as callbacks take it: pointers of any kind are addresses."""
    if kind is None:
        return None
    simple = isinstance(kind, type) and issubclass(kind, ctypes._SimpleCData)
    return kind if simple and kind is not ctypes.c_char_p else ctypes.c_void_p
