"""What an audit is asked, and what it finds, as data and in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from shaderlab.files import display_path

from .answer import format_inputs

if TYPE_CHECKING:
    from .interpreter import Program

_MOST_NUMBERS = 4  # of an input that is shown


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How a program is audited: `ranges` has "a..b", "a:b" or "unit" for inputs, by name, `assume`
    conditions in GLSL that hold of them. `precision` asks how far devices may differ, at highp and
    at mediump, `prove` that no input of the ranges causes a hazard, and `confirm` runs a hazard's
    inputs on a driver."""

    ranges: Mapping[str, str] = field(default_factory=dict)
    count: int = 4096
    precision: bool = False
    prove: bool = False
    assume: tuple[str, ...] = ()
    confirm: Callable[[Program, Hazard], Hazard] | None = None


@dataclass(frozen=True, kw_only=True)
class Hazard:
    """A hazard of a shader. It is evident if the inputs, those of one invocation, by name, do it in
    float32, and an output depends on it; else it is possible: `message` states the condition.
    `outputs` are those that depend on it, as that invocation writes them, `driver` is what a driver
    writes, or why that is not known ("" if it was not asked), and `calls` has the lines of the
    calls that lead there, the outermost first."""

    file: str
    line: int
    kind: str
    message: str
    evident: bool = True
    inputs: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    outputs: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    driver: str = ""
    calls: tuple[int, ...] = ()

    def __str__(self) -> str:
        text = f"{display_path(self.file, self.line or None)}: {self.message}"
        if not self.evident:
            text += " (possible)"
        if self.inputs:
            text += f"\n    with {format_inputs(self.inputs)}"
        if self.outputs:
            text += f"\n    {format_inputs(self.outputs)}"
        return text + f"\n    {self.driver}" * bool(self.driver)

    def data(self) -> dict[str, Any]:
        """The hazard as JSON."""
        return {
            **vars(self),
            "inputs": {name: _numbers(values) for name, values in self.inputs.items()},
            "outputs": {name: _numbers(values) for name, values in self.outputs.items()},
        }


@dataclass(frozen=True)
class Claim:
    """What was shown for all inputs: what holds at a line (0: of an output), as "no division by 0",
    whether that is "proved" or "open", in which share of the range, and a box of it, or why."""

    file: str
    line: int
    what: str
    status: str
    share: float = 0.0
    note: str = ""

    def __str__(self) -> str:
        text = f"{display_path(self.file, self.line or None)}: {self.status}: {self.what}"
        if self.share:
            text += f", on {float(f'{100.0 * self.share:.2g}'):g} % of the range"
        return f"{text}, {self.note}" if self.note else text


@dataclass(frozen=True, kw_only=True)
class Spread:
    """How far devices may differ at an output.

    Attributes:
        precision: "highp": what the precision rules allow; "mediump": what devices of 16 bits gave.
        codes: in codes of 8 bits, of what lies within 0..1; infinite where one gave no number, 0 of
            a stage that draws nothing.
        ulp: in float32 ULP of the value, or of 1/256 of the output's largest if that is more; 0 at
            mediump.
        near: the inputs where the codes are most, of the ULP if codes are the same everywhere.
        file, line: where most precision is lost there; "" and 0 if nowhere.
        unbounded: the share of invocations for which the rules bound nothing.
    """

    output: str
    precision: str
    codes: float
    ulp: float = 0.0
    near: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    file: str = ""
    line: int = 0
    unbounded: float = 0.0

    def __str__(self) -> str:
        if self.precision == "mediump":
            text = f"{self.output} at mediump: 16-bit devices "
            none = math.isinf(self.codes)
            text += "return no number" if none else f"are off by {self.codes:.3g} 8-bit codes"
        else:
            text = f"{self.output}: conforming devices may differ by {self.ulp:.3g} ULP"
            text += f", {self.codes:.2g} 8-bit codes" if self.codes else ""
        few = {name: values for name, values in self.near.items() if len(values) <= _MOST_NUMBERS}
        if few:
            text += f", near {format_inputs(few, 2)}"
        if self.line:
            text += f"; most precision is lost at {display_path(self.file, self.line)}"
        if self.unbounded:
            text += f"; unbounded for {100.0 * self.unbounded:.0f} % of inputs"
        return text

    def data(self) -> dict[str, Any]:
        """The spread as JSON."""
        return {
            **vars(self),
            "codes": self.codes if math.isfinite(self.codes) else None,
            "near": {name: list(values) for name, values in self.near.items()},
        }


@dataclass(frozen=True, kw_only=True)
class Audit:
    """What was found in one shader: hazards by line, evident ones and possible ones, of so many
    inputs that were tried, which are in words here, or why it is refused; how far devices may
    differ at each output, and what holds for all inputs, or is open, if that was asked; and
    `notes` on what was taken for what the file lacks."""

    file: str
    hazards: tuple[Hazard, ...]
    tried: int
    inputs: Mapping[str, str] = field(default_factory=dict)
    refused: str = ""
    spreads: tuple[Spread, ...] = ()
    claims: tuple[Claim, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def clean(self) -> bool | None:
        """Whether there is no evident hazard, and each is proved absent that was asked about; None
        if undetermined."""
        if self.refused:
            return None
        if any(hazard.evident for hazard in self.hazards):
            return False
        return None if any(claim.status == "open" for claim in self.claims) else True

    def lines(self, possible: bool = True) -> Iterator[str]:
        """The audit in words, with possible hazards or with their number alone."""
        if self.refused:
            yield f"undetermined: {self.refused}"
            return
        yield from (*self.notes, *map(str, self.spreads))
        evident = [hazard for hazard in self.hazards if hazard.evident]
        yield from map(str, self.hazards if possible or self.claims else evident)
        yield from map(str, self.claims)
        text = f"{len(evident) or 'no'} hazard{'' if len(evident) == 1 else 's'}"
        others = len(self.hazards) - len(evident)
        if others:
            text += f", {others} possible"
        text += f" on {self.tried:,} inputs"
        if self.claims:
            proved = sum(claim.status == "proved" for claim in self.claims)
            text += f"; for all inputs {proved} claims proved, {len(self.claims) - proved} open"
        yield f"{display_path(self.file)}: {text}"

    def data(self) -> dict[str, Any]:
        """The audit as JSON."""
        return {
            "file": self.file, "clean": self.clean,
            "hazards": [hazard.data() for hazard in self.hazards],
            "tried": self.tried, "inputs": dict(self.inputs), "refused": self.refused,
            "spreads": [spread.data() for spread in self.spreads],
            "claims": [vars(claim) for claim in self.claims], "notes": list(self.notes),
        }  # fmt: skip


def _numbers(values: tuple[float, ...]) -> list[float | str]:
    """As JSON has them, which has no NaN and no infinity."""
    return [value if math.isfinite(value) else str(value) for value in values]
