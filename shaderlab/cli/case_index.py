"""What the shipped cases are, kept from one command to the next: to import them all takes a second.

What is kept holds for these very files: the contents of all Python files of the course, and the
lab's own files as they are.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

from shaderlab.engine.discovery import place
from shaderlab.files import cache_root, read_regular, write_bytes
from shaderlab.workers.jobs import CaseFacts

KEPT = ("id", "section", "title", "variants", "file")
"""What is kept of each case's facts."""


def kept_facts(course: Path, load: Callable[[], list[CaseFacts]]) -> list[CaseFacts]:
    """The facts of the course's cases, without those on formulas and parameters.

    Args:
        course: the folder that holds all of its Python files.
        load: imports the cases; what it gives is kept where all of them could be.

    Returns:
        the facts, by chapter, section and id.
    """
    root = cache_root()
    if root is None:
        return _in_order(load())
    name = hashlib.blake2b(os.fsencode(course), digest_size=8).hexdigest()
    file, key = root / f"cases-{name}.json", _key(course)
    with suppress(OSError, ValueError, TypeError, KeyError):
        kept = json.loads(read_regular(file))
        if kept["key"] == key:
            return [
                CaseFacts(**{**each, "variants": tuple(each["variants"])}) for each in kept["cases"]
            ]
    found = _in_order(load())
    if any(each.error is not None for each in found):
        return found
    cases = [{name: getattr(each, name) for name in KEPT} for each in found]
    with suppress(OSError):  # a folder that can't be written to
        root.mkdir(parents=True, exist_ok=True)
        write_bytes(file, json.dumps({"key": key, "cases": cases}).encode())
    return found


def _in_order(found: list[CaseFacts]) -> list[CaseFacts]:
    return sorted(found, key=lambda case: place(case.section, case.id))


def _key(course: Path) -> str:
    """A digest of all that the facts depend on."""
    digest = hashlib.blake2b(f"{sys.version} {course}".encode(errors="surrogateescape"))
    for entry in _sources(str(course)):
        with open(entry.path, "rb") as file:
            text = file.read()
        digest.update(f"{entry.path} {len(text)} ".encode(errors="surrogateescape"))
        digest.update(text)
    for entry in _sources(str(Path(__file__).parent.parent)):
        known = entry.stat()
        place = f"{entry.path} {known.st_size} {known.st_mtime_ns} "
        digest.update(place.encode(errors="surrogateescape"))
    return digest.hexdigest()


def _sources(folder: str) -> Iterator[os.DirEntry[str]]:
    """A folder's files of Python and TOML, those of its folders included, in a fixed order."""
    for entry in sorted(os.scandir(folder), key=lambda each: each.name):
        if entry.is_dir(follow_symlinks=False) and entry.name != "__pycache__":
            yield from _sources(entry.path)
        elif entry.name.endswith((".py", ".toml")):
            yield entry
