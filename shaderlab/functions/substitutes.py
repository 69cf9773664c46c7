"""GLSL that is loaded, noted; and other texts taken in its place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace

from shaderlab.compiler.sources import Source


@dataclass
class Loads:
    """What was loaded.

    Attributes:
        texts: what to take in place of a text, includes expanded.
        sources: what was loaded, as its author wrote it, by that text.
        used: the names of the functions that were asked for, by that text.
        called_outside: the paths of sources whose functions are called outside of tests.
    """

    texts: Mapping[str, str] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)
    used: dict[str, set[str]] = field(default_factory=dict)
    called_outside: set[str] = field(default_factory=set)

    def take(self, source: Source) -> Source:
        """What to load for a source."""
        self.sources.setdefault(source.text, source)
        text = self.texts.get(source.text)
        return source if text is None else replace(source, text=text, stripped=None)

    def use(self, source: Source, name: str) -> None:
        """A function of a source was asked for."""
        self.used.setdefault(source.text, set()).add(name)


_LOADS: ContextVar[Loads | None] = ContextVar("_LOADS", default=None)


def loads() -> Loads | None:
    """What notes and replaces what is loaded; None for nothing."""
    return _LOADS.get()


@contextmanager
def loading(texts: Mapping[str, str]) -> Iterator[Loads]:
    """Take these texts in place of others, and note what is loaded."""
    found = Loads(texts)
    token = _LOADS.set(found)
    try:
        yield found
    finally:
        _LOADS.reset(token)
