"""Whether a value has an annotated type: each annotation is read once, and becomes a function."""

from __future__ import annotations

import collections.abc
import numbers
import types
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

UNIONS = (typing.Union, types.UnionType)
SCALARS: Mapping[Any, tuple[tuple[type, ...], str]] = {
    str: ((str,), "word"),
    bytes: ((bytes,), "bytes"),
    bool: ((bool, np.bool_), "True or False"),
    int: ((int, numbers.Integral), "whole number"),
    float: ((float, int, numbers.Real), "number"),
    Path: ((Path,), "path"),
    type(None): ((type(None),), "None"),
}
"""The types of a value that stands for one of these, and its name in a sentence."""
LOOKED_AT = 64
"""Elements of a long sequence that are looked at: its first ones tell."""


class Misfit(NamedTuple):
    """The part of a value that has not its type.

    Attributes:
        place: where the part is, as a format: `{}[3]` for a value of some name.
        part: that part.
        hint: the type that it should have.
    """

    place: str
    part: Any
    hint: Any


Check = Callable[[Any], Misfit | None]


def type_check(hint: Any) -> Check:
    """A function that finds the part of a value that is not of this type, or gives None.

    Lists do for tuples, NumPy's numbers and arrays for Python's. Types that say nothing of their
    values at run time, type variables for instance, take every value.
    """
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    kind = origin or hint
    if origin in UNIONS:
        return _union(hint, [type_check(one) for one in inner])
    if origin is typing.Literal:
        kinds = tuple({type(one) for one in inner})
        # An array can't be compared with a word.
        return _predicate(hint, lambda value: isinstance(value, kinds) and value in inner)
    if kind in SCALARS:
        return _instance(hint, SCALARS[kind][0])
    if kind is np.ndarray:
        return _predicate(hint, _is_array)
    if kind in (tuple, list, collections.abc.Sequence, collections.abc.Iterable):
        return _sequence(hint)
    if kind is collections.abc.Callable:
        return _predicate(hint, callable)
    if kind in (collections.abc.Mapping, dict):
        return _mapping(hint)
    if hint is Any or not isinstance(kind, type):
        return lambda _: None
    return _instance(hint, (kind,))


def _instance(hint: Any, kinds: tuple[type, ...]) -> Check:
    def check(value: Any) -> Misfit | None:
        return None if isinstance(value, kinds) else Misfit("{}", value, hint)

    return check


def _predicate(hint: Any, fits: Callable[[Any], bool]) -> Check:
    def check(value: Any) -> Misfit | None:
        return None if fits(value) else Misfit("{}", value, hint)

    return check


def _union(hint: Any, checks: Sequence[Check]) -> Check:
    def check(value: Any) -> Misfit | None:
        found = []
        for one in checks:
            wrong = one(value)
            if wrong is None:
                return None
            found.append(wrong)
        # Of the alternatives the one is meant that is wrong furthest inside.
        deepest = max(found, key=lambda wrong: len(wrong.place))
        return deepest if len(deepest.place) > len("{}") else Misfit("{}", value, hint)

    return check


def _mapping(hint: Any) -> Check:
    checks = [type_check(one) for one in typing.get_args(hint)]

    def check(value: Any) -> Misfit | None:
        if not isinstance(value, Mapping):
            return Misfit("{}", value, hint)
        if checks:
            for key, item in list(value.items())[:LOOKED_AT]:
                if wrong := checks[0](key):
                    return _inside("a key of {}", wrong)
                if wrong := checks[1](item):
                    return _inside(f"{{}}[{_escaped(repr(key))}]", wrong)
        return None

    return check


def _sequence(hint: Any) -> Check:
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    checks = [type_check(one) for one in inner if one is not Ellipsis]
    fixed = origin is tuple and bool(inner) and inner[-1] is not Ellipsis
    numeric = bool(inner) and _takes_numbers(inner[0])

    def check(value: Any) -> Misfit | None:
        if not isinstance(value, tuple | list):
            if isinstance(value, np.ndarray):
                if not (value.ndim and numeric):
                    return Misfit("{}", value, hint)
            elif isinstance(value, str | bytes | Mapping) or not isinstance(value, Sequence):
                lazy = isinstance(value, Iterable) and not isinstance(value, str | bytes | Mapping)
                takes_any = origin is collections.abc.Iterable
                return None if lazy and takes_any else Misfit("{}", value, hint)
        if fixed and len(value) != len(checks):
            return Misfit("{}", value, hint)
        if checks:
            for index, item in enumerate(value[:LOOKED_AT]):
                if wrong := checks[index if fixed else 0](item):
                    return _inside(f"{{}}[{index}]", wrong)
        return None

    return check


def _inside(place: str, wrong: Misfit) -> Misfit:
    """What is wrong with a part, as what is wrong with the whole."""
    return wrong._replace(place=wrong.place.replace("{}", place, 1))


def _escaped(text: str) -> str:
    return text.replace("{", "{{").replace("}", "}}")


def _takes_numbers(hint: Any) -> bool:
    inner = typing.get_args(hint)
    return hint in (Any, float, int) or (bool(inner) and any(map(_takes_numbers, inner)))


def _is_array(value: Any) -> bool:
    """Whether a value is an array, or a list that becomes one of numbers."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "fiub"
    if isinstance(value, str | bytes) or not isinstance(value, Sequence):
        return False
    try:
        return np.asarray(value).dtype.kind in "fiub"
    except ValueError:
        return False
