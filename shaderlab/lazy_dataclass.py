"""`dataclass` as the standard library has it, but that its methods are compiled when they are used.

`dataclasses.dataclass` compiles up to six methods of a class as it is defined, which takes a third
of a millisecond: of what a worker imports it was a third. Most are never called in one process.
"""

from __future__ import annotations

import dataclasses
import reprlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

_OPTION_OF = {"__init__": "init", "__repr__": "repr", "__eq__": "eq"}
"""Methods that are compiled late, by name: the option that asks for each."""


class _Missing:
    """The default of what a factory makes, as signatures show it."""

    def __repr__(self) -> str:
        return "<factory>"


_MISSING = _Missing()


class _LazyMethod:
    """Stands for a method in a class until it is first looked up, and gives its place to it."""

    def __init__(self, owner: type, name: str) -> None:
        self._owner = owner
        self._name = name

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        method = _compiled(self._owner, self._name)
        setattr(self._owner, self._name, method)
        return method.__get__(instance, owner)


if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(
        cls=None, *, init=True, repr=True, eq=True, frozen=False, kw_only=False, slots=False
    ):
        """As `dataclasses.dataclass`, with those of its options that the lab uses."""
        options = {"init": init, "repr": repr, "eq": eq, "frozen": frozen, "kw_only": kw_only}

        def decorated(cls):
            if slots:  # another class takes its place
                return dataclasses.dataclass(cls, **options, slots=True)
            return _with_lazy_methods(cls, options)

        return decorated if cls is None else decorated(cls)


def _with_lazy_methods(cls: Any, options: dict[str, bool]) -> Any:
    own = dict(vars(cls))
    if cls.__doc__ is None:
        cls.__doc__ = cls.__name__  # `dataclasses` would write its signature, which takes longer
    frozen = options["frozen"]
    # What is derived from a frozen class has to say that it is frozen as well.
    derived = any(map(dataclasses.is_dataclass, cls.__mro__[1:]))
    none = dict.fromkeys(_OPTION_OF.values(), False)
    dataclasses.dataclass(cls, **{**options, **none, "frozen": frozen and derived})
    for option in (*none, "frozen"):
        setattr(cls.__dataclass_params__, option, options[option])
    if frozen and not derived:
        cls.__setattr__, cls.__delattr__ = _refusing(cls)
    late = [name for name, option in _OPTION_OF.items() if options[option] and name not in own]
    if options["eq"] and (
        own.get("__hash__") is None and ("__eq__" in own or "__hash__" not in own)
    ):
        if frozen:
            late.append("__hash__")
        else:
            cls.__hash__ = None
    for name in late:
        setattr(cls, name, _LazyMethod(cls, name))
    return cls


def _compiled(owner: Any, name: str) -> Callable[..., Any]:
    """A method as `dataclasses` defines it."""
    fields = dataclasses.fields(owner)
    known: dict[str, Any] = {}
    if name == "__init__":
        head, lines, known = _initializer(owner)
    elif name == "__repr__":
        shown = ", ".join(f"{f.name}={{self.{f.name}!r}}" for f in fields if f.repr)
        head, lines = "self", [f'return f"{{self.__class__.__qualname__}}({shown})"']
    elif name == "__hash__":
        hashed = [f.name for f in fields if (f.compare if f.hash is None else f.hash)]
        head, lines = "self", [f"return hash({_values('self', hashed)})"]
    else:
        compared = [f.name for f in fields if f.compare]
        equal = f"{_values('self', compared)} == {_values('other', compared)}"
        same = "other.__class__ is self.__class__"
        head, lines = "self, other", [f"return {equal} if {same} else NotImplemented"]
    # A function in another one: what it knows are no names of a module.
    body = "\n  ".join(lines)
    made: dict[str, Any] = {}
    exec(f"def made({', '.join(known)}):\n def {name}({head}):\n  {body}\n return {name}", made)
    method: Any = made["made"](**known)
    if name == "__repr__":
        method = reprlib.recursive_repr()(method)
    if name == "__init__":
        method.__annotations__ = {f.name: f.type for f in fields if f.init} | {"return": None}
    method.__qualname__ = f"{owner.__qualname__}.{name}"
    method.__module__ = owner.__module__
    return method  # type: ignore[no-any-return]


def _initializer(owner: Any) -> tuple[str, list[str], dict[str, Any]]:
    """The parameters of `__init__`, its lines, and what these know besides."""
    known: dict[str, Any] = {"_missing_": _MISSING, "_set_": object.__setattr__}
    frozen = owner.__dataclass_params__.frozen
    parameters: dict[bool, list[str]] = {False: [], True: []}
    lines = []
    for field in dataclasses.fields(owner):
        name = value = field.name
        default = ""
        if field.default is not dataclasses.MISSING:
            known[f"_default_{name}_"] = field.default
            default = f"=_default_{name}_"
        elif field.default_factory is not dataclasses.MISSING:
            known[f"_make_{name}_"] = field.default_factory
            default = "=_missing_"
            value = f"_make_{name}_()"
            if field.init:
                value += f" if {name} is _missing_ else {name}"
        if field.init:
            parameters[bool(field.kw_only)].append(name + default)
        elif default != "=_missing_":
            continue  # the class has its default
        lines.append(f"_set_(self, {name!r}, {value})" if frozen else f"self.{name} = {value}")
    if hasattr(owner, "__post_init__"):
        lines.append("self.__post_init__()")
    by_name = ["*", *parameters[True]] if parameters[True] else []
    return ", ".join(["self", *parameters[False], *by_name]), lines or ["pass"], known


def _values(of: str, names: list[str]) -> str:
    return f"({''.join(f'{of}.{name}, ' for name in names)})"


def _refusing(cls: Any) -> tuple[Callable[..., None], Callable[..., None]]:
    """`__setattr__` and `__delattr__` of a frozen class."""

    def frozen(instance: object, name: str) -> bool:
        return type(instance) is cls or name in cls.__dataclass_fields__

    def __setattr__(self: object, name: str, value: object) -> None:
        if frozen(self, name):
            raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
        super(cls, self).__setattr__(name, value)

    def __delattr__(self: object, name: str) -> None:
        if frozen(self, name):
            raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")
        super(cls, self).__delattr__(name)

    return __setattr__, __delattr__
