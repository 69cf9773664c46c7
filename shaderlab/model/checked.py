"""Whether a value has an annotated type: each annotation is read once, and becomes a function."""

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
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from shaderlab.errors import CaseError, nearest

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
