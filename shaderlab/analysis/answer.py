"""How two programs are compared, and what that found, as data and in words."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from shaderlab.files import display_path

_SHOWN = 6  # inputs of an example
_FEW = 4  # lines that are not gathered
_INDEX = re.compile(r"\[\d+\]|_\d+(?=[_:])")  # of an element, and of one that is an argument
_WHY = {"coverage": ", where only one discards", "definedness": ", where only one is defined"}


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How two programs are compared: `ranges` has "a..b", "a:b" or "unit" for inputs, by name,
    `rounds` says how many batches of `count` inputs are generated, or captured ones varied, and
    `accuracy` whether to compare the accuracy of both by their bands."""

    ranges: Mapping[str, str] = field(default_factory=dict)
    rounds: int = 5
    count: int = 4096
    accuracy: bool = True


@dataclass(frozen=True, order=True)
class Cost:
    """How many ULP wider the band of an operation is than those that it reads, what GLSL calls it,
    and where it is, which does not count where costs are compared."""

    ulp: float
    operation: str
    file: str = field(compare=False)
    line: int = field(compare=False)

    def __str__(self) -> str:
        place = display_path(self.file, self.line)
        return f"{self.operation} at {place} costs {_number(self.ulp)} ULP"


@dataclass(frozen=True, kw_only=True)
class Numerics:
    """How the accuracy of an output changes, by the widths of its bands, in ULP of its value: how
    many the new program loses or gains where it does most, the inputs there, of whichever is more,
    and the costliest operation of the old program that the new one has not, and the other way
    around."""

    worse: float
    better: float
    near: Mapping[str, tuple[float, ...]]
    costs: tuple[Cost | None, ...] = (None, None)

    @property
    def differ(self) -> bool:
        """Whether more than rounding alike is between them: 1 ULP, and a quarter."""
        return max(self.worse, self.better) > 0.0

    def __str__(self) -> str:
        if not self.differ:
            return "same numerics"
        less = self.worse >= self.better
        how = "less" if less else "more"
        text = f"up to {_number(max(self.worse, self.better))} ULP {how} accurate"
        text += f" near {format_inputs(self.near, 2)}" if self.near else ""
        known = [str(cost) for cost in (self.costs[::-1] if less else self.costs) if cost]
        return f"{text}: {', '.join(known)}" if known else text


