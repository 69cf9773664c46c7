"""Telling case files from other Python files, without importing any of them.

A folder of cases may lie inside someone's larger project, so files are read, not run: a case
file is one that takes `Case` from shaderlab and assigns `case = Case(...)` at its top level.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from shaderlab.errors import UsageError

_ASSIGNS = re.compile(rb"^case\s*(:[^=\n]*)?=", re.MULTILINE)
_SKIPPED_FOLDERS = frozenset({"__pycache__", "node_modules", "site-packages", "build", "dist"})


def is_case_file(path: Path) -> bool:
    """Whether `path` is a case file; never raises, whatever the file holds."""
    if path.suffix != ".py" or not _may_be_case(path.name):
        return False
    try:
        source = path.read_bytes()
    except OSError:
        return False
    if b"shaderlab" not in source or not _ASSIGNS.search(source):
        return False
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return True  # meant as one: loading it reports the mistake, passing it over would not
    return _imports_case(tree) and any(_assigns_case(node) for node in tree.body)


def case_files(folder: Path) -> Iterator[Path]:
    """All case files below `folder`, sorted; hidden folders and build products are passed over.

    Raises:
        UsageError: `folder` is not a folder that can be read.
    """
    try:
        entries = sorted(folder.iterdir())
    except OSError as error:
        raise UsageError(f"can't read this folder: {error.strerror}", file=folder) from error
    for entry in entries:
        if entry.is_dir():
            if not entry.name.startswith(".") and entry.name not in _SKIPPED_FOLDERS:
                yield from case_files(entry)
        elif is_case_file(entry):
            yield entry


def _may_be_case(name: str) -> bool:
    return not (name.startswith(("test_", "_")) or name.endswith("_test.py")) and name not in (
        "conftest.py",
        "setup.py",
    )


def _imports_case(tree: ast.Module) -> bool:
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "shaderlab":
            return True
        if isinstance(node, ast.Import) and any(
            alias.name.split(".")[0] == "shaderlab" for alias in node.names
        ):
            return True
    return False


def _assigns_case(node: ast.stmt) -> bool:
    if isinstance(node, ast.Assign):
        targets: list[ast.expr] = node.targets
    elif isinstance(node, ast.AnnAssign):
        targets = [node.target]
    else:
        return False
    named = any(isinstance(target, ast.Name) and target.id == "case" for target in targets)
    if not named or not isinstance(node.value, ast.Call):
        return False
    called = node.value.func
    return (isinstance(called, ast.Name) and called.id == "Case") or (
        isinstance(called, ast.Attribute) and called.attr == "Case"
    )
