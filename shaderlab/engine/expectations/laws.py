"""Laws of an output while inputs vary: bounded, monotone, even, odd, symmetric, and its mean.

None needs a reference. Each law runs the program on inputs that it gives itself, as a `sweep` does;
inputs that it does not vary stay as the case has them, or as `at` says. Inputs of the stage are
gathered into one draw; a uniform costs a draw for each of its values.
"""

import functools
from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Array, Frame, Samples
from shaderlab.model.records import Outcome, Row
from shaderlab.model.scene import UniformValue

from ..judging import laws
from ..judging.banded import format_value, to_tuple
from .base import OutputExpectation
from .needs import Probe

Figure = float | Sequence[float]


@dataclass(frozen=True, kw_only=True)
class OutputLaw(OutputExpectation):
    """A law of an output while inputs vary; `at` are other inputs by name, those that it leaves out
    stay as the case has them."""

    at: Mapping[str, UniformValue] = field(default_factory=dict)

    @property
    @abstractmethod
    def steps(self) -> Sequence[Mapping[str, Any]]:
        """The inputs of each run by name."""

    @abstractmethod
    def judge_runs(self, measured: Array, samples: Samples) -> Judgement:
        """Hold finite float64 values (runs, components) against the law."""

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        self.is_of_vertex(scene, programs)  # raises where there is no such output
        yield Probe(self, [{**self.at, **step} for step in self.steps])

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        samples = frame.answer(Probe(self))
        measured = samples.outputs[self.own_name(scene)].astype(np.float64)
        finite = np.isfinite(measured)
        if finite.all():
            return self.judge_runs(measured, samples)
        run = int(np.argwhere(~finite)[0, 0])
        inputs = ", ".join(
            f"{name} = {format_value(value)}" for name, value in self.steps[run].items()
        )
        row = Row(label=inputs, expected="finite", measured=format_value(measured[run]), ok=False)
        message = f"{int((~finite).sum())} values are not finite"
        return self.judge_rows([row], message, judged=measured.size)


@dataclass(frozen=True, kw_only=True)
class EachValue(OutputLaw):
    """A law that every value keeps by itself, or beside another one, as GLSL functions do."""

    named = "{self.output} {self.law.title}"
    types: ClassVar[str] = "iufb"
    over: str
    values: Sequence[Any]

    def __post_init__(self) -> None:
        if not self.steps:
            raise CaseError(f"{self.kind} {self.output!r}: needs values of {self.over!r}")

    @property
    @abstractmethod
    def law(self) -> laws.Law:
        """The law itself. Raises CaseError if its arguments are wrong."""

    @functools.cached_property
    def inputs(self) -> Mapping[str, Array]:
        """What varies, by name, each (runs, …)."""
        return {self.over: self._array(self.values)}

    def _array(self, values: Sequence[Any]) -> Array:
        try:
            found = np.asarray(values)
        except ValueError:  # vectors of several sizes
            found = np.empty(0, object)
        if found.dtype.kind not in self.types and len(values):
            raise CaseError(f"{self.kind} {self.output!r}: values must be numbers or vectors")
        return found

    @functools.cached_property
    def steps(self) -> Sequence[Mapping[str, Any]]:
        """The inputs of each run, and after them those of the second evaluation, if any."""
        second = self.law.second_inputs(self.inputs)
        return [
            dict(zip(inputs, step, strict=True))
            for inputs in ((self.inputs, second) if second else (self.inputs,))
            for step in zip(*(values.tolist() for values in inputs.values()), strict=True)
        ]

    def judge_runs(self, measured: Array, samples: Samples) -> Judgement:
        count = len(self.values)
        found = self.law.judge(self.inputs, measured[:count], measured[count:], (count,))
        wrong = int((~found.holds).sum())
        message = ""
        if wrong:
            message = f"{self.law.title} does not hold at {wrong} of {found.holds.size} values"
        elif found.trivial:
            message = f"{self.law.title} could hardly fail: {found.trivial}"

        def inputs_of(run: int) -> dict[str, tuple[float, ...]]:
            return {
                name: to_tuple(samples.inputs[name][run])
                for name in dict.fromkeys((*self.steps[run], *self.at))
                if name in samples.inputs and samples.inputs[name][run].ndim == 1
            }

        outcome = Outcome(
            name=self.name,
            kind=self.kind,
            status="fail" if message else "pass",
            message=message,
            judged=measured.size,
            outside=wrong,
            worst=found.find_worst(count, inputs_of, broken=bool(message)),
        )
        return Judgement(outcome=outcome)


