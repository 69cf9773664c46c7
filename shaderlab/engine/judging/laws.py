"""Laws: what must hold of a GLSL function, or of a shader's output, without a reference.

A law judges values that belong to known inputs. Some compare with a second evaluation, such as
f(−x) with f(x): they say what its inputs are, and whoever runs the shader evaluates them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from shaderlab.bands.rounding import LARGEST
from shaderlab.errors import CallError, CaseError
from shaderlab.model.checked import Checked
from shaderlab.model.frame import Array
from shaderlab.model.records import Worst
from shaderlab.model.state import check_choice

from .banded import to_tuple, ulp_distance

Batch = tuple[int, ...]
DIRECTIONS = ("increasing", "decreasing")


@dataclass(frozen=True, kw_only=True)
class Finding:
    """How values fare under a law. All arrays have the shape of `values`, (batch…, components…).

    Attributes:
        values: what the law is about.
        holds: whether each of them keeps the law; of neighbours the later one is meant.
        slack: how far each is from breaking it, negative where it does.
        reference: what each is compared with.
        low, high: the bounds that follow from it.
        trivial: why the law could hardly fail on these inputs; "" if it could.
    """

    values: Array
    holds: Array
    slack: Array
    reference: Array
    low: Any
    high: Any
    trivial: str = ""

    def find_worst(
        self, count: int, inputs: Callable[[int], Mapping[str, tuple[float, ...]]], *, broken: bool
    ) -> Worst:
        """Return the value of `count` elements that is nearest to breaking the law, or furthest
        beyond it; `inputs` gives an element's inputs."""
        slack = self.slack.reshape(count, -1)
        i, c = (int(n) for n in np.unravel_index(int(np.argmin(slack)), slack.shape))
        parts = (self.values, self.reference, self.low, self.high)
        measured, reference, low, high = (
            to_tuple(np.broadcast_to(part, self.values.shape).reshape(count, -1)[i])
            for part in parts
        )
        return Worst(
            pixel=None,
            component=c,
            measured=measured,
            reference=reference,
            low=low,
            high=high,
            ulp=ulp_distance(measured[c], reference[c]),
            widths=math.inf if broken else 0.0,
            inputs=inputs(i),
        )


def fit_shape(values: Any, shape: tuple[int, ...], label: str) -> Array:
    """Numbers in this shape, float64. Raises CallError: they are none, or have another shape."""
    try:
        return np.broadcast_to(np.asarray(values, np.float64), shape)
    except (TypeError, ValueError):
        raise CallError(f"{label} is {values!r:.60}, not numbers of shape {shape}") from None


class Law(Checked, ABC):
    """A property of a function that needs no reference."""

    #: What failures call it.
    title: str
    #: The inputs that it is about, by name.
    inputs: tuple[str, ...] = ()

    def second_inputs(self, inputs: Mapping[str, Array]) -> dict[str, Array]:
        """Return the inputs that change for the second evaluation; none if there is no second."""
        return {}

    @abstractmethod
    def judge(
        self, inputs: Mapping[str, Array], values: Array, second: Array | None, batch: Batch
    ) -> Finding:
        """Hold values (batch…, components…) against the law, and those at `second_inputs`, if there
        are any. The axes of its inputs broadcast with the batch."""


