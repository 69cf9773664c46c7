"""Sessions of pytest that tests start."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from shaderlab.model.options import CALL_LIMITS, Limits


class Imports:
    """A plugin that notes what a session has imported, its own cases and tests apart."""

    def __init__(self) -> None:
        self.found: dict[str, ModuleType] = {}
        self.own = Path()

    def pytest_unconfigure(self) -> None:
        for name, module in sys.modules.items():
            file = getattr(module, "__file__", None)
            if file and not Path(file).is_relative_to(self.own):
                self.found[name] = module


@pytest.fixture
def imports() -> Iterator[Imports]:
    """What sessions in this process import stays imported, which pytest's own fixture would undo:
    of a module that is imported again there would be two of each class."""
    made = Imports()
    yield made
    sys.modules.update(made.found)


@pytest.fixture
def pytester(
    imports: Imports, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> Iterator[pytest.Pytester]:
    """pytest's own, whose sessions leave out Hypothesis: its import takes longer than they do.
    Those in this process leave it its limits."""
    monkeypatch.setenv("PYTEST_ADDOPTS", "-p no:hypothesispytest")
    imports.own, run = pytester.path.parent, pytester.runpytest_inprocess

    def session(*args: Any) -> pytest.RunResult:
        try:
            return run(*args, plugins=[imports])
        finally:
            sys.modules.update(imports.found)

    monkeypatch.setattr(pytester, "runpytest_inprocess", session)
    limits = CALL_LIMITS.set(CALL_LIMITS.get(Limits()))
    yield pytester
    CALL_LIMITS.reset(limits)
