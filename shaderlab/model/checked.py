"""Constructors that check the types of what they get, and say in words what they take.

A case file is written by hand: a list in a number's place must be an error there, with the name of
the argument, and not one of arithmetic later on.
"""

from __future__ import annotations

import builtins
import collections.abc
import contextlib
import functools
import inspect
import numbers
import re
import sys
import types
import typing
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from shaderlab.errors import CaseError, nearest

_UNIONS = (typing.Union, types.UnionType)
_SHOWN = 60
_LOOKED_AT = 64  # elements of a long sequence: its first ones tell
_SCALARS: Mapping[Any, tuple[tuple[type, ...], str]] = {
    str: ((str,), "word"),
    bytes: ((bytes,), "bytes"),
    bool: ((bool, np.bool_), "True or False"),
    int: ((numbers.Integral,), "whole number"),
    float: ((numbers.Real,), "number"),
    Path: ((Path,), "path"),
    type(None): ((type(None),), "None"),
}


class Checked:
    """Base of dataclasses whose fields must have the types that they are annotated with.

    Lists do for tuples, NumPy's numbers and arrays for Python's. The types are looked at before the
    class's own `__post_init__`.
    """

    def __init_subclass__(cls, **given: Any) -> None:
        super().__init_subclass__(**given)
        own = cls.__dict__.get("__post_init__")
        if own is not None:

            @functools.wraps(own)
            def checked(self: Checked) -> None:
                Checked.__post_init__(self)
                own(self)

            cls.__post_init__ = checked  # type: ignore[method-assign]

    def __post_init__(self) -> None:
        """Raise CaseError for the first field that has no value of its type."""
        kind: Any = type(self)
        owner = kind.__name__
        if hasattr(kind, "kind"):  # an expectation, which cases call by a function's name
            owner = re.sub("(?<=[a-z])(?=[A-Z])", "_", owner).lower()
        for name, hint in _hints(kind).items():
            _require(owner, name, getattr(self, name), hint)


Function = TypeVar("Function", bound=Callable[..., Any])


def checked_arguments(function: Function) -> Function:
    """A function that looks at the types of its arguments first, as `Checked` does."""
    signature = inspect.signature(function)
    keywords = {p.name for p in signature.parameters.values() if p.kind == p.VAR_KEYWORD}
    variadic = {p.name for p in signature.parameters.values() if p.kind == p.VAR_POSITIONAL}

    @functools.wraps(function)
    def checked(*arguments: Any, **named: Any) -> Any:
        hints = _evaluated(function.__annotations__, function.__module__)
        try:
            given = signature.bind(*arguments, **named).arguments
        except TypeError:
            return function(*arguments, **named)  # which says it with its name
        for name, value in given.items():
            if name in keywords:
                _require_keywords(function.__name__, value, typing.get_args(hints[name])[0])
            elif name in hints:
                for item in value if name in variadic else (value,):
                    _require(function.__name__, name, item, hints[name])
        return function(*arguments, **named)

    return cast(Function, checked)


def _require_keywords(owner: str, given: Mapping[str, Any], known: type) -> None:
    """As `_require`, for keywords that a TypedDict has."""
    hints = _evaluated(known.__annotations__, known.__module__)
    for name, value in given.items():
        if name not in hints:
            raise CaseError(f"{owner}: takes no {name!r}", remedy=nearest(name, hints))
        _require(owner, name, value, hints[name])


def _require(owner: str, name: str, value: Any, hint: Any) -> None:
    wrong = _misfit(value, hint, name)
    if wrong is not None:
        path, part, inner = wrong
        raise CaseError(
            f"{owner}: {path} is {_shown(part)}, which is no {_words(inner)}",
            remedy=_remedy(name, value, hint),
        )


@functools.cache
def _hints(kind: Hashable) -> dict[str, Any]:
    """The types of a dataclass's fields, without those that only type checkers know."""
    found: dict[str, Any] = {}
    assert isinstance(kind, type)
    for owner in reversed(kind.__mro__):
        found |= _evaluated(vars(owner).get("__annotations__", {}), owner.__module__)
    names = [field.name for field in fields(kind) if field.init]
    return {name: found[name] for name in names if name in found}


def _evaluated(annotations: Mapping[str, Any], module: str) -> dict[str, Any]:
    """The types that annotations of a module name."""
    scope, found = dict(vars(sys.modules.get(module, builtins))), {}
    for name, text in annotations.items():
        with contextlib.suppress(NameError, TypeError, AttributeError):
            text = getattr(text, "__forward_arg__", text)  # as a TypedDict has it
            found[name] = eval(text, scope) if isinstance(text, str) else text
    return found