@dataclass(frozen=True)
class Bounded(Law):
    """low ≤ f ≤ high, so that NaN fails, and infinity does also where there is one bound. The
    bounds are numbers, or one for each component; they are rounded to float32, as the shader's own
    constants are. Raises CaseError: there is no bound, or a lower one above its upper one."""

    low: float | Sequence[float] | Array = -np.inf
    high: float | Sequence[float] | Array = np.inf
    title = "bounded"

    def __post_init__(self) -> None:
        if not np.all(np.asarray(self.low, float) <= np.asarray(self.high, float)):
            raise CaseError(f"bounded: there is no number in {self.low} … {self.high}")
        if np.any(np.isinf(self.low) & np.isinf(self.high)):
            raise CaseError("bounded: give low, high or both")

    @property
    def ends(self) -> tuple[Array, Array]:
        """Both bounds as float32 numbers, the largest where there is none."""
        low, high = (
            np.clip(end, -LARGEST, LARGEST).astype(np.float32).astype(np.float64)
            for end in (self.low, self.high)
        )
        return low, high

    def judge(
        self, inputs: Mapping[str, Array], values: Array, second: Array | None, batch: Batch
    ) -> Finding:
        numbers = values.astype(np.float64)
        low, high = (fit_shape(end, values.shape, "a bound") for end in self.ends)
        slack = np.minimum(numbers - low, high - numbers)
        return Finding(
            values=values,
            holds=slack >= 0.0,
            slack=slack,
            reference=np.clip(numbers, low, high),
            low=low,
            high=high,
        )


@dataclass(frozen=True)
class Monotone(Law):
    """f never falls ("increasing") or never rises ("decreasing") as the input `over` grows; with
    `strict` it never stays the same either. Each component is judged by itself, of a vector `over`
    with as many components by its own one."""

    over: str
    _: KW_ONLY
    direction: str = "increasing"
    strict: bool = False
    title = "monotone"

    def __post_init__(self) -> None:
        check_choice("monotone", "direction", self.direction, DIRECTIONS)

    @property
    def inputs(self) -> tuple[str, ...]:  # type: ignore[override]
        return (self.over,)

    def judge(
        self, inputs: Mapping[str, Array], values: Array, second: Array | None, batch: Batch
    ) -> Finding:
        x = np.asarray(inputs[self.over])
        if x.ndim > len(batch) and x.shape[-1] == values.shape[-1] > 1:  # a vector of as many
            return self._judge_components(x, values, batch)
        axes = [n for n in range(-x.ndim, 0) if x.shape[n] > 1]
        if len(axes) != 1:
            raise CallError(
                f"monotone: {self.over} has shape {x.shape}", remedy="give it values along an axis"
            )
        axis = len(batch) + axes[0]
        order = np.argsort(x.reshape(-1), kind="stable")
        ordered = np.take(values, order, axis=axis).astype(np.float64)
        sign = 1.0 if self.direction == "increasing" else -1.0
        steps = sign * np.diff(ordered, axis=axis)
        first = np.full_like(np.take(steps, [0], axis=axis), np.inf)
        back = np.argsort(order, kind="stable")
        slack = np.take(np.concatenate([first, steps], axis=axis), back, axis=axis)
        before = np.take(ordered, np.maximum(back - 1, 0), axis=axis)
        rising = self.direction == "increasing"
        return Finding(
            values=values,
            holds=slack > 0.0 if self.strict else slack >= 0.0,
            slack=slack,
            reference=before,
            low=before if rising else -np.inf,
            high=np.inf if rising else before,
            trivial=_constant(values, batch),
        )

    def _judge_components(self, x: Array, values: Array, batch: Batch) -> Finding:
        """Hold each component against the law as its own component of the input grows."""
        found = [
            vars(self.judge({self.over: x[..., n]}, values[..., n : n + 1], None, batch))
            for n in range(x.shape[-1])
        ]
        arrays = ("values", "holds", "slack", "reference", "low", "high")
        shape = (*batch, 1)
        joined: dict[str, Any] = {
            name: np.concatenate([np.broadcast_to(one[name], shape) for one in found], axis=-1)
            for name in arrays
        }
        return Finding(**joined, trivial=next((o["trivial"] for o in found if o["trivial"]), ""))


