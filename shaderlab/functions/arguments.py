"""Arguments as a caller writes them, made into the words of a kernel; its words made results."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.errors import CallError
from shaderlab.functions.types import DTYPES, Type
from shaderlab.model.frame import Array

_ACCEPTED = {"float": "fiu", "int": "iu", "uint": "iu", "bool": "b"}
_WORD = {"f": np.dtype(np.float32), "i": np.dtype(np.int32)}
_SHOWN = 60


@dataclass(frozen=True)
class Argument:
    """A value that fits its type.

    Attributes:
        type: of the parameter or global.
        batch: the axes before the type's own.
        leaves: its numbers in the order of the type's words: each (batch…, words of the leaf),
            where the batch may be any shape that broadcasts.
        whole: the kind of the integers that were given, "i" or "u" as in NumPy; "" for others.
    """

    type: Type
    batch: tuple[int, ...]
    leaves: tuple[Array, ...]
    whole: str = ""

    @property
    def varies(self) -> bool:
        """Whether it has more than one element."""
        return math.prod(self.batch) != 1

    @property
    def value(self) -> Any:
        """The value as the function gets it: floats are float32's."""
        return _rebuilt(iter(self.leaves), self.type)

    def shared_words(self) -> Array:
        """The words of its only element, uint32."""
        found = [_as_words(leaf).reshape(-1) for leaf in self.leaves]
        return np.concatenate(found) if found else np.zeros(0, np.uint32)

    def fill(self, layers: Array, batch: tuple[int, ...]) -> None:
        """Write each word's elements, broadcast to `batch`, to the start of a layer (uint32)."""
        at, count = 0, math.prod(batch)
        for leaf in self.leaves:
            dtype = _WORD.get(leaf.dtype.kind, np.dtype(np.uint32))
            for n in range(leaf.shape[-1]):
                layer = layers[at].reshape(-1)[:count].view(dtype).reshape(batch)
                with np.errstate(over="ignore", invalid="ignore"):
                    np.copyto(layer, leaf[..., n], casting="unsafe")
                at += 1


def _rebuilt(leaves: Iterator[Array], kind: Type) -> Any:
    if kind.members and kind.dims:
        return [_rebuilt(leaves, kind.element) for _ in range(kind.dims[0])]
    if kind.members:
        return {name: _rebuilt(leaves, member) for name, member in kind.members}
    leaf = next(leaves)
    shape = (*leaf.shape[:-1], *kind.shape)
    return (leaf.astype(np.float32) if kind.kind == "float" else leaf).reshape(shape)


def _as_words(leaf: Array) -> Array:
    if leaf.dtype == bool:
        return leaf.astype(np.uint32)
    with np.errstate(over="ignore", invalid="ignore"):
        narrow = leaf.astype(np.float32) if leaf.dtype == np.float64 else leaf
    return np.ascontiguousarray(narrow).view(np.uint32)


def argument(value: Any, kind: Type, label: str) -> Argument:
    """The value of a parameter or a global.

    Raises:
        CallError: it does not fit; names the label, the type and what was given.
    """
    leaves = tuple(_leaves(value, kind, label))
    try:
        batch = np.broadcast_shapes(*(leaf.shape[:-1] for leaf in leaves))
    except ValueError:
        shapes = ", ".join(dict.fromkeys(str(leaf.shape[:-1]) for leaf in leaves))
        raise CallError(f"{label}: members of shapes {shapes} do not broadcast") from None
    given = "" if kind.members else np.asarray(value).dtype.kind
    return Argument(kind, batch, leaves, given if given in ("i", "u") else "")