def _misfit(value: Any, hint: Any, path: str) -> tuple[str, Any, Any] | None:
    """The part of a value that has not its type: where it is, the part, and the type; or None."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any or isinstance(hint, typing.TypeVar) or hint is np.ndarray:
        return None if hint is not np.ndarray or _is_array(value) else (path, value, hint)
    if origin in _UNIONS:
        found = [_misfit(value, one, path) for one in inner]
        if None in found:
            return None
        # Of the alternatives the one is meant that is wrong furthest inside.
        deepest = max((one for one in found if one is not None), key=lambda one: len(one[0]))
        return deepest if len(deepest[0]) > len(path) else (path, value, hint)
    if origin is typing.Literal:
        return None if value in inner else (path, value, hint)
    kind = origin or hint
    if kind in _SCALARS:
        return None if isinstance(value, _SCALARS[kind][0]) else (path, value, hint)
    if kind is np.ndarray:
        return None if _is_array(value) else (path, value, hint)
    if kind is tuple or kind in (collections.abc.Sequence, collections.abc.Iterable, list):
        return _sequence_misfit(value, hint, path)
    if kind is collections.abc.Callable:
        return None if callable(value) else (path, value, hint)
    if kind in (collections.abc.Mapping, dict):
        if not isinstance(value, Mapping):
            return path, value, hint
        for key, item in list(value.items())[:_LOOKED_AT]:
            if inner and (wrong := _misfit(key, inner[0], f"a key of {path}")):
                return wrong
            if inner and (wrong := _misfit(item, inner[1], f"{path}[{key!r}]")):
                return wrong
        return None
    return None if not isinstance(kind, type) or isinstance(value, kind) else (path, value, hint)


def _sequence_misfit(value: Any, hint: Any, path: str) -> tuple[str, Any, Any] | None:
    inner = typing.get_args(hint)
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Sequence | np.ndarray):
        is_lazy = isinstance(value, collections.abc.Iterable) and not isinstance(
            value, str | bytes | Mapping
        )
        takes_any = typing.get_origin(hint) is collections.abc.Iterable
        return None if is_lazy and takes_any else (path, value, hint)
    if isinstance(value, np.ndarray) and not (value.ndim and inner and _takes_numbers(inner[0])):
        return path, value, hint
    fixed = typing.get_origin(hint) is tuple and not (len(inner) == 2 and inner[1] is Ellipsis)
    if fixed and inner and len(value) != len(inner):
        return path, value, hint
    for index, item in enumerate(value[:_LOOKED_AT]):
        wanted = inner[index] if fixed else inner[0] if inner else Any
        if wrong := _misfit(item, wanted, f"{path}[{index}]"):
            return wrong
    return None


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


def _words(hint: Any) -> str:
    """A type in words, for a sentence."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in _UNIONS:
        words = dict.fromkeys(_words(one) for one in inner)
        return " or ".join(words)
    if origin is typing.Literal:
        return " or ".join(repr(one) for one in inner)
    kind = origin or hint
    if kind in _SCALARS:
        return _SCALARS[kind][1]
    if kind is np.ndarray:
        return "array of numbers"
    if kind is tuple and inner and inner[-1] is not Ellipsis:
        return f"({', '.join(map(_words, inner))})"
    if kind in (tuple, list, collections.abc.Sequence, collections.abc.Iterable):
        return f"list ({_words(inner[0])}, …)" if inner and inner[0] is not Any else "list"
    if kind is collections.abc.Callable:
        return "function"
    if kind in (collections.abc.Mapping, dict):
        return f"mapping {{{_words(inner[0])}: {_words(inner[1])}}}" if inner else "mapping"
    if hint is Any:
        return "value"
    return "expectation" if kind.__name__ == "Expectation" else str(kind.__name__)


def _remedy(name: str, value: Any, hint: Any) -> str:
    options = typing.get_args(hint) if typing.get_origin(hint) in _UNIONS else (hint,)
    for option in options:
        kind, inner = typing.get_origin(option), typing.get_args(option)
        if kind not in (tuple, collections.abc.Sequence) or _misfit(value, inner[0], name):
            continue
        if kind is tuple and len(inner) > 1 and len(set(inner)) == 1:
            return f"{name}=({', '.join([repr(value)] * len(inner))})"
        if not isinstance(value, Sequence):
            return f"put it into a list: {name}=[…]"
    return f"{name} takes {_words(hint)}"


def _shown(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…"
