"""Sampled arguments by name: structs as one level of names such as "light.power", and back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from shaderlab.bands.rounding import shortest
from shaderlab.model.frame import Array

Values = dict[str, Array]


def flat(values: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Mappings as one, with names such as "light.power"."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{before}{name}.")
        else:
            yield before + name, value


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """The reverse of `flat`."""
    found: dict[str, Any] = {}
    for name, value in values.items():
        *heads, last = name.split(".")
        inner = found
        for head in heads:
            inner = inner.setdefault(head, {})
        inner[last] = value
    return found


def rows(values: Values, rows: slice) -> Values:
    return {name: value[rows] for name, value in values.items()}


def stretched(value: Any, count: int) -> Any:
    """Fixed values as many as there are samples."""
    if isinstance(value, Mapping):
        return {name: stretched(v, count) for name, v in value.items()}
    array = np.asanyarray(value)
    return (
        array
        if array.ndim and len(array) == count
        else np.broadcast_to(array, (count, *array.shape))
    )


def element(value: Any, n: int) -> Any:
    if isinstance(value, Mapping):
        return {name: element(v, n) for name, v in value.items()}
    return value[n]


def spelt(values: Values) -> Iterator[str]:
    def text(value: Any) -> str:
        if isinstance(value, dict):
            return "{" + ", ".join(f"{n!r}: {text(v)}" for n, v in value.items()) + "}"
        single = np.asarray(value)[0]
        if np.ndim(single):
            return "[" + ", ".join(map(number, np.ravel(single))) + "]"
        return number(single)

    for name, value in nested(values).items():
        yield f"{name}={text(value)}"


def number(value: Any) -> str:
    """The shortest text that gives the same float32, integer or boolean."""
    return str(value) if np.asarray(value).dtype.kind != "f" else shortest(value)
