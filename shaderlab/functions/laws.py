"""What can hold of a function without a reference: laws, other functions, known values."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.errors import CallError
from shaderlab.functions.binding import Call
from shaderlab.model.frame import Array

if TYPE_CHECKING:
    from shaderlab.functions.function import Function


@dataclass(frozen=True)
class Finding:
    """How a law fares at each element of a call.

    Attributes:
        holds: over the call's batch; for a law of neighbours, of the later of each two.
        got: the values that the law is about, (batch…, components…).
        expected: as many values, or in words what they should be.
        trivial: why it could hardly fail here; "" if it could.
    """

    holds: Array
    got: Array
    expected: Array | str
    trivial: str = ""


class Law(ABC):
    """Something that must hold of a function at all arguments."""

    @property
    def name(self) -> str:
        """What failures call it."""
        return type(self).__name__.lower()

    @abstractmethod
    def judge(self, function: Function, call: Call, got: Any) -> Finding:
        """Judge it.

        Args:
            function: what is judged.
            call: the arguments.
            got: what the function gave for them.
        """


@dataclass(frozen=True)
class Close:
    """How far two values may lie apart: so many units in the last place, or that much."""

    _: KW_ONLY
    ulp: float = 0.0
    within: float = 0.0

    def holds(self, got: Array, expected: Array, batch: tuple[int, ...]) -> Array:
        """Over the batch, whether all components are close; NaN is close to NaN alone."""
        a, b = np.asarray(got), np.asarray(expected)
        a, b = np.broadcast_arrays(a, b)
        with np.errstate(all="ignore"):
            last = np.spacing(np.abs(b).astype(np.float32)).astype(np.float64)
            apart = np.abs(a.astype(np.float64) - b.astype(np.float64))
            near = (a == b) | (apart <= np.fmax(self.ulp * last, self.within))
        if a.dtype.kind == "f":
            near |= np.isnan(a) & np.isnan(b)
        return _over(near, batch)


def _over(holds: Array, batch: tuple[int, ...]) -> Array:
    """Whether something holds of all components of each element."""
    return np.asarray(holds.all(axis=tuple(range(len(batch), holds.ndim))))


@dataclass(frozen=True)
class Bounded(Law):
    """Every value lies from `low` to `high`, both included; so NaN fails. They are numbers, or
    arrays of one for each component."""

    low: Any = -np.inf
    high: Any = np.inf

    def __post_init__(self) -> None:
        if np.all(np.isinf(self.low)) and np.all(np.isinf(self.high)):
            raise CallError("bounded: give low, high or both")

    def judge(self, function: Function, call: Call, got: Any) -> Finding:
        values = np.asarray(got)
        with np.errstate(invalid="ignore"):
            holds = (values >= np.float32(self.low)) & (values <= np.float32(self.high))
        return Finding(_over(holds, call.batch), values, f"{self.low} … {self.high}")


@dataclass(frozen=True)
class Monotone(Law):
    """The values never fall as the argument `along` grows; with `rising=False` they never rise."""

    along: str
    _: KW_ONLY
    rising: bool = True
    strictly: bool = False

    def judge(self, function: Function, call: Call, got: Any) -> Finding:
        values = np.asarray(got)
        x = _plain(function, call, self.along)
        axes = [n for n in range(-x.ndim, 0) if x.shape[n] > 1]
        if len(axes) != 1:
            raise CallError(
                f"monotone: {self.along} has shape {x.shape}", remedy="give it values along an axis"
            )
        axis = len(call.batch) + axes[0]
        order = np.argsort(x.reshape(-1), kind="stable")
        ordered = np.take(values, order, axis=axis)
        steps = np.diff(ordered.astype(np.float64), axis=axis)
        steps = steps if self.rising else -steps
        right = steps > 0.0 if self.strictly else steps >= 0.0
        first = np.ones_like(np.take(right, [0], axis=axis))
        back = np.argsort(order, kind="stable")
        holds = np.take(np.concatenate([first, right], axis=axis), back, axis=axis)
        before = np.take(ordered, np.maximum(back - 1, 0), axis=axis)
        still = bool((values == values.reshape(-1)[:1]).all())
        return Finding(
            _over(holds, call.batch),
            values,
            before,
            "it is the same at all values" if still else "",
        )


@dataclass(frozen=True)
class Symmetric(Close, Law):
    """The value is the same with two arguments exchanged."""

    first: str
    second: str

    def judge(self, function: Function, call: Call, got: Any) -> Finding:
        a, b = (_plain(function, call, name) for name in (self.first, self.second))
        other = function.again(call, {self.first: b, self.second: a})
        same = np.shape(a) == np.shape(b) and bool((a == b).all())
        trivial = f"{self.first} and {self.second} are equal" if same else ""
        return Finding(self.holds(got, other, call.batch), np.asarray(got), other, trivial)


@dataclass(frozen=True)
class Mirrored(Close, Law):
    """f(−x) = sign · f(x)."""

    argument: str
    sign: int

    @property
    def name(self) -> str:
        return "even" if self.sign > 0 else "odd"

    def judge(self, function: Function, call: Call, got: Any) -> Finding:
        x = _plain(function, call, self.argument)
        other = self.sign * np.asarray(function.again(call, {self.argument: -x}))
        trivial = "" if np.any(x) else f"{self.argument} is 0"
        return Finding(self.holds(got, other, call.batch), np.asarray(got), other, trivial)


@dataclass(frozen=True)
class Inverse(Close, Law):
    """`other` gives an argument back: other(f(x)) = x, for the first parameter or `argument`."""

    other: Callable[..., Any]
    argument: str = ""

    def judge(self, function: Function, call: Call, got: Any) -> Finding:
        name = self.argument or call.signature.given[0].name
        x = np.asarray(_plain(function, call, name))
        back = np.asarray(self.other(got))
        x = np.broadcast_to(x, back.shape)
        trivial = "it gives its argument" if back.size and np.array_equal(got, x) else ""
        return Finding(self.holds(back, x, call.batch), back, x, trivial)


@dataclass(frozen=True)
class Idempotent(Close, Law):
    """f(f(x)) = f(x), in the first parameter or `argument`."""

    argument: str = ""

    def judge(self, function: Function, call: Call, got: Any) -> Finding:
        name = self.argument or call.signature.given[0].name
        again = np.asarray(function.again(call, {name: got}))
        x = _plain(function, call, name)
        trivial = "it gives its argument" if np.array_equal(np.asarray(got), x) else ""
        return Finding(self.holds(again, np.asarray(got), call.batch), again, got, trivial)


@dataclass(frozen=True)
class SameAs(Close, Law):
    """The value of another function, of GLSL or of Python, for the same arguments."""

    other: Callable[..., Any]

    def judge(self, function: Function, call: Call, got: Any) -> Finding:
        from shaderlab.functions.function import Function

        values = {**call.opaque, **{name: a.value for name, a in call.values.items()}}
        arguments = [values.pop(p.name) for p in call.signature.given]
        if isinstance(self.other, Function):
            reads = {g.name for s in self.other.signatures for g in s.globals}
            named = {name: value for name, value in values.items() if name in reads}
            expected = np.asarray(self.other(*arguments, **named))
        else:
            expected = np.asarray(self.other(*arguments))
        return Finding(self.holds(got, expected, call.batch), np.asarray(got), expected)


@dataclass(frozen=True)
class Table(Close, Law):
    """Known values, one for each element. With `digits`, they are figures printed so: a value
    has to round to its figure."""

    values: Any
    _: KW_ONLY
    digits: int | None = None

    def judge(self, function: Function, call: Call, got: Any) -> Finding:
        measured, expected = np.asarray(got), np.asarray(self.values)
        if expected.shape != measured.shape:
            raise CallError(
                f"table: has shape {expected.shape}, the function gives {measured.shape}"
            )
        close: Close = self
        if self.digits is not None:
            close = Close(within=0.5 * 10.0**-self.digits * (1.0 + 1e-6))
        return Finding(close.holds(measured, expected, call.batch), measured, expected)


bounded, monotone, symmetric, inverse = Bounded, Monotone, Symmetric, Inverse
idempotent, same_as, table = Idempotent, SameAs, Table


def even(argument: str, *, ulp: float = 0.0, within: float = 0.0) -> Law:
    """f(−x) = f(x)."""
    return Mirrored(argument, 1, ulp=ulp, within=within)


def odd(argument: str, *, ulp: float = 0.0, within: float = 0.0) -> Law:
    """f(−x) = −f(x)."""
    return Mirrored(argument, -1, ulp=ulp, within=within)


def _plain(function: Function, call: Call, name: str) -> Any:
    """An argument's own array, as the function got it. Raises CallError."""
    found = call.values.get(name)
    if found is None or found.type.members:
        known = ", ".join(n for n, a in call.values.items() if not a.type.members)
        message = f"{function.__name__} gets no numbers named {name!r}"
        raise CallError(message, remedy=f"there is: {known}")
    return found.value
