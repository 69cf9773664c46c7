"""The local variables of a reference while it runs, by name, to hold a shader's against."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from shaderlab.judging.inputs import Inputs, evaluate

_LAB = str(Path(__file__).parents[1])
_FORMULAS = str(Path(_LAB) / "reference")


def compared(name: str) -> str:
    """A name as shaders and references are compared by it: `lightDir` is `light_dir`.

    >>> compared("lightDir") == compared("light_dir")
    True
    """
    return name.replace("_", "").lower()


def reference_locals(
    reference: Callable[..., Any], inputs: Inputs
) -> tuple[Mapping[str, list[Any]], Any]:
    """What the functions of a reference, and those that it calls, assign and return, in float64.

    Returns:
        Values by `compared` name, those of a function's result by "name()"; and the reference's
        own result. Its parameters are left out: they are what the shader gets.

    Raises:
        FormulaError: the reference fails.
    """
    found: dict[str, list[Any]] = {}

    def note(frame: FrameType, event: str, result: Any) -> None:
        code = frame.f_code
        if event != "return" or not _is_formula(code.co_filename):
            return
        given = set(code.co_varnames[: code.co_argcount + code.co_kwonlyargcount])
        for name, value in frame.f_locals.items():
            if name not in given and _is_number(value):
                found.setdefault(compared(name), []).append(value)
        if _is_number(result):
            found.setdefault(compared(code.co_name) + "()", []).append(result)

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        result = evaluate(reference, inputs, rules=None, decimal=False)
    finally:
        sys.setprofile(before)
    return found, result


def _is_formula(file: str) -> bool:
    """Whether a file is a case's or holds formulas of the lab: neither Python's nor NumPy's, nor
    the lab's other files."""
    if file.startswith("<") or "site-packages" in file:
        return False
    return not file.startswith((_LAB, sys.base_prefix)) or file.startswith(_FORMULAS)


def _is_number(value: Any) -> bool:
    return isinstance(value, float | int | np.ndarray) and not isinstance(value, bool)
