"""Where Python looks for modules: its own come before a user's, so that a random.py or a copy.py of
a project is not taken for one of them."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

_STANDARD_LIBRARY = os.path.dirname(os.__file__)


def pythons_first(path: Sequence[str]) -> list[str]:
    """A search path like `sys.path`, as absolute folders, that begins with Python's own."""
    folders = [os.path.abspath(entry) if entry else os.getcwd() for entry in path]
    return sorted(folders, key=lambda folder: not _is_pythons(folder))  # stable


@contextmanager
def searched(folder: str) -> Iterator[None]:
    """Look for modules in `folder` too: after Python's own, before installed packages."""
    entry = folder + os.sep  # another object than an equal entry that stays
    first = (sys.path.index(known) for known in set(filter(_is_pythons, sys.path)))
    sys.path.insert(max(first, default=-1) + 1, entry)
    try:
        yield
    finally:
        sys.path.remove(entry)


@functools.lru_cache(256)
def _is_pythons(folder: str) -> bool:
    name = os.path.basename(folder)
    return (
        folder == _STANDARD_LIBRARY
        or (name == "lib-dynload" and os.path.dirname(folder) == _STANDARD_LIBRARY)
        or name == f"python{sys.version_info.major}{sys.version_info.minor}.zip"
    )
