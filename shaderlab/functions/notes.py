"""What a test finds of GLSL functions, noted for its record."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field

from shaderlab.compiler.sources import Source
from shaderlab.model.records import Outcome, SourceText


@dataclass
class Notes:
    """What one test did: the outcomes of its checks, and the functions that it called.

    Attributes:
        outcomes: in the order in which they were judged.
        called: the definition of each function that was called, by file and line.
        sources: the files of these functions.
    """

    outcomes: list[Outcome] = field(default_factory=list)
    called: dict[tuple[str, int], SourceText] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.outcomes or self.called)

    def add_call(self, source: Source, definition: SourceText) -> None:
        """A function of a file was called."""
        self.called.setdefault((definition.file, definition.line), definition)
        self.sources.setdefault(source.path, source)


_NOTES: ContextVar[Notes | None] = ContextVar("_NOTES", default=None)


def notes() -> Notes | None:
    """The notes of the test that runs; None where nobody wants any."""
    return _NOTES.get()


@contextmanager
def noted() -> Iterator[Notes]:
    """Notes of what the block does."""
    found = Notes()
    token = _NOTES.set(found)
    try:
        yield found
    finally:
        _NOTES.reset(token)
