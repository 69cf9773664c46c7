"""Tells files of tests that load GLSL from other Python files, without importing them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from shaderlab.engine.discovery import files_below

_NAME = re.compile(r"test_.*\.py|.*_test\.py")
_LOADS = re.compile(rb"\bshaderlab\b.*\bglsl\b", re.DOTALL)
_TESTS = re.compile(rb"^\s*(?:async\s+)?def test", re.MULTILINE)


def is_function_test(path: Path) -> bool:
    """Whether pytest would run tests of a file that uses `shaderlab.glsl`; never raises."""
    if not _NAME.fullmatch(path.name):
        return False
    try:
        text = path.read_bytes()
    except OSError:
        return False
    return bool(_LOADS.search(text) and _TESTS.search(text))


def function_tests(folder: Path) -> Iterator[Path]:
    """The files of such tests below a folder, sorted. Raises UsageError."""
    return filter(is_function_test, files_below(folder))
