"""Every worked value in the formulas' and the assets' docstrings is what Python really gives."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil

import numpy as np
import pytest

import cases.scenes
import shaderlab.assets
import shaderlab.reference

MODULES = [
    module.name
    for package in (shaderlab.reference, shaderlab.assets, cases.scenes)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
]


@pytest.mark.parametrize("name", MODULES)
def test_worked_values(name: str) -> None:
    # Whoever imported colour-science before has changed how NumPy prints.
    with np.printoptions(legacy=False):
        result = doctest.testmod(importlib.import_module(name))
    assert result.failed == 0


def test_there_are_worked_values() -> None:
    """An import gone wrong must not leave nothing to check."""
    tried = {name: doctest.testmod(importlib.import_module(name)).attempted for name in MODULES}
    without = {name for name, number in tried.items() if number == 0}
    assert without == set()


@pytest.mark.parametrize("name", MODULES)
def test_every_formula_has_a_worked_value(name: str) -> None:
    module = importlib.import_module(name)
    without = [
        member
        for member, function in inspect.getmembers(module, inspect.isfunction)
        if name.startswith("shaderlab.reference.")
        and function.__module__ == name
        and not member.startswith("_")
        and ">>>" not in (function.__doc__ or "")
    ]
    assert without == []


@pytest.mark.parametrize(
    "name", [name for name in MODULES if name.startswith("shaderlab.reference.")]
)
def test_every_formula_says_where_it_is_from(name: str) -> None:
    assert "Source" in (importlib.import_module(name).__doc__ or "")
