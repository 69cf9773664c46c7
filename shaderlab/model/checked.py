"""Fields and arguments that must have the types they are annotated with, checked when they are
given: a mistake in a case fails where it was written, in one sentence."""

import collections.abc
import functools
import inspect
import numbers
import re
import types
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from itertools import chain, islice
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from shaderlab.errors import CaseError

UNIONS = (typing.Union, types.UnionType)
SEQUENCES = (tuple, list, collections.abc.Sequence)
# What stands for a scalar type: NumPy's numbers do for Python's.
SCALARS: dict[type, Any] = {bool: (bool, np.bool_), int: numbers.Integral, float: numbers.Real}
# Of a long sequence or mapping the first elements are checked.
MOST_ELEMENTS = 64
SHOWN = 60
TOO_LARGE = 2**1024
"""The first integer that is no float."""
UNMASK = "give numbers for what is masked: numpy.ma.filled(values, 0.0)"

Function = TypeVar("Function", bound=Callable[..., Any])


class Misfit(NamedTuple):
    """A part of a value that has not its type, and the place where it is, such as `size[0]`."""

    place: str
    part: Any
    hint: Any


class Checked:
    """Base of dataclasses whose fields must have the types that they are annotated with.

    They are checked first. The `__post_init__` of each class follows, a base's before a derived
    one's; none has to call another.
    """

    def __init_subclass__(cls, **given: Any) -> None:
        super().__init_subclass__(**given)
        own = cls.__dict__.get("__post_init__")
        if own is not None:

            @functools.wraps(own)
            def checked(self: Checked) -> None:
                super(cls, self).__post_init__()  # type: ignore[misc]
                own(self)

            cls.__post_init__ = checked  # type: ignore[method-assign]

    def __post_init__(self) -> None:
        """Raise CaseError for the first field whose value has not its type."""
        kind: Any = type(self)
        for name, default, hint in _fields(kind):
            value = self.__dict__[name]
            if value is not default:  # most are, and scenes have thousands
                _check(kind, name, value, hint)


def checked_arguments(function: Function) -> Function:
    """A function that checks the types of its arguments first, as `Checked` does."""
    signature = inspect.signature(function)
    hints = functools.cache(lambda: typing.get_type_hints(function))

    @functools.wraps(function)
    def checked(*arguments: Any, **named: Any) -> Any:
        for name, value in signature.bind(*arguments, **named).arguments.items():
            several = signature.parameters[name].kind == inspect.Parameter.VAR_POSITIONAL
            for item in value if several else (value,):
                _check(function, name, item, hints()[name])
        return function(*arguments, **named)

    return cast(Function, checked)


def check_arguments(function: Callable[..., Any], /, **given: Any) -> None:
    """Check the types of some arguments of a function that calls this, for it needs its caller."""
    for name, value in given.items():
        _check(function, name, value, typing.get_type_hints(function)[name])


def find_misfit(value: Any, hint: Any, place: str) -> Misfit | None:
    """Find the part of a value that is not of its type; None if there is none.

    Lists do for tuples, NumPy's numbers and arrays for Python's. Types that say nothing of their
    values at run time, type variables for instance, take every value.
    """
    if type(value) is hint:
        return None
    kind, inner = _parts(hint)
    wrong = Misfit(place, value, hint)
    if kind in UNIONS:
        for one in inner:
            found = find_misfit(value, one, place)
            if found is None:
                return None
            if len(found.place) > len(wrong.place):
                wrong = found  # that alternative is meant which fits the outer part
        return wrong
    if kind in SEQUENCES or kind is collections.abc.Mapping:
        elements = _elements(value, kind, inner, place)
        if elements is None:
            return wrong
        misfits = (find_misfit(*element) for element in elements)
        return next((each for each in misfits if each), None)
    fits = True
    if kind is typing.Literal:
        fits = any(type(value) is type(one) and value == one for one in inner)
    elif kind is np.ndarray:
        fits = is_array(value)
    elif kind is collections.abc.Callable:
        fits = callable(value)
    elif isinstance(kind, type) and kind is not Any:
        fits = isinstance(value, SCALARS.get(kind, kind))
        fits &= kind is not float or not isinstance(value, int) or abs(value) < TOO_LARGE
    return None if fits else wrong


