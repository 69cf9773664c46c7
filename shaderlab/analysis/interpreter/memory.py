"""What variables hold on one path through a program, and the places that pointers mean."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands import Integer, Truth
from shaderlab.bands.truth import as_truth

from .types import Type
from .values import Value, component, composed, select

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Pointer:
    """A place in a variable: the way to it are indices, `Integer`s where they differ."""

    variable: int
    path: tuple[int | Integer, ...] = ()


class World:
    """The invocations on one path, and what each variable, phi and function's result is to them.

    A branch makes a world for each side. An invocation whose condition a band leaves open is in
    both; where the paths meet, the worlds are joined.

    Attributes:
        mask: which invocations are here, (count,).
        memory: by id; what is stored for other invocations means nothing.
    """

    __slots__ = ("mask", "memory")

    def __init__(self, mask: Flags, memory: dict[int, Value]) -> None:
        self.mask = mask
        self.memory = memory

    def split(self, mask: Flags) -> World:
        """Some of its invocations, with a memory of their own."""
        return World(mask, dict(self.memory))


def join(worlds: Sequence[World]) -> World:
    """One world of several: for each invocation the values of the world that it is in, the hull
    of both for one that is in two."""
    if len(worlds) == 1:
        return worlds[0]
    mask, memory = worlds[0].mask, worlds[0].memory
    for other in worlds[1:]:
        both = mask & other.mask
        here = Truth(((mask | ~other.mask) & ~both)[:, None], (other.mask & ~mask)[:, None])
        memory = dict(memory)
        for key, value in other.memory.items():
            own = memory.get(key)
            if own is not value:
                memory[key] = select(here, own, value)
        mask = mask | other.mask
    return World(mask, memory)


def indices(index: Integer, size: int, mask: Flags) -> range:
    """The indices that the invocations of a mask may mean, those beyond the ends clamped."""
    low, high = (np.broadcast_to(bound[:, 0], mask.shape)[mask] for bound in (index.lo, index.hi))
    if not low.size:
        return range(0, 1)
    first, last = (int(np.clip(end, 0, size - 1)) for end in (low.min(), high.max()))
    return range(first, last + 1)


def fetch(value: Value, path: Sequence[int | Integer], mask: Flags) -> Value:
    """The part of a value at the end of a path; an index beyond the ends means the last one."""
    for index in path:
        if value is None:
            return None
        if isinstance(index, Integer):
            value = _picked(value, _size(value), index, mask)
        else:
            value = component(value, min(max(index, 0), _size(value) - 1))
    return value


def _clamped(index: int | Integer, size: int) -> int | Integer:
    if isinstance(index, int):
        return min(max(index, 0), size - 1)
    low, high = (np.clip(end, 0, size - 1) for end in (index.lo, index.hi))
    return Integer(low, None if index.known else high, unsigned=index.unsigned, rules=index.rules)


def _size(value: Value) -> int:
    return len(value) if isinstance(value, tuple) else int(value.shape[-1])


def _picked(value: Value, size: int, index: Integer, mask: Flags) -> Value:
    few = indices(index, size, mask)
    found = component(value, few[0])
    for k in few[1:]:
        found = select(_is(index, k), component(value, k), found)
    return found


def _is(index: Integer, number: int) -> Truth:
    return as_truth(index == number)  # type: ignore[comparison-overlap]


def changed(
    old: Value, type_: Type, path: Sequence[int | Integer], new: Value, mask: Flags
) -> Value:
    """The value with the part at the end of a path replaced. An index beyond the ends means no
    part; of an array whose length is known at run time only it means the last one, or the first."""
    if not path:
        return new
    index, rest = path[0], path[1:]
    parts: list[Value] = [component(old, k) for k in range(_size(old))]
    if type_.kind == "array" and not type_.count:
        index = _clamped(index, len(parts))
    if isinstance(index, Integer):
        for k in indices(index, len(parts), mask):
            inner = changed(parts[k], type_.part(k), rest, new, mask)
            parts[k] = select(_is(index, k), inner, parts[k])
    elif 0 <= index < len(parts):  # GLSL does not say what is stored elsewhere
        parts[index] = changed(parts[index], type_.part(index), rest, new, mask)
    return composed(type_, parts)


def spelt(name: str, type_: Type, path: Sequence[int | Integer]) -> str:
    """A place's name as GLSL writes it; "[?]" where an index differs between invocations."""
    for index in path:
        name += type_.step("?" if isinstance(index, Integer) else index)
        type_ = type_.part(0 if isinstance(index, Integer) else index)
    return name


def part_type(type_: Type, path: Sequence[int | Integer]) -> Type:
    """The type of the part at the end of a path."""
    for index in path:
        type_ = type_.part(0 if isinstance(index, Integer) else index)
    return type_


def known_index(index: Any) -> int | Integer:
    """An index as one number where all invocations have the same."""
    first = int(index.lo.flat[0])
    same = index.known and bool((index.lo == first).all())
    return first if same else index
