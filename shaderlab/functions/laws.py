"""The laws that GLSL functions are checked by: those of `shaderlab.engine.judging.laws`, and those
that call another function, or this one again with what it gave."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.engine.judging.laws import Close, Finding, Law
from shaderlab.errors import CallError
from shaderlab.functions.call import Call

if TYPE_CHECKING:
    from shaderlab.functions.library import Function


class CallLaw(ABC):
    """A law that is judged by calling functions."""

    @property
    def title(self) -> str:
        """What failures call it."""
        return type(self).__name__.lower()

    @abstractmethod
    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        """Judge a function.

        Args:
            function: what is judged.
            call: the arguments.
            got: what the function gave for them.
        """


@dataclass(frozen=True)
class Inverse(Close, CallLaw):
    """`other` gives an argument back: other(f(x)) = x, for the first parameter or `argument`."""

    other: Callable[..., Any]
    argument: str = ""

    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        x = np.asarray(_argument(function, call, self.argument))
        back = np.asarray(self.other(got))
        x = np.broadcast_to(x, back.shape)
        trivial = "it returns its argument" if back.size and np.array_equal(got, x) else ""
        return self.compare(back, x, trivial)


@dataclass(frozen=True)
class Idempotent(Close, CallLaw):
    """f(f(x)) = f(x), in the first parameter or `argument`."""

    argument: str = ""

    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        name = self.argument or call.signature.given[0].name
        again = np.asarray(function.call_again(call, {name: got}))
        x = _argument(function, call, name)
        trivial = "it returns its argument" if np.array_equal(np.asarray(got), x) else ""
        return self.compare(again, got, trivial)


@dataclass(frozen=True)
class SameAs(Close, CallLaw):
    """The value of another function, of GLSL or of Python, for the same arguments."""

    other: Callable[..., Any]

    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        from shaderlab.functions.library import Function

        values = {**call.opaque, **{name: a.value for name, a in call.values.items()}}
        arguments = [values.pop(p.name) for p in call.signature.given]
        if isinstance(self.other, Function):
            reads = {g.name for s in self.other.signatures for g in s.globals}
            named = {name: value for name, value in values.items() if name in reads}
            expected = np.asarray(self.other(*arguments, **named))
        else:
            expected = np.asarray(self.other(*arguments))
        return self.compare(got, expected)


@dataclass(frozen=True)
class Table(Close, CallLaw):
    """Known values, one for each element. With `digits`, they are figures printed so: a value
    has to round to its figure."""

    values: Any
    _: KW_ONLY
    digits: int | None = None

    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        measured, expected = np.asarray(got), np.asarray(self.values)
        if expected.shape != measured.shape:
            raise CallError(
                f"table: has shape {expected.shape}, the function returns {measured.shape}"
            )
        close: Close = self
        if self.digits is not None:
            close = Close(within=0.5 * 10.0**-self.digits * (1.0 + 1e-6))
        return close.compare(measured, expected)


inverse, idempotent, same_as, table = Inverse, Idempotent, SameAs, Table


def judge_law(law: Law | CallLaw, function: Function, call: Call, got: Any) -> Finding:
    """Judge what a function gave for a call."""
    if isinstance(law, CallLaw):
        return law.judge_call(function, call, got)
    inputs = {name: _argument(function, call, name) for name in law.inputs}
    changes = law.second_inputs(inputs)
    second = np.asarray(function.call_again(call, changes)) if changes else None
    return law.judge(inputs, np.asarray(got), second, call.batch)


def _argument(function: Function, call: Call, name: str) -> Any:
    """An argument's own array, as the function got it; the first one's if `name` is empty. Raises
    CallError."""
    argument = call.values.get(name or call.signature.given[0].name)
    if argument is None or argument.type.members:
        known = ", ".join(n for n, a in call.values.items() if not a.type.members)
        message = f"{function.__name__} gets no numbers named {name!r}"
        raise CallError(message, remedy=f"there is: {known}")
    return argument.value
