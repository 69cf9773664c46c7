"""Values of every GLSL type: how they are built, taken apart, changed in parts, selected.

A float is an arithmetic's, an integer an `Integer`, a condition a `TriBool`, each shaped
(count or 1, components); a matrix is (count or 1, rows, columns); structs and arrays are tuples;
samplers are `Texels`. None is what nothing was stored to.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import glslmath
from shaderlab.bands import Band, Integer, TriBool
from shaderlab.bands.exact import (
    as_tri_bool,
    concatenate,
    join as join_bands,
    select as select_bands,
)
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array

from .arithmetic import Arithmetic, Floats
from .program import Type

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
    """What a variable holds before anything is stored: any float, 0 and false of other types, for
    ranges anything as well. No two floats of it are one object, or their product was a square."""
    ranges = arithmetic.rules is not None and arithmetic.rules.ranges
    return _fill(type_, arithmetic, arithmetic.undefined(), anything=ranges)


def null(type_: Type, arithmetic: Arithmetic) -> Value:
    """Zero, false, or a composite of those."""
    return _fill(type_, arithmetic, arithmetic.exact(np.zeros((1, 1))))


def _fill(type_: Type, arithmetic: Arithmetic, number: Floats, *, anything: bool = False) -> Value:
    """A value of a type all of whose floats are this one, others 0 and false or `anything`."""
    if type_.kind == "struct":
        return tuple(
            _fill(member, arithmetic, number, anything=anything) for _, member in type_.members
        )
    if type_.of is not None:
        parts = (type_.of for _ in range(type_.count))
        return compose(type_, [_fill(of, arithmetic, number, anything=anything) for of in parts])
    if type_.kind == "int":
        zero = Integer(np.zeros((1, 1)), unsigned=not type_.signed, rules=arithmetic.rules)
        return zero.derive(zero.lo, zero.lo, anything=np.full((1, 1), True)) if anything else zero
    if type_.kind == "float":
        return number.copy_independent() if isinstance(number, Band) else number
    no = np.zeros((1, 1), np.bool_)
    return TriBool(no, no if anything else ~no)


def compose(type_: Type, parts: Sequence[Value]) -> Value:
    """A value of a type out of its parts; a vector's may be vectors themselves."""
    if type_.kind in ("array", "struct"):
        return tuple(parts)
    if type_.kind == "matrix":
        return _stack([part[..., :, None] for part in parts])
    return parts[0] if len(parts) == 1 else _stack(parts)


def _stack(parts: Sequence[Value]) -> Value:
    first = parts[0]
    if isinstance(first, Band):
        return join_bands(parts, -1)
    if isinstance(first, Integer):
        size = sum(part.shape[-1] for part in parts)
        vector = getattr(glslmath, f"{'u' if first.unsigned else 'i'}vec{size}")
        return vector(*parts)
    if isinstance(first, TriBool):
        yes, no = (
            concatenate([getattr(part, side) for part in parts], -1)
            for side in ("all_true", "all_false")
        )
        return TriBool(yes, no, next((part.rules for part in parts if part.rules), None))
    return concatenate(parts, -1)


def component(value: Value, index: int) -> Value:
    """A vector's component, a matrix' column, an array's element, a struct's member."""
    if isinstance(value, tuple):
        return value[index]
    return value[..., index] if value.ndim == 3 else value[..., index : index + 1]