def _leaves(value: Any, kind: Type, label: str) -> Iterator[Array]:
    if kind.members and kind.dims:
        if isinstance(value, Mapping | str) or not isinstance(value, Sequence):
            raise _misfit(value, kind, label, f"a sequence of {kind.dims[0]} values")
        if len(value) != kind.dims[0]:
            raise _misfit(value, kind, label, f"a sequence of {kind.dims[0]} values")
        for number, element in enumerate(value):
            yield from _leaves(element, kind.element, f"{label}[{number}]")
    elif kind.members:
        yield from _members(value, kind, label)
    else:
        yield _numbers(value, kind, label)


def _members(value: Any, kind: Type, label: str) -> Iterator[Array]:
    names = [name for name, _ in kind.members]
    if not isinstance(value, Mapping):
        raise _misfit(value, kind, label, f"a mapping of {', '.join(names)}")
    missing = [name for name in names if name not in value]
    surplus = [name for name in value if name not in names]
    if missing or surplus:
        what = f"lacks {', '.join(missing)}" if missing else f"has no member {surplus[0]!r}"
        raise CallError(f"{label}: {kind} {what}", remedy=f"it has {', '.join(names)}")
    for name, member in kind.members:
        yield from _leaves(value[name], member, f"{label}.{name}")


def _numbers(value: Any, kind: Type, label: str) -> Array:
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        raise _misfit(value, kind, label, "an array of numbers") from None
    if array.dtype.kind not in _ACCEPTED[kind.kind]:
        whole = array.dtype.kind == "f" and kind.kind in ("int", "uint")
        remedy = "make them whole with .astype(int)" if whole else f"give {_numbers_of(kind)}"
        raise _misfit(value, kind, label, remedy=remedy)
    own = len(kind.shape)
    if array.ndim < own or array.shape[array.ndim - own :] != kind.shape:
        wanted = ", ".join(map(str, kind.shape))
        raise _misfit(value, kind, label, f"an array whose last axes are ({wanted})")
    if kind.kind in ("int", "uint"):
        array = _in_range(array, kind, label)
    elif kind.kind == "float" and array.dtype != np.float32:
        array = array.astype(np.float64, copy=False)
    return array.reshape(*array.shape[: array.ndim - own], math.prod(kind.shape))


def _in_range(array: Array, kind: Type, label: str) -> Array:
    limits = np.iinfo(DTYPES[kind.kind])
    if array.dtype != limits.dtype and array.size:
        low, high = int(array.min()), int(array.max())
        if low < limits.min or high > limits.max:
            wrong = low if low < limits.min else high
            raise CallError(f"{label}: {kind} can't hold {wrong}")
    return array.astype(limits.dtype, copy=False)


def _numbers_of(kind: Type) -> str:
    return {"float": "numbers", "bool": "booleans"}.get(kind.kind, "whole numbers")


def _misfit(
    value: Any, kind: Type, label: str, wanted: str = "", remedy: str | None = None
) -> CallError:
    if isinstance(value, np.ndarray):
        given = f"an array of {value.dtype}, shape {value.shape}"
    else:
        text = repr(value)
        text = text if len(text) <= _SHOWN else text[: _SHOWN - 1] + "…"
        given = f"{type(value).__name__} {text}"
    return CallError(f"{label} is {kind}; given was {given}", remedy=remedy or f"give {wanted}")


def result(words: Array, kind: Type, batch: tuple[int, ...]) -> Any:
    """A value of a type from its words, (words, count) of uint32: an array of the batch's shape and
    the type's, a mapping for a struct, a list for an array of structs. It may be a view of them."""
    if kind.members and kind.dims:
        size = kind.element.words
        parts = range(kind.dims[0])
        return [result(words[n * size : (n + 1) * size], kind.element, batch) for n in parts]
    if kind.members:
        found, at = {}, 0
        for name, member in kind.members:
            found[name] = result(words[at : at + member.words], member, batch)
            at += member.words
        return found
    values = words != 0 if kind.kind == "bool" else words.view(DTYPES[kind.kind])
    if not kind.shape:
        return values[0].reshape(batch)[()]
    return np.ascontiguousarray(values.T).reshape(*batch, *kind.shape)
