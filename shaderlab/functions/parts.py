"""A call's results as parts that bands are of, each with its part of what a reference gives.

A structure has its members as parts, and a function with `out` parameters all that it writes. A
matrix or an array is one part, whose numbers are laid side by side.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.errors import FormulaError
from shaderlab.functions.types import Type
from shaderlab.glslmath.arrays import stacked
from shaderlab.glslmath.choice import where
from shaderlab.model.frame import Array

Reference = Callable[..., Any]


@dataclass(frozen=True)
class _Step:
    """From a result to one of its parts: `name` is number `index` of all `names`."""

    name: str
    index: int
    names: tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """A part of a call's result.

    Attributes:
        type: of numbers.
        values: what the function gave, shaped as the batch and then the type; may be masked.
        steps: the way to it.
    """

    type: Type
    values: Any
    steps: tuple[_Step, ...]

    @property
    def name(self) -> str:
        """Such as "hit.normal", "lights[2].color"; "" where the result is one value."""
        return ".".join(step.name for step in self.steps).replace(".[", "[")

    def named(self, function: str) -> str:
        """Such as "sphere.normal", "corners[1]"; the function's name where there is one value."""
        return f"{function}.{self.name}".replace(".[", "[").removesuffix(".")

    def rows(self, kept: Array) -> Array:
        """Its numbers for the elements that are kept, (count, numbers); booleans as 0.0 and 1.0."""
        values = np.asarray(getattr(self.values, "data", self.values))
        found = values.reshape(kept.size, -1)[kept.reshape(-1)]
        return found.astype(np.float32) if found.dtype == bool else found

    def of(self, reference: Reference) -> Reference:
        """This part of what a reference gives, as a reference with the same parameters."""
        plain = self.type.kind != "bool" and not self.type.dims and len(self.type.shape) < 2
        if plain and not self.steps:
            return reference
        found = functools.partial(_part, reference, self.steps, self.type)
        functools.update_wrapper(found, reference, assigned=(), updated=())
        return found


def parts(outputs: Sequence[tuple[str, Type]], got: Any) -> list[Part]:
    """The parts of a call's result, as `Function` gives it: of `outputs` by name."""
    if len(outputs) == 1:
        return list(_parts(outputs[0][1], got, ()))
    names = tuple(name for name, _ in outputs)
    return [
        part
        for n, (name, kind) in enumerate(outputs)
        for part in _parts(kind, got[n], (_Step(name, n, names),))
    ]


def _parts(kind: Type, got: Any, steps: tuple[_Step, ...]) -> Iterator[Part]:
    if kind.dims and (kind.members or kind.kind in ("int", "uint")):
        names = tuple(f"[{n}]" for n in range(kind.dims[0]))
        for n, name in enumerate(names):
            # Integers are judged one by one: side by side they would become floats.
            each = got[n] if kind.members else np.ma.take(got, n, axis=-len(kind.shape))
            yield from _parts(kind.element, each, (*steps, _Step(name, n, names)))
    elif kind.members:
        names = tuple(name for name, _ in kind.members)
        for n, (name, member) in enumerate(kind.members):
            yield from _parts(member, got[name], (*steps, _Step(name, n, names)))
    else:
        yield Part(kind, got, steps)


def _part(
    reference: Reference, steps: tuple[_Step, ...], kind: Type, /, *given: Any, **named: Any
) -> Any:
    value = reference(*given, **named)
    for step in steps:
        value = _taken(value, step)
    return _flat(value, kind)


def _taken(value: Any, step: _Step) -> Any:
    """A member by its name from a mapping, a named tuple or a data class, else by its place."""
    names = getattr(value, "_fields", ())
    if dataclasses.is_dataclass(value):
        names = [field.name for field in dataclasses.fields(value)]
    if isinstance(value, Mapping) and step.name in value:
        return value[step.name]
    if step.name in names:
        return getattr(value, step.name)
    if isinstance(value, list | tuple) and len(value) == len(step.names) and not names:
        return value[step.index]
    shown = ", ".join(step.names)
    raise FormulaError(
        f"gives {_shown(value)}, not {shown}",
        remedy=f"return {_remedy(step.names)}",
    )


def _shown(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"a dict of {', '.join(map(str, value))}"
    if isinstance(value, list | tuple):
        return f"a {type(value).__name__} of {len(value)}"
    return "one value"


def _remedy(names: Sequence[str]) -> str:
    if names[0].startswith("["):
        return f"a list of {len(names)}"
    members = ", ".join(f'"{name}": …' for name in names)
    return f"{{{members}}}, or a tuple in that order"


def _flat(value: Any, kind: Type) -> Any:
    """A matrix's or an array's numbers side by side, in the order of `Part.rows`."""
    if kind.dims:
        return _flat_array(value, kind)
    if len(kind.base_shape) < 2:
        return where(value, 1.0, 0.0) if kind.kind == "bool" else value
    rows, columns = kind.base_shape
    shape = getattr(value, "shape", ())
    if tuple(shape[-2:]) != kind.base_shape:
        raise FormulaError(
            f"gives shape {shape} for a {kind}",
            remedy=f"build it of its columns, or give an array (…, {rows} rows, {columns} columns)",
        )
    return stacked([value[..., row, :] for row in range(rows)], -1)


def _flat_array(value: Any, kind: Type) -> Any:
    count = kind.dims[0]
    if not isinstance(value, list | tuple):
        shape, inner = getattr(value, "shape", ()), kind.element.shape
        if not inner and shape[-1:] == (count,):
            return value
        axis = -1 - len(inner)
        if not inner or len(shape) < -axis or shape[axis] != count:
            raise FormulaError(f"gives shape {shape} for {kind}", remedy=f"give a list of {count}")
        value = [value[(..., n, *[slice(None)] * len(inner))] for n in range(count)]
    if len(value) != count:
        raise FormulaError(f"gives {len(value)} elements for {kind}")
    size = math.prod(kind.element.shape)
    elements = [_flat(each, kind.element) for each in value]
    return stacked([_whole(each, size) for each in elements], -1)


def _whole(value: Any, size: int) -> Any:
    """An element of an array with all its components, where one number stands for them."""
    shape = getattr(value, "shape", ())
    return stacked([value] * size, -1) if size > 1 and shape[-1:] in ((), (1,)) else value
