"""A formula's text is that which `inspect` finds, found without splitting its file into words."""

from __future__ import annotations

import functools
import inspect
from importlib import import_module
from pkgutil import iter_modules
from types import FunctionType
from typing import Any

import pytest

from shaderlab import reference
from shaderlab.engine.judging.formats import _lines_of, source_of


def of_one_line(x: Any) -> Any: return x  # fmt: skip


def that_ends_in_a_bracket(x: Any) -> Any:
    return (
        x
    )  # fmt: skip


def that_ends_in_a_comment(x: Any) -> Any:
    return x
    # all of it


def that_ends_in_a_text(x: Any) -> Any:
    return x
    """
the end
"""


def that_ends_in_another(x: Any) -> Any:
    def inner(y: Any) -> Any:
        return y + 1

    return [inner(y) for y in x]


@functools.cache
def with_a_decorator(x: Any) -> Any:
    return x


# A comment of its own.
HERE = [f for f in globals().values() if isinstance(f, FunctionType)]


def of_the_lab() -> list[FunctionType]:
    names = [f"{reference.__name__}.{found.name}" for found in iter_modules(reference.__path__)]
    values = [value for name in names for value in vars(import_module(name)).values()]
    return [value for value in dict.fromkeys(filter(inspect.isfunction, values))]


@pytest.mark.parametrize("function", HERE, ids=lambda f: f.__name__)
def test_a_functions_text_is_all_of_it(function: FunctionType) -> None:
    lines, line = inspect.getsourcelines(function)
    assert (source_of(function).text, source_of(function).line) == ("".join(lines), line)


def test_most_texts_are_found_by_where_the_code_ends() -> None:
    found = {function: _lines_of(function) for function in of_the_lab()}
    for function, lines in found.items():
        assert lines in (None, inspect.getsourcelines(function)), function.__qualname__
    assert sum(lines is not None for lines in found.values()) > 0.9 * len(found)
