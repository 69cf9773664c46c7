"""`shaderlab.lazy_dataclass.dataclass` makes what `dataclasses.dataclass` makes, and later."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, FrozenInstanceError, field
from typing import Any, ClassVar

import pytest

from shaderlab import lazy_dataclass

BOTH = [dataclasses.dataclass, lazy_dataclass.dataclass]


def classes(dataclass: Callable[..., Any]) -> list[Any]:
    """Of every kind that the lab has."""

    @dataclass(frozen=True)
    class Frozen:
        number: int
        named: ClassVar[str] = "all"
        _: KW_ONLY
        words: tuple[str, ...] = ()
        table: Mapping[str, int] = field(default_factory=dict, compare=False)
        made: int = field(default=3, init=False, repr=False)
        missing: list[int] = field(default_factory=list, compare=False)

        def __post_init__(self) -> None:
            object.__setattr__(self, "made", self.number + 1)

    @dataclass(frozen=True)
    class Derived(Frozen):
        more: float = 0.5

    @dataclass
    class Open:
        number: int = 1

    @dataclass(eq=False)
    class Same:
        number: int = 1

    @dataclass(frozen=True, kw_only=True, repr=False)
    class Own:
        number: int = 1

        def __eq__(self, other: object) -> bool:
            return other == "own"

        def __repr__(self) -> str:
            return "own"

    @dataclass(frozen=True, slots=True)
    class Slots:
        number: int = 1

    return [Frozen, Derived, Open, Same, Own, Slots]


@pytest.mark.parametrize("number", range(6))
def test_it_is_what_the_standard_library_makes(number: int) -> None:
    def seen(cls: Any) -> list[object]:
        one, other, third = cls(number=1), cls(number=1), cls(number=2)
        said: list[object] = [
            str(inspect.signature(cls)),
            [(f.name, f.type, f.kw_only, f.init) for f in dataclasses.fields(cls)],
            cls.__dataclass_params__.frozen,
            cls.__match_args__,
            (repr(one), vars(cls).get("__hash__", "its base's") is None),
            (one == other, one == third, one == 5, one == "own"),
            dataclasses.replace(one, number=4).number,
            copy.copy(one) == one,
            cls.__init__.__qualname__,
        ]
        for wrong in (lambda: cls(number=1, nothing=2), lambda: cls(1, 2, 3, 4)):
            with pytest.raises(TypeError) as caught:
                wrong()
            said.append(str(caught.value))
        if cls.__hash__ is not None and cls.__eq__ is not object.__eq__:
            said.append((hash(one) == hash(other), len({one, other, third})))
        for change in (lambda: setattr(one, "number", 7), lambda: delattr(one, "number")):
            try:
                change()
            except FrozenInstanceError as error:
                said.append(str(error))
        return said

    theirs, ours = (seen(classes(dataclass)[number]) for dataclass in BOTH)
    assert ours == theirs


def test_the_standard_library_derives_from_it() -> None:
    base = classes(lazy_dataclass.dataclass)[0]

    @dataclasses.dataclass(frozen=True)
    class Theirs(base):
        more: int = 2

    assert (Theirs(1).more, Theirs(1).made, Theirs(1) == Theirs(1)) == (2, 2, True)
    with pytest.raises(TypeError, match="non-frozen dataclass from a frozen"):
        dataclasses.dataclass(type("Wrong", (base,), {}))


def test_methods_wait_until_they_are_used() -> None:
    cls = classes(lazy_dataclass.dataclass)[0]
    lazy = lazy_dataclass._LazyMethod

    def waiting() -> set[str]:
        return {name for name, value in vars(cls).items() if isinstance(value, lazy)}

    assert waiting() == {"__init__", "__repr__", "__eq__", "__hash__"}
    one = cls(1)
    assert waiting() == {"__repr__", "__eq__", "__hash__"}
    hash(one)
    assert waiting() == {"__repr__", "__eq__"}


def test_records_cross_processes() -> None:
    from shaderlab.errors import CaseError
    from shaderlab.execution.jobs import CaseFacts

    facts = CaseFacts(file="a.py", id="a", error=CaseError("wrong"))
    assert repr(pickle.loads(pickle.dumps(facts))) == repr(facts)