def select(condition: TriBool, a: Value, b: Value) -> Value:
    """a where the condition (count or 1, components or 1) holds, else b; the hull of both where it
    is undecided. Where nothing was stored to one of them, the other. Raises UnchoosableError: they
    are different samplers."""
    if a is b or b is None:
        return a
    if a is None:
        return b
    if isinstance(a, Missing) or isinstance(b, Missing):
        return a if isinstance(a, Missing) else b  # only reading it is an error
    if isinstance(a, tuple) and isinstance(b, tuple):
        return tuple(select(condition, x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, TriBool):
        return _select_truth(condition, a, b)
    if isinstance(a, Integer):
        return glslmath.where(condition, a, b)
    if not isinstance(a, Band | np.ndarray):
        if isinstance(a, Pointer) and a == b:
            return a
        raise UnchoosableError
    if a.ndim == 3 and condition.ndim == 2:
        condition = condition[..., None]
    if isinstance(a, Band):
        return select_bands(condition, a, b)
    return np.where(condition.all_true, a, b)


def _select_truth(condition: TriBool, a: TriBool, b: TriBool) -> TriBool:
    yes, no = condition.all_true, condition.all_false

    def known(of_a: Any, of_b: Any) -> Any:
        return (yes & of_a) | (no & of_b) | (of_a & of_b)

    sides = (known(a.all_true, b.all_true), known(a.all_false, b.all_false))
    return TriBool(*sides, a.rules or b.rules or condition.rules)


def broadcast(value: Value, count: int) -> Value:
    """The value with as many rows as there are invocations."""
    if isinstance(value, tuple):
        return tuple(broadcast(part, count) for part in value)
    if value.shape[0] == count:
        return value
    rows = np.zeros(count, np.int64)
    return value[rows]


Flags = npt.NDArray[np.bool_]
_FEW = 4  # values that are chosen from one by one


@dataclass(frozen=True, eq=False)
class Pointer:
    """A place in a variable: the way to it are indices, `Integer`s where they differ."""

    variable: int
    path: tuple[int | Integer, ...] = ()


class PathState:
    """The invocations on one path, and what each variable, phi and function's result is to them.

    A branch makes a state for each side. An invocation whose condition a band leaves open is in
    both; where the paths meet, the states are joined. `memory` goes by id; what is stored for other
    invocations means nothing."""

    __slots__ = ("mask", "memory")

    def __init__(self, mask: Flags, memory: dict[int, Value]) -> None:
        self.mask = mask
        self.memory = memory

    def split(self, mask: Flags) -> PathState:
        """Some of its invocations, with a memory of their own."""
        return PathState(mask, dict(self.memory))


def join(states: Sequence[PathState]) -> PathState:
    """One state of several: for each invocation the values of the state that it is in, the hull
    of both for one that is in two."""
    if len(states) == 1:
        return states[0]
    mask, memory = states[0].mask, states[0].memory
    for other in states[1:]:
        both = mask & other.mask
        here = TriBool(((mask | ~other.mask) & ~both)[:, None], (other.mask & ~mask)[:, None])
        memory = dict(memory)
        for key, value in other.memory.items():
            own = memory.get(key)
            if own is not value:
                memory[key] = select(here, own, value)
        mask = mask | other.mask
    return PathState(mask, memory)


def indices(index: Integer, size: int, mask: Flags) -> range:
    """The indices that the invocations of a mask may mean, those beyond the ends clamped."""
    low, high = (np.broadcast_to(bound[:, 0], mask.shape)[mask] for bound in (index.lo, index.hi))
    if not low.size:
        return range(0, 1)
    first, last = (int(np.clip(end, 0, size - 1)) for end in (low.min(), high.max()))
    return range(first, last + 1)


def fetch(value: Value, path: Sequence[int | Integer], mask: Flags) -> Value:
    """The part of a value at the end of a path; an index beyond the ends means the last one."""
    for i, index in enumerate(path):
        if value is None:
            return None
        if isinstance(index, Integer):
            few = indices(index, _size(value), mask)
            parts = [fetch(component(value, k), path[i + 1 :], mask) for k in few]
            return _choose(index, few, parts)
        value = component(value, min(max(index, 0), _size(value) - 1))
    return value


def _choose(index: Integer, few: range, parts: Sequence[Value]) -> Value:
    """Of each invocation the part with its index."""
    plain = [p.lo if type(p) is Integer and p.known and p.rules is None else p for p in parts]
    if len(few) > _FEW and all(type(part) is np.ndarray and part.ndim == 2 for part in plain):
        table = np.stack(np.broadcast_arrays(*plain, np.zeros((len(index.lo), 1)))[:-1])
        found = table[np.clip(index.lo[:, 0] - few[0], 0, len(few) - 1), np.arange(len(index.lo))]
        return found if plain[0] is parts[0] else Integer(found, unsigned=parts[0].unsigned)
    found = parts[0]
    for k, part in zip(few[1:], parts[1:], strict=True):
        found = select(_is(index, k), part, found)
    return found


def _clamp_index(index: int | Integer, size: int) -> int | Integer:
    if isinstance(index, int):
        return min(max(index, 0), size - 1)
    low, high = (np.clip(end, 0, size - 1) for end in (index.lo, index.hi))
    return Integer(low, None if index.known else high, unsigned=index.unsigned, rules=index.rules)


def _size(value: Value) -> int:
    return len(value) if isinstance(value, tuple) else int(value.shape[-1])


def _is(index: Integer, number: int) -> TriBool:
    return as_tri_bool(index == number)  # type: ignore[comparison-overlap]


def replace_part(
    old: Value, type_: Type, path: Sequence[int | Integer], new: Value, mask: Flags
) -> Value:
    """The value with the part at the end of a path replaced. An index beyond the ends means no
    part; of an array whose length is known at run time only it means the last one, or the first."""
    if not path:
        return new
    index, rest = path[0], path[1:]
    parts: list[Value] = [component(old, k) for k in range(_size(old))]
    if type_.kind == "array" and not type_.count:
        index = _clamp_index(index, len(parts))
    if isinstance(index, Integer):
        for k in indices(index, len(parts), mask):
            inner = replace_part(parts[k], type_.part(k), rest, new, mask)
            parts[k] = select(_is(index, k), inner, parts[k])
    elif 0 <= index < len(parts):  # GLSL does not say what is stored elsewhere
        parts[index] = replace_part(parts[index], type_.part(index), rest, new, mask)
    return compose(type_, parts)


def format_place(name: str, type_: Type, path: Sequence[int | Integer]) -> str:
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


def split_parts(value: Value, type_: Type, name: str) -> Iterator[tuple[str, Value]]:
    """The numbers, vectors and matrices of a value, each by its name in GLSL."""
    if isinstance(value, tuple):
        for i, part in enumerate(value):
            yield from split_parts(part, type_.part(i), name + type_.step(i))
    elif isinstance(value, Band | Integer | TriBool | np.ndarray):
        yield name, value


def known_index(index: Any) -> int | Integer:
    """An index as one number where all invocations have the same."""
    first = int(index.lo.flat[0])
    same = index.known and bool((index.lo == first).all())
    return first if same else index


NUMBERS = (
    "gl_WorkGroupID", "gl_LocalInvocationID", "gl_GlobalInvocationID", "gl_LocalInvocationIndex"
)  # fmt: skip
"""The built-in inputs that number a compute stage's invocations."""
Size = tuple[int, int, int]


def number_invocations(size: Size, groups: Array, local: Array) -> dict[str, Array]:
    """`NUMBERS` of invocations by their workgroups and their places in these, (count, 3) each."""
    x, y, _ = size
    each = groups * np.array(size) + local
    index = (local @ np.array([1, x, x * y]))[:, None]
    return dict(zip(NUMBERS, (groups, local, each, index), strict=True))