def describe_type(hint: Any) -> str:
    """A type in words, for a sentence.

    >>> describe_type(tuple[int, int] | None), describe_type(Sequence[str])
    ('(int, int) or None', 'list of str')
    """
    kind, inner = _parts(hint)
    if kind in UNIONS or kind is typing.Literal:
        words = (describe_type(one) if kind in UNIONS else repr(one) for one in inner)
        return " or ".join(dict.fromkeys(words))
    if kind is tuple and Ellipsis not in inner:
        return f"({', '.join(map(describe_type, inner))})"
    if kind in SEQUENCES:
        return "list" if inner[0] is Any else f"list of {describe_type(inner[0])}"
    if kind is collections.abc.Mapping:
        return f"mapping of {' to '.join(map(describe_type, inner))}"
    names = {np.ndarray: "array of numbers", Callable: "function", type(None): "None"}
    return names.get(kind) or str(kind.__name__)


@functools.cache
def _parts(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    return typing.get_origin(hint) or hint, typing.get_args(hint)


def _elements(
    value: Any, kind: Any, inner: Sequence[Any], place: str
) -> Iterable[tuple[Any, Any, str]] | None:
    """The first elements of a sequence or mapping with their types and places, but for those that
    plainly have their type; None if it is none."""
    if kind is collections.abc.Mapping:
        if not isinstance(value, Mapping):
            return None
        key, item = inner
        keys = ((each, key, f"a key of {place}") for each in value)
        items = ((each, item, f"{place}[{k!r}]") for k, each in value.items())
        return islice(chain(keys, items), MOST_ELEMENTS)
    array = isinstance(value, np.ndarray) and value.ndim > 0
    if not (array or isinstance(value, Sequence)) or isinstance(value, str | bytes):
        return None
    hints = inner if kind is tuple and Ellipsis not in inner else [inner[0]] * len(value)
    if len(hints) != len(value):
        return None
    first = zip(range(MOST_ELEMENTS), value, hints, strict=False)
    return ((one, each, f"{place}[{k}]") for k, one, each in first if type(one) is not each)


def is_array(value: Any) -> bool:
    """Whether a value is an array of numbers, or sequences that make one."""
    if isinstance(value, str | bytes) or not isinstance(value, np.ndarray | Sequence):
        return False
    try:
        return np.asarray(value).dtype.kind in "fiub"
    except ValueError:  # rows of several lengths
        return False


def _check(owner: Any, name: str, value: Any, hint: Any) -> None:
    wrong = find_misfit(value, hint, name)
    if wrong is not None:
        shown = " ".join(repr(wrong.part).split())
        shown = shown if len(shown) <= SHOWN else f"{shown[: SHOWN - 1]}…"
        raise CaseError(
            f"{_public_name(owner)}: {wrong.place} is {shown}; expected {describe_type(wrong.hint)}"
        )
    require_unmasked(value, f"{_public_name(owner)}: {name}")


def is_masked(value: Any) -> bool:
    """Whether an array, or a number, hides a part of itself: `numpy.ma.is_masked`, which takes
    longer to import than most cases to judge."""
    return isinstance(value, np.ndarray) and bool(np.any(getattr(value, "mask", False)))


def require_unmasked(value: Any, place: str) -> None:
    """Raise CaseError where a part of a value is masked: NumPy would take the hidden number."""
    if isinstance(value, Mapping):
        for name, each in value.items():
            require_unmasked(each, f"{place}[{name!r}]")
    elif isinstance(value, list | tuple):
        for number, each in enumerate(value):
            if type(each) not in (float, int):  # as most are
                require_unmasked(each, f"{place}[{number}]")
    elif is_masked(value):
        raise CaseError(f"{place} holds a masked value, which is no number", remedy=UNMASK)


@functools.cache
def _fields(kind: type) -> list[tuple[str, Any, Any]]:
    hints = typing.get_type_hints(kind)
    known: Any = kind
    return [(each.name, each.default, hints[each.name]) for each in fields(known) if each.init]


def _public_name(kind: Any) -> str:
    """A function or class as case files name it: expectations are called by functions' names."""
    name: str = kind.__name__
    is_called = hasattr(kind, "kind") or hasattr(kind, "title")  # of expectations, or of laws
    return re.sub("(?<=[a-z])(?=[A-Z])", "_", name).lower() if is_called else name
