"""Values of every GLSL type: made, taken apart, changed in parts, chosen between.

A float is an arithmetic's, an integer an `Integer`, a condition a `Truth`, each shaped
(count or 1, components); a matrix is (count or 1, rows, columns); structs and arrays are tuples;
samplers are `Texels`. None is what nothing was stored to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab import glslmath
from shaderlab.bands import Band, Integer, Truth
from shaderlab.bands.exact import concatenated, joined, select as select_bands
from shaderlab.errors import FormulaError

from .arithmetic import Arithmetic, Floats
from .types import Type

Value = Any


@dataclass(frozen=True)
class Missing:
    """A part of the program's interface for which nothing was given."""

    name: str


class NotGivenError(FormulaError):
    """Something is read for which nothing was given."""

    @classmethod
    def of(cls, missing: Missing) -> NotGivenError:
        """The error about this input."""
        return cls(f"nothing is given for {missing.name!r}")


class UnchoosableError(Exception):
    """Two samplers, of which an invocation may mean either."""


def undefined(type_: Type, arithmetic: Arithmetic) -> Value:
    """What a variable holds before anything is stored: any float, 0 and false of other types."""
    return _filled(type_, arithmetic, arithmetic.undefined())


def null(type_: Type, arithmetic: Arithmetic) -> Value:
    """Zero, false, or a composite of those."""
    return _filled(type_, arithmetic, arithmetic.exact(np.zeros((1, 1))))


def _filled(type_: Type, arithmetic: Arithmetic, number: Floats) -> Value:
    """A value of a type all of whose floats are this one."""
    if type_.kind == "struct":
        return tuple(_filled(member, arithmetic, number) for _, member in type_.members)
    if type_.of is not None:
        return composed(type_, [_filled(type_.of, arithmetic, number)] * type_.count)
    if type_.kind == "int":
        return Integer(np.zeros((1, 1)), unsigned=not type_.signed, rules=arithmetic.rules)
    return number if type_.kind == "float" else Truth.known(np.zeros((1, 1), np.bool_))


def composed(type_: Type, parts: Sequence[Value]) -> Value:
    """A value of a type out of its parts; a vector's may be vectors themselves."""
    if type_.kind in ("array", "struct"):
        return tuple(parts)
    if type_.kind == "matrix":
        return _stacked([part[..., :, None] for part in parts])
    return parts[0] if len(parts) == 1 else _stacked(parts)


def _stacked(parts: Sequence[Value]) -> Value:
    first = parts[0]
    if isinstance(first, Band):
        return joined(parts, -1)
    if isinstance(first, Integer):
        size = sum(part.shape[-1] for part in parts)
        vector = getattr(glslmath, f"{'u' if first.unsigned else 'i'}vec{size}")
        return vector(*parts)
    if isinstance(first, Truth):
        yes, no = (
            concatenated([getattr(part, side) for part in parts], -1)
            for side in ("all_true", "all_false")
        )
        return Truth(yes, no, next((part.rules for part in parts if part.rules), None))
    return concatenated(parts, -1)


def component(value: Value, index: int) -> Value:
    """A vector's component, a matrix' column, an array's element, a struct's member."""
    if isinstance(value, tuple):
        return value[index]
    return value[..., index] if value.ndim == 3 else value[..., index : index + 1]


def select(condition: Truth, a: Value, b: Value) -> Value:
    """a where the condition (count or 1, components or 1) holds, else b; the hull of both where it
    is undecided. Where nothing was stored to one of them, the other.

    Raises:
        UnchoosableError: they are different samplers.
    """
    if a is b or b is None:
        return a
    if a is None:
        return b
    if isinstance(a, Missing) or isinstance(b, Missing):
        return a if isinstance(a, Missing) else b  # only reading it is an error
    if isinstance(a, tuple) and isinstance(b, tuple):
        return tuple(select(condition, x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, Truth):
        return _either(condition, a, b)
    if isinstance(a, Integer):
        return glslmath.where(condition, a, b)
    if not isinstance(a, Band | np.ndarray):
        if a == b:
            return a
        raise UnchoosableError
    if a.ndim == 3 and condition.ndim == 2:
        condition = condition[..., None]
    if isinstance(a, Band):
        return select_bands(condition, a, b)
    return np.where(condition.all_true, a, b)


def _either(condition: Truth, a: Truth, b: Truth) -> Truth:
    yes, no = condition.all_true, condition.all_false

    def known(of_a: Any, of_b: Any) -> Any:
        return (yes & of_a) | (no & of_b) | (of_a & of_b)

    sides = (known(a.all_true, b.all_true), known(a.all_false, b.all_false))
    return Truth(*sides, a.rules or b.rules or condition.rules)


def broadcast(value: Value, count: int) -> Value:
    """The value with as many rows as there are invocations."""
    if isinstance(value, tuple):
        return tuple(broadcast(part, count) for part in value)
    if value.shape[0] == count:
        return value
    rows = np.zeros(count, np.int64)
    return value[rows]
