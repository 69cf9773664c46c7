"""Hazards as data and in words, and what depends on a value that went wrong."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.bands import Integer, TriBool
from shaderlab.files import display_path
from shaderlab.model.frame import Array

from .answer import format_inputs
from .batches import InputBatch, flatten_outputs, run_batch
from .checks import FLOATS, Place, arguments_of
from .interpreter import Program
from .interpreter.program import Instruction
from .interpreter.running import Run, Watch
from .interpreter.values import PathState
from .portability import Spread


@dataclass(frozen=True, kw_only=True)
class Hazard:
    """A hazard of a shader.

    Attributes:
        evident: whether the inputs below do it, in float32, and an output depends on it; else it
            is possible: `message` states the condition.
        inputs: an invocation at which it happens, by name.
        outputs: what that invocation writes, by the names of the outputs that depend on it.
        driver: what a driver writes for it, or why that is not known; "" if it was not asked.
        calls: the lines of the calls that lead there, the outermost first.
    """

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
    """What was shown for all inputs.

    Attributes:
        file, line: where; 0 for an output.
        what, status: what holds, such as "no division by 0", and whether: "proved" or "open".
        share, note: of the range what is left open, by volume; a box of it, or why it is open.
    """

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
class Audit:
    """What was found in one shader.

    Attributes:
        hazards: by line, evident ones and possible ones.
        inputs: what each input was given, in words, by name.
        refused: why nothing can be said of it, if so.
        spreads: how far devices may differ at each output, if that was measured.
        claims: what holds for all inputs of the ranges, or is open, if that was asked.
    """

    file: str
    hazards: tuple[Hazard, ...]
    tried: int
    inputs: Mapping[str, str] = field(default_factory=dict)
    refused: str = ""
    spreads: tuple[Spread, ...] = ()
    claims: tuple[Claim, ...] = ()

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
        yield from map(str, self.spreads)
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
            "claims": [vars(claim) for claim in self.claims],
        }  # fmt: skip


def _numbers(values: tuple[float, ...]) -> list[float | str]:
    """As JSON has them, which has no NaN and no infinity."""
    return [value if math.isfinite(value) else str(value) for value in values]


_VALUES = (None, 0.37, 41.0, -2.6, 7.5e3)
_STAND_IN = 0.5


@dataclass(frozen=True)
class _Replacing:
    """A `Watch` that replaces an instruction's result, or leaves it as it is with None. Other
    results that are no number although all operands are become one: they would hide what depends
    on this one."""

    place: Place
    value: float | None

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        if at.id == self.place.id and tuple(run.calls) == self.place.calls:
            return result if self.value is None else fill_value(result, self.value)
        if isinstance(result, np.ndarray) and at.op in FLOATS and not np.isfinite(result).all():
            values = run.values(arguments_of(at.op, at.operands))
            if all(np.isfinite(v).all() for v in values if isinstance(v, np.ndarray)):
                return np.where(np.isfinite(result), result, np.float32(_STAND_IN))
        return result


def fill_value(value: Any, number: float) -> Any:
    """The value with a number in place of each of its own, true where that is above 1."""
    if isinstance(value, tuple):
        return tuple(fill_value(part, number) for part in value)
    if isinstance(value, Integer):
        return Integer(np.full_like(value.lo, int(abs(number))), unsigned=value.unsigned)
    if isinstance(value, TriBool):
        return TriBool.of(np.full_like(value.all_true, number > 1.0))
    return np.full_like(value, number) if isinstance(value, np.ndarray) else value


def find_written_outputs(
    program: Program, batch: InputBatch, row: int, watch: Watch | None = None
) -> Mapping[str, Array]:
    """What an invocation writes, by output; "discard" is 1 where it is discarded."""
    result = run_batch(program, batch, watch=watch)
    found = {name: values[row] for name, values in flatten_outputs(result.outputs, finite=False)}
    gone = bool(np.broadcast_to(result.discarded.all_true, (batch.count,))[row])
    return found | {"discard": np.array([float(gone)])}


def find_dependents(
    program: Program, batch: InputBatch, row: int, place: Place
) -> dict[str, Array]:
    """The outputs that depend on an instruction's result at an invocation, as they are."""
    some, own = batch.alone(row, program)
    plain = find_written_outputs(program, some, own)
    others = [
        find_written_outputs(program, some, own, _Replacing(place, value)) for value in _VALUES
    ]
    return {name: value for name, value in plain.items() if _differs(name, others)}


def hazard_at(
    program: Program,
    inputs: Iterable[str],
    found: tuple[Place, Instruction, InputBatch, int],
    outputs: Mapping[str, Array],
    message: str,
    **more: Any,
) -> Hazard:
    """The hazard of an instruction that was found at a place, for a row of a batch."""
    place, at, batch, row = found
    file, line = program.place(at.line)
    return Hazard(
        file=file, line=line, kind=place.kind, message=message, inputs=batch.example(row, inputs),
        outputs={name: tuple(map(float, value)) for name, value in outputs.items()},
        calls=tuple(program.place(call)[1] for call in place.calls), **more,
    )  # fmt: skip


def _differs(name: str, runs: Sequence[Mapping[str, Array]]) -> bool:
    values = [run[name] for run in runs if name in run]
    return len(values) < len(runs) or any(
        not np.array_equal(value, values[0], equal_nan=True) for value in values
    )
