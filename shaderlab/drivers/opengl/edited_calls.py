"""Makes the calls of a drawing, one of them otherwise than it was asked for."""

from __future__ import annotations

import ctypes
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from shaderlab.errors import ShaderlabError
from shaderlab.model.call_edits import CallEdit, Changed, Dropped, PutOff, Repeated

from .api import constant, prototypes
from .pyopengl import GL

Make = Callable[..., Any]
HeldCall = tuple[Make, tuple[Any, ...]]

VECTOR = re.compile(
    r"glUniform(?P<matrix>Matrix)?(?P<rows>\d)(?:x(?P<columns>\d))?(?P<kind>f|i|ui)v"
)
"""Functions that take the address of values, four bytes each."""
# Of functions that take the address of bytes: the places of the address and of their number.
_SIZED = {"glBufferData": (2, 1), "glBufferSubData": (3, 2)}
# What a call is about besides its arguments: how to ask for it, and how to set it.
_BINDINGS: Sequence[tuple[str, Callable[[int], None]]] = (
    ("GL_VERTEX_ARRAY_BINDING", lambda n: GL.glBindVertexArray(n)),
    ("GL_ARRAY_BUFFER_BINDING", lambda n: GL.glBindBuffer(GL.GL_ARRAY_BUFFER, n)),
    ("GL_UNIFORM_BUFFER_BINDING", lambda n: GL.glBindBuffer(GL.GL_UNIFORM_BUFFER, n)),
    ("GL_CURRENT_PROGRAM", lambda n: GL.glUseProgram(n)),
)


class Editor:
    """Counts calls, and makes the one that an edit is about in its own way.

    Args:
        edit: what becomes of which call; None for nothing.
    """

    def __init__(self, edit: CallEdit | None) -> None:
        self._edit = edit
        self._counts: Counter[str] = Counter()
        self._made = edit is None
        self._held: HeldCall | None = None
        self._again: tuple[str, HeldCall, list[int]] | None = None

    def make(self, name: str, arguments: tuple[Any, ...], made: Make, pass_name: str) -> Any:
        """Make a call by `made`, or what becomes of it; gives what the caller gets for it.

        Args:
            name: the C name.
            arguments: what it is called with.
            made: makes and records the call.
            pass_name: the pass that it is made for.
        """
        number = self._counts[name]
        self._counts[name] += 1
        edit = self._edit
        if edit is not None and (edit.function, edit.number) == (name, number):
            self._made = True
            return self._edited(edit, arguments, made, pass_name)
        if self._again is not None and name.startswith("glDraw") and name != "glDrawBuffers":
            self._repeat(pass_name)
        returned = made(*arguments)
        if self._held is not None and isinstance(edit, PutOff) and edit.behind == (name, number):
            (later, given), self._held = self._held, None
            later(*given)
        return returned

    def require_made(self) -> None:
        """Raise ShaderlabError if the call did not come."""
        if not self._made and self._edit is not None:
            raise ShaderlabError(
                f"the drawing has no call {self._edit.number} of {self._edit.function}",
                remedy="this is a defect of shaderlab: a drawing takes the same calls each time",
            )

    def _edited(
        self, edit: CallEdit, arguments: tuple[Any, ...], made: Make, pass_name: str
    ) -> Any:
        name = edit.function
        if isinstance(edit, Changed):
            place = list(prototypes()[name].argNames).index(edit.parameter)
            new: Any = constant(edit.value) if isinstance(edit.value, str) else edit.value
            if isinstance(arguments[place], ctypes.c_void_p):
                new = ctypes.c_void_p(new)
            return made(*arguments[:place], new, *arguments[place + 1 :])
        if isinstance(edit, Repeated):
            self._again = (pass_name, (made, _kept(name, arguments)), _bound())
            return made(*arguments)
        if isinstance(edit, PutOff):
            self._held = (made, _kept(name, arguments))
        else:
            assert isinstance(edit, Dropped)
        return None if prototypes()[name].restype is None else 0

    def _repeat(self, pass_name: str) -> None:
        assert self._again is not None
        first, (made, arguments), bindings = self._again
        if pass_name == first:
            with _binding(bindings):
                made(*arguments)


@contextmanager
def _binding(bindings: list[int]) -> Iterator[None]:
    """These bindings for a while."""
    before = _bound()
    for (_, bind), number in zip(_BINDINGS, bindings, strict=True):
        bind(number)
    try:
        yield
    finally:
        for (_, bind), number in zip(_BINDINGS, before, strict=True):
            bind(number)


def _bound() -> list[int]:
    return [int(GL.glGetIntegerv(getattr(GL, name))) for name, _ in _BINDINGS]


class _Address(int):
    """The address of memory that lives as long as this number."""

    memory: Any = None


def _kept(name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """Arguments that are good after the call too: of contents that an address leads to, a copy."""
    place, size = len(arguments) - 1, 0
    if name in _SIZED:
        place, from_place = _SIZED[name]
        size = arguments[from_place]
    elif VECTOR.fullmatch(name):
        size = 4 * numbers_of(name, arguments[1])
    address = arguments[place] if arguments else None
    if not size or not isinstance(address, int) or not address:
        return arguments
    memory = ctypes.create_string_buffer(ctypes.string_at(address, size), size)
    copied = _Address(ctypes.addressof(memory))
    copied.memory = memory
    return (*arguments[:place], copied, *arguments[place + 1 :])


def numbers_of(name: str, count: int) -> int:
    """How many numbers a glUniform…v function takes for so many elements."""
    found = VECTOR.fullmatch(name)
    assert found is not None
    rows = int(found["rows"])
    return count * rows * int(found["columns"] or (rows if found["matrix"] else 1))