@dataclass(frozen=True)
class Bounded(EachValue):
    """low ≤ `output` ≤ high while the input `over` takes each of `values`. The bounds are numbers,
    or one for each component. Raises CaseError: none, low above high, or no values."""

    kind = "bounded"

    output: str
    low: Figure
    high: Figure

    @property
    def law(self) -> laws.Bounded:
        return laws.Bounded(self.low, self.high)


@dataclass(frozen=True)
class Monotone(EachValue):
    """`output` never falls ("increasing") or never rises ("decreasing") while the input `over` goes
    through `values`; with `strict`, it never stays the same either. Of vectors, each component. An
    output that changes nowhere fails. Raises CaseError: fewer than two, or not rising."""

    kind = "monotone"
    named = "{self.output} {self.direction}"

    output: str
    _: KW_ONLY
    values: Sequence[float]
    direction: str = "increasing"
    strict: bool = False

    def __post_init__(self) -> None:
        if len(self.values) < 2 or any(a >= b for a, b in pairwise(self.values)):
            raise CaseError(f"monotone {self.output!r}: values must be two or more that rise")

    @property
    def law(self) -> laws.Monotone:
        return laws.Monotone(self.over, direction=self.direction, strict=self.strict)


@dataclass(frozen=True)
class Even(EachValue):
    """f(−x) = f(x) for each of `values` of the input `over`.

    Args:
        output: what is judged.
        over: an input's name.
        values: numbers or vectors.
        ulp, within: how far the two may lie apart, in float32 steps or as a number; by default
            they are the same.
        at: other inputs.
    """

    kind = "even"
    types = "iuf"

    output: str
    _: KW_ONLY
    ulp: float = 0.0
    within: float = 0.0

    def __post_init__(self) -> None:
        if trivial := self.law.find_trivial(self.inputs):
            raise CaseError(f"{self.kind} {self.output!r} could not fail: {trivial}")

    @property
    def law(self) -> laws.Symmetric:
        return laws.even(self.over, ulp=self.ulp, within=self.within)


@dataclass(frozen=True)
class Odd(Even):
    """f(−x) = −f(x) for each of `values` of the input `over`; for the arguments see `Even`."""

    kind = "odd"

    @property
    def law(self) -> laws.Symmetric:
        return laws.odd(self.over, ulp=self.ulp, within=self.within)


@dataclass(frozen=True)
class Symmetric(Even):
    """f(a, b) = f(b, a) for each pair (a, b) of `values` of the two inputs `over`; with `odd`,
    f(a, b) = −f(b, a). For the other arguments see `Even`."""

    kind = "symmetric"

    _: KW_ONLY
    over: tuple[str, str] | str  # type: ignore[assignment]
    odd: bool = False

    @property
    def law(self) -> laws.Symmetric:
        names: Any = self.over  # a single name is an error, which the law reports
        return laws.symmetric(names, odd=self.odd, ulp=self.ulp, within=self.within)

    @functools.cached_property
    def inputs(self) -> Mapping[str, Array]:
        names = self.law.inputs
        if any(np.ndim(pair) == 0 or len(pair) != len(names) for pair in self.values):
            raise CaseError(f"symmetric {self.output!r}: values must be pairs")
        return {
            name: self._array([pair[k] for pair in self.values]) for k, name in enumerate(names)
        }


bounded, monotone, even, odd, symmetric = Bounded, Monotone, Even, Odd, Symmetric
