"""Values of structures, given as mappings of their members."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def by_member(values: Mapping[str, Any]) -> Mapping[str, Any]:
    """Each value under the name that GLSL has for it; the very same mapping if no value is of a
    structure.

    >>> by_member({"light": {"linear": 0.09}, "lamps": [{"on": True}, {"on": False}]})
    {'light.linear': 0.09, 'lamps[0].on': True, 'lamps[1].on': False}
    """
    if any(_structured(value) for value in values.values()):
        return {name: value for own, given in values.items() for name, value in _spelt(own, given)}
    return values


def _structured(value: Any) -> bool:
    """Whether a value is of a structure, or of an array of structures."""
    first = value[0] if isinstance(value, list | tuple) and value else value
    return isinstance(first, Mapping)


def _spelt(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if not _structured(value):
        yield name, value
    elif isinstance(value, Mapping):
        for member, its in value.items():
            yield from _spelt(f"{name}.{member}", its)
    else:
        for n, element in enumerate(value):
            yield from _spelt(f"{name}[{n}]", element)
