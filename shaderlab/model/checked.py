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
import re
import sys
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from typing import Any, TypeVar, cast

import numpy as np

from shaderlab.errors import CaseError, nearest
from shaderlab.model.type_checks import SCALARS, UNIONS, Check, Misfit, type_check

_SHOWN = 60


@dataclass(frozen=True)
class _Wanted:
    """An annotated type, and the function that checks values for it."""

    hint: Any
    check: Check


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
        given = self.__dict__
        for name, (default, wanted) in _fields(kind).items():
            value = given[name]
            if value is default:  # most are, and scenes have thousands
                continue
            wrong = wanted.check(value)
            if wrong is not None:
                others = {other: each for other, (_, each) in _fields(kind).items()}
                raise _error(_called(kind), name, value, others, wrong)


Function = TypeVar("Function", bound=Callable[..., Any])


def checked_arguments(function: Function) -> Function:
    """A function that looks at the types of its arguments first, as `Checked` does."""
    signature = inspect.signature(function)
    keywords = {p.name for p in signature.parameters.values() if p.kind == p.VAR_KEYWORD}
    variadic = {p.name for p in signature.parameters.values() if p.kind == p.VAR_POSITIONAL}

    @functools.cache
    def hints() -> Mapping[str, _Wanted]:  # once it is called: its module is whole then
        return _wanted(_evaluated(function.__annotations__, function.__module__))

    @functools.wraps(function)
    def checked(*arguments: Any, **named: Any) -> Any:
        try:
            given = signature.bind(*arguments, **named).arguments
        except TypeError:
            return function(*arguments, **named)  # which says it with its name
        for name, value in given.items():
            if name in keywords:
                (known,) = typing.get_args(hints()[name].hint)
                _require_keywords(function.__name__, value, known)
            elif name in hints():
                for item in value if name in variadic else (value,):
                    _require(function.__name__, name, item, hints())
        return function(*arguments, **named)

    return cast(Function, checked)


def _require_keywords(owner: str, given: Mapping[str, Any], known: type) -> None:
    """As `_require`, for keywords that a TypedDict has."""
    hints = _keywords(known)
    for name, value in given.items():
        if name not in hints:
            raise CaseError(f"{owner}: takes no {name!r}", remedy=nearest(name, hints))
        _require(owner, name, value, hints)


def _require(owner: str, name: str, value: Any, hints: Mapping[str, _Wanted]) -> None:
    wrong = hints[name].check(value)
    if wrong is not None:
        raise _error(owner, name, value, hints, wrong)


def _error(
    owner: str, name: str, value: Any, hints: Mapping[str, _Wanted], wrong: Misfit
) -> CaseError:
    place = wrong.place.format(name)
    remedy = _wrapped(wrong.part, wrong.hint) or _elsewhere(value, wrong.part, hints)
    return CaseError(
        f"{owner}: {place} is {_shown(wrong.part)}, which is no {_words(wrong.hint)}",
        remedy=remedy or _remedy(name, value, hints[name].hint),
    )


def _called(kind: type) -> str:
    """A class as case files name it: an expectation is called by a function's name."""
    name = kind.__name__
    return re.sub("(?<=[a-z])(?=[A-Z])", "_", name).lower() if hasattr(kind, "kind") else name


def _wanted(hints: Mapping[str, Any]) -> dict[str, _Wanted]:
    return {name: _Wanted(hint, type_check(hint)) for name, hint in hints.items()}


@functools.cache
def _fields(kind: type) -> dict[str, tuple[Any, _Wanted]]:
    """A dataclass's fields, their defaults and types, without what only type checkers know."""
    found: dict[str, Any] = {}
    for owner in reversed(kind.__mro__):
        found |= _evaluated(vars(owner).get("__annotations__", {}), owner.__module__)
    defaults = {field.name: field.default for field in fields(kind) if field.init}
    wanted = _wanted({name: found[name] for name in defaults if name in found})
    return {name: (defaults[name], each) for name, each in wanted.items()}


@functools.cache
def _keywords(known: type) -> dict[str, _Wanted]:
    """The types of a TypedDict's keys."""
    return _wanted(_evaluated(known.__annotations__, known.__module__))


def _evaluated(annotations: Mapping[str, Any], module: str) -> dict[str, Any]:
    """The types that annotations of a module name."""
    scope, found = dict(vars(sys.modules.get(module, builtins))), {}
    for name, text in annotations.items():
        with contextlib.suppress(NameError, TypeError, AttributeError):
            text = getattr(text, "__forward_arg__", text)  # as a TypedDict has it
            found[name] = eval(text, scope) if isinstance(text, str) else text
    return found


def _words(hint: Any) -> str:
    """A type in words, for a sentence."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in UNIONS:
        words = dict.fromkeys(_words(one) for one in inner)
        return " or ".join(words)
    if origin is typing.Literal:
        return " or ".join(repr(one) for one in inner)
    kind = origin or hint
    if kind in SCALARS:
        return SCALARS[kind][1]
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


def _options(hint: Any) -> tuple[Any, ...]:
    """A union's types, or the one type."""
    return typing.get_args(hint) if typing.get_origin(hint) in UNIONS else (hint,)


def _remedy(name: str, value: Any, hint: Any) -> str:
    for option in _options(hint):
        kind, inner = typing.get_origin(option), typing.get_args(option)
        if kind not in (tuple, collections.abc.Sequence) or type_check(inner[0])(value):
            continue
        if kind is tuple and len(inner) > 1 and len(set(inner)) == 1:
            return f"{name}=({', '.join([repr(value)] * len(inner))})"
        if not isinstance(value, Sequence):
            return f"put it into a list: {name}=[…]"
    return f"{name} takes {_words(hint)}"


def _elsewhere(value: Any, part: Any, hints: Mapping[str, _Wanted]) -> str:
    """Which other argument takes what a mapping holds: a texture that is given as a uniform."""
    items = value.items() if isinstance(value, Mapping) else ()
    key = next((key for key, item in items if item is part), None)
    for name, wanted in hints.items():
        mapping = any(typing.get_origin(one) is Mapping for one in _options(wanted.hint))
        if key is not None and mapping and wanted.check({key: part}) is None:
            return f"give it as {name}={{{key!r}: …}}"
    return ""


def _wrapped(part: Any, hint: Any) -> str:
    """Which of the classes that are asked for can be made of a value: of an array a texture."""
    for kind in _options(hint):
        if isinstance(kind, type) and issubclass(kind, Checked):
            for name, (default, wanted) in _fields(cast(Any, kind)).items():
                if default is MISSING and wanted.hint is not Any and wanted.check(part) is None:
                    return f"give {kind.__name__}({name}=…)"
    return ""


def _shown(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…"