@dataclass(frozen=True, kw_only=True)
class Close(Checked):
    """How far two values may lie apart: so many units in the last place (`ulp`), or that much
    (`within`). Raises CaseError: it is negative or infinite."""

    ulp: float = 0.0
    within: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.ulp < 2**23 or not 0.0 <= self.within < np.inf:
            raise CaseError("tolerance: ulp must be at least 0 and below 2²³, within finite")

    def compare(self, values: Array, expected: Any, trivial: str = "") -> Finding:
        """Hold values against others; NaN is close to NaN alone."""
        values = np.asarray(values)
        numbers = values.astype(np.float64)
        other = wanted = fit_shape(expected, values.shape, "what it is compared with")
        with np.errstate(all="ignore"):
            last = np.spacing(np.abs(wanted).astype(np.float32)).astype(np.float64)
            allowed = np.fmax(self.ulp * last, self.within)
            slack = allowed - np.abs(numbers - wanted)
            holds = (values == other) | (slack >= 0.0)
            if values.dtype.kind == "f":
                holds |= np.isnan(values) & np.isnan(wanted)
            return Finding(
                values=values,
                holds=holds,
                slack=np.where(holds, np.fmax(slack, 0.0), slack) / last,
                reference=other,
                low=wanted - allowed,
                high=wanted + allowed,
                trivial=trivial,
            )


@dataclass(frozen=True)
class Symmetric(Close, Law):
    """The value stays the same when one input changes its sign, or two are exchanged; or, with the
    sign −1, it changes its own sign then."""

    inputs: tuple[str, ...]
    sign: int = 1

    @property
    def title(self) -> str:  # type: ignore[override]
        if len(self.inputs) == 1:
            return "even" if self.sign > 0 else "odd"
        return "symmetric" if self.sign > 0 else "antisymmetric"

    def second_inputs(self, inputs: Mapping[str, Array]) -> dict[str, Array]:
        if len(self.inputs) == 1:
            return {name: -np.asarray(inputs[name]) for name in self.inputs}
        first, second = self.inputs
        return {first: inputs[second], second: inputs[first]}

    def find_trivial(self, inputs: Mapping[str, Array]) -> str:
        """Why nothing could break the law at these inputs; "" if something could."""
        if len(self.inputs) == 1:
            return "" if np.any(inputs[self.inputs[0]]) else f"{self.inputs[0]} is 0"
        first, second = self.inputs
        return f"{first} and {second} are equal" * np.array_equal(inputs[first], inputs[second])

    def judge(
        self, inputs: Mapping[str, Array], values: Array, second: Array | None, batch: Batch
    ) -> Finding:
        trivial = self.find_trivial(inputs) or _constant(values, batch)
        return self.compare(values, self.sign * np.asarray(second), trivial)


bounded, monotone = Bounded, Monotone


def even(over: str, *, ulp: float = 0.0, within: float = 0.0) -> Symmetric:
    """f(−x) = f(x)."""
    return Symmetric((over,), 1, ulp=ulp, within=within)


def odd(over: str, *, ulp: float = 0.0, within: float = 0.0) -> Symmetric:
    """f(−x) = −f(x)."""
    return Symmetric((over,), -1, ulp=ulp, within=within)


def symmetric(
    over: tuple[str, str], *old: str, odd: bool = False, ulp: float = 0.0, within: float = 0.0
) -> Symmetric:
    """f(a, b) = f(b, a); with `odd`, f(a, b) = −f(b, a)."""
    if old or not isinstance(over, tuple | list) or len(over) != 2:
        raise CaseError(
            f"symmetric: over must be a pair of names, not {over!r}",
            remedy='symmetric(over=("a", "b")) exchanges two inputs; '
            'even(over="x") and odd(over="x") change the sign of one',
        )
    return Symmetric(tuple(over), -1 if odd else 1, ulp=ulp, within=within)


def _constant(values: Array, batch: Batch) -> str:
    """Say that an output of several values varies nowhere, of which most laws hold, else ""."""
    flat = values.reshape(math.prod(batch), -1)
    constant = len(flat) > 1 and bool((flat == flat[:1]).all())
    return "it is the same at all values: vary an input that it depends on" * constant
