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
# What cases share is tried by the cases; where it states formulas, as the library's are.
FORMULAS = [
    name
    for name in MODULES
    if name.startswith("shaderlab.reference.")
    or (name.startswith("cases.") and "Source" in (importlib.import_module(name).__doc__ or ""))
]


def tried(name: str) -> doctest.TestResults:
    # colour-science, once imported, changes how NumPy prints.
    with np.printoptions(legacy=False):
        return doctest.testmod(importlib.import_module(name), extraglobs={"np": np})


@pytest.mark.parametrize("name", MODULES)
def test_worked_values(name: str) -> None:
    assert tried(name).failed == 0


def test_there_are_worked_values() -> None:
    """An import gone wrong must not leave nothing to check."""
    expected = {*FORMULAS, *(name for name in MODULES if name.startswith("shaderlab."))}
    assert {name for name in expected if tried(name).attempted == 0} == set()


@pytest.mark.parametrize("name", FORMULAS)
def test_every_formula_has_a_worked_value(name: str) -> None:
    module = importlib.import_module(name)
    without = [
        member
        for member, function in inspect.getmembers(module, inspect.isfunction)
        if function.__module__ == name
        and not member.startswith("_")
        and ">>>" not in (function.__doc__ or "")
    ]
    assert without == []


@pytest.mark.parametrize("name", [name for name in FORMULAS if name.startswith("shaderlab.")])
def test_every_formula_says_where_it_is_from(name: str) -> None:
    assert "Source" in (importlib.import_module(name).__doc__ or "")
