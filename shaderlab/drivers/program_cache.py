"""Programs made on a device once each; the most recently used ones are kept."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Generic, Protocol, Self, TypeVar

CAPACITY = 16


class Releasable(Protocol):
    """What holds memory of a device."""

    def release(self) -> None: ...


Program = TypeVar("Program", bound=Releasable)


class ProgramCache(Generic[Program]):
    """Programs by what they are made of, so that equal ones are made once.

    The `CAPACITY` most recently used ones are kept: a software driver's machine code takes a
    megabyte. A program is used before the next one is asked for.
    """

    def __init__(self, device: Any, first: Self | None = None) -> None:
        """`first` is another cache, whose programs are used where it has them, and which is left
        as it is."""
        self.device = device
        self._first = first
        self._made: dict[Hashable, Program] = {}

    def get(self, key: Hashable, make: Callable[[], Program]) -> Program:
        """The program of this key; it is made now if there is none."""
        program = self._made.pop(key, None)
        if program is None and self._first is not None and key in self._first._made:
            return self._first._made[key]
        if program is None:
            program = make()
        self._made[key] = program
        if len(self._made) > CAPACITY:
            self.drop(self._made.pop(next(iter(self._made))))
        return program

    def release(self) -> None:
        """Release all programs."""
        while self._made:
            self.drop(self._made.popitem()[1])

    def drop(self, program: Program) -> None:
        """Release a program that is kept no longer."""
        program.release()