@dataclass(frozen=True, kw_only=True)
class OutputAnswer:
    """What was found of one output.

    Attributes:
        name: as the old program calls it; "old → new" where the new one calls it otherwise.
        judged: on how many inputs it was compared.
        different: on how many of them it is another one.
        apart: how far, at most; infinite where only one program draws, or has a number.
        why: "value", "coverage", "definedness"; "missing" where a program has no such output;
            "refused" where a function can't be compared; "interface" where a declaration differs.
        example: inputs at which it differs, and what both give there; if it is the same under
            conditions, inputs that do not meet them.
        place: the first line of the new program that differs there, "file:line" or "".
        conditions: what it is the same under, where it is not so without.
        numerics: None where the mathematics differ, or bands could not be had.
    """

    name: str
    judged: int = 0
    different: int = 0
    apart: float = 0.0
    why: str = ""
    example: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    gives: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())
    place: str = ""
    conditions: tuple[str, ...] = ()
    numerics: Numerics | None = None

    @property
    def same(self) -> bool | None:
        """Whether it is the same mathematics; None where nothing could be compared."""
        if self.different or self.why in ("missing", "interface"):
            return False
        return True if self.judged else None

    def __str__(self) -> str:
        if self.why == "missing":
            return f"{self.name}: only one of the two has it"
        if self.why == "interface":
            return f"interface: {self.name}"
        if self.same is None:
            return f"{self.name}: nothing to compare: it is undefined or mere noise for all inputs"
        if self.same:
            numerics = self.numerics if self.numerics is not None and self.numerics.differ else None
            text = (
                f"{self.name}: same{' mathematics' if numerics else ''} on {self.judged:,} inputs"
            )
            if self.conditions:
                text += f", only if {' and '.join(self.conditions)}"
            text += f"; {numerics}" if numerics else ""
            return text + self._example() if self.conditions else text
        share = 100.0 * self.different / self.judged
        percent = f"{share:.0f}" if share >= 1.0 else f"{share:.2g}"
        text = f"{self.name}: different at {percent} % of {self.judged:,} inputs"
        if self.why == "value":
            text += f", by up to {_number(self.apart)}"
        text += _WHY.get(self.why, "")
        if self.place:
            text += f"; first at {self.place}"
        return text + self._example()

    def _example(self) -> str:
        if not self.example:
            return ""
        text = f"\n    with {format_inputs(self.example)}"
        return f"{text}\n    {_vector(self.gives[0])} became {_vector(self.gives[1])}"


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a comparison found; `notes` are what else a reader should know, such as inputs that only
    one program has, `inputs` what each was given, in words, by name."""

    old: str
    new: str
    outputs: tuple[OutputAnswer, ...]
    notes: tuple[str, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)

    @property
    def same(self) -> bool | None:
        """Whether all outputs are the same mathematics; None where one is undetermined."""
        found = [output.same for output in self.outputs]
        if False in found:
            return False
        return None if None in found or not found else True

    @property
    def conditional(self) -> bool:
        """Whether some output is the same only under conditions."""
        return any(output.conditions for output in self.outputs)

    @property
    def same_numerics(self) -> bool | None:
        """Whether no output's accuracy changes; None where it is not known of one."""
        found = [o.numerics and not o.numerics.differ for o in self.outputs if o.same]
        return False if False in found else None if None in found else True

    def lines(self) -> Iterator[str]:
        """The answer in words."""
        outputs = (str(one) for one in self.outputs if one.why != "refused")  # a note says why
        yield from gather_elements([*outputs, *self.notes])

    def data(self) -> dict[str, Any]:
        """The answer as JSON."""
        return {
            "old": self.old, "new": self.new, "same": self.same,
            "outputs": [_data(output) for output in self.outputs],
            "notes": list(self.notes), "inputs": dict(self.inputs),
        }  # fmt: skip


def _data(output: OutputAnswer) -> dict[str, Any]:
    found: dict[str, Any] = {
        "name": output.name, "same": output.same, "judged": output.judged,
        "different": output.different,
    }  # fmt: skip
    if output.why:
        found |= {
            "why": output.why, "place": output.place,
            "apart": output.apart if output.why == "value" else None,
        }  # fmt: skip
    if output.conditions:
        found["conditions"] = list(output.conditions)
    if output.why or output.conditions:
        found |= {
            "example": {n: list(v) for n, v in output.example.items()},
            "old gives": _numbers(output.gives[0]), "new gives": _numbers(output.gives[1]),
        }  # fmt: skip
    if output.numerics is not None:
        numerics = output.numerics
        found["numerics"] = {
            "ulp worse": numerics.worse, "ulp better": numerics.better,
            "near": {n: list(v) for n, v in numerics.near.items()},
            "costs": [cost and asdict(cost) for cost in numerics.costs],
        }  # fmt: skip
    return found


def _numbers(values: tuple[float, ...]) -> list[float | None]:
    """As JSON has them, which has no NaN."""
    return [value if math.isfinite(value) else None for value in values]


def gather_elements(lines: Iterable[str]) -> Iterator[str]:
    """The lines, but one of many that differ in indices alone, without them: "v[]: same"."""
    found: dict[str, list[str]] = {}
    for line in lines:
        found.setdefault(_INDEX.sub("[]", line), []).append(line)
    for words, own in found.items():
        yield from own if len(own) <= _FEW else [words]


def format_inputs(inputs: Mapping[str, tuple[float, ...]], most: int = _SHOWN) -> str:
    """Some inputs as "x = 0.25, normal = (0, 0, 1)"."""
    some = [f"{name} = {_vector(values)}" for name, values in list(inputs.items())[:most]]
    return ", ".join(some) + (", …" if len(inputs) > most else "")


def _vector(values: tuple[float, ...]) -> str:
    if not values:
        return "nothing"
    text = ", ".join(f"{value:.6g}" for value in values)
    return text if len(values) == 1 else f"({text})"


def _number(value: float) -> str:
    return f"{value:,.0f}" if value >= 10.0 else f"{value:.2g}"
