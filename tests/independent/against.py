"""What each formula of `shaderlab.reference` is held against that is not written by the lab's hand
twice: another library, another derivation, a printed table.

`docs/guide/reference.md` lists what is said here, and a test asks for something of each formula.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Any, TypeVar

Test = TypeVar("Test", bound=Callable[..., Any])

SOURCES: dict[tuple[str, str], list[str]] = {}
"""What a formula, by its module and name, is held against."""


def against(source: str, *formulas: Any) -> Callable[[Test], Test]:
    """Marks a test that holds formulas against `source`."""
    for formula in formulas:
        assert isinstance(formula, FunctionType), formula
        SOURCES.setdefault((formula.__module__, formula.__name__), []).append(source)

    def same(test: Test) -> Test:
        return test

    return same
