"""The float constants of a function's code."""

from __future__ import annotations

import dis
import inspect
import linecache
import re
from collections.abc import Callable, Iterable
from types import CodeType
from typing import Any

from shaderlab.bands import Literal

_LOADS_CONSTANT = dis.opmap["LOAD_CONST"]
_NUMBER = re.compile(rb"[\d._]+([eE][+-]?[\d_]+)?")


def with_literals(code: CodeType, literal: Callable[[float], Literal]) -> CodeType | None:
    """A function's code with literals for its float constants, where each stands in the source as
    it is, so that Python has folded none: then the source need not be parsed. None elsewhere."""
    if not has_floats(code.co_consts) or len(code.co_consts) > 256:
        return None
    lines = linecache.getlines(code.co_filename)
    spelt = set()
    steps = zip(code.co_code[::2], code.co_code[1::2], code.co_positions(), strict=True)
    for step, number, (line, last, start, end) in steps:
        if step != _LOADS_CONSTANT or type(value := code.co_consts[number]) is not float:
            continue
        if not line or line != last or line > len(lines):
            return None
        text = lines[line - 1].encode()[start:end]
        # Patterns of `match` take no literals.
        if not _NUMBER.fullmatch(text) or float(text) != value or "case" in lines[line - 1]:
            return None
        spelt.add(number)
    made: list[Any] = []
    for number, value in enumerate(code.co_consts):
        if number in spelt and repr(value)[0].isdigit():
            made.append(literal(value))
        elif inspect.iscode(value) and has_floats(value.co_consts):
            inner = with_literals(value, literal)
            if inner is None:
                return None
            made.append(inner)
        elif has_floats((value,)):
            return None
        else:
            made.append(value)
    return code.replace(co_consts=tuple(made))


def has_floats(constants: Iterable[Any]) -> bool:
    """Whether a float is among constants, or inside of one: Python folds none away altogether."""
    for constant in constants:
        if isinstance(constant, float | complex):
            return True
        inside = constant.co_consts if inspect.iscode(constant) else constant
        if isinstance(inside, tuple | frozenset) and has_floats(inside):
            return True
    return False
