"""GLSL's arrays (GLSL 4.60, 5.7): elements by an index that may differ from value to value."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer
from shaderlab.errors import FormulaError
from shaderlab.glslmath.choice import equal, where
from shaderlab.glslmath.dispatch import Value, undefined


class Elements(list[Any]):
    """An array's elements: a list that integers of a shader choose from, too.

    An index that is not known exactly gives the hull of all elements that it may choose; one
    outside of the array anything, as GLSL leaves it undefined.
    """

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, Integer):
            return self._chosen(index)
        if isinstance(index, Band | np.ndarray | float):
            raise FormulaError("an array's index is a float", remedy="index by int(x)")
        return super().__getitem__(index)

    def _chosen(self, index: Integer) -> Any:
        outside = (index.lo < 0) | (index.hi >= len(self)) | index.anything
        if index.known and index.lo.size == 1 and not outside.any():
            return self[int(index.lo.reshape(-1)[0])]
        chosen = self[-1]
        for number, element in enumerate(self[:-1]):
            chosen = _either(equal(index, number), element, chosen)
        if isinstance(chosen, Integer):
            return chosen.made(
                chosen.lo, None if chosen.known else chosen.hi, index, anything=outside
            )
        return undefined(chosen, outside) if isinstance(chosen, Band) else chosen


def array(*elements: Value) -> Elements:
    """A table to index, as `float[]`, `vec3[]` and `int[]` make in GLSL; of one list or NumPy array
    its elements. Python's integers are `int`s.

    >>> array(0.25, 0.5, 1.0)[1]
    0.5
    >>> array(8, 2, 10)[Integer([0, 2])].lo.tolist()
    [8, 10]
    """
    if len(elements) == 1 and isinstance(elements[0], list | tuple | np.ndarray):
        elements = tuple(elements[0])
    if not elements:
        raise FormulaError("an array has at least one element")
    return Elements(_element(element) for element in elements)


def _element(value: Value) -> Value:
    if isinstance(value, list | tuple):
        return array(value)
    kind = np.asarray(value).dtype.kind if isinstance(value, int | np.integer | np.ndarray) else ""
    return Integer(value, unsigned=kind == "u") if kind in ("i", "u") else value


def _either(condition: Any, a: Value, b: Value) -> Value:
    """`where`, element by element of arrays in an array."""
    if isinstance(a, Sequence):
        return Elements(_either(condition, x, y) for x, y in zip(a, b, strict=True))
    return where(condition, a, b)
