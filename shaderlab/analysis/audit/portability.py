"""How far two conforming devices may differ at an output, and which line costs most of it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.bands.rounding import ulp
from shaderlab.errors import FormulaError, NotInterpretedError
from shaderlab.files import display_path
from shaderlab.model.frame import Array

from ..equivalence.answer import shown
from ..equivalence.comparison import example
from ..inputs import Given, Input
from ..interpreter import Bands, Program, Stored, interpret
from ..interpreter.running import is_vector, precision_loss
from .consequences import alone
from .watching import run_watched

MOST = 512
"""Invocations that are looked at."""
CODES = 255.0
_SMALL = 2.0**-8  # of an output's largest value: below it, what counts is the ULP of this
_MOST_NUMBERS = 4  # of an input that is shown


@dataclass(frozen=True, kw_only=True)
class Spread:
    """How far devices may differ at an output.

    Attributes:
        output: its name.
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
            text = f"{self.output} at mediump: devices of 16 bits "
            text += "give no number" if np.isinf(self.codes) else f"are {self.codes:.3g} codes off"
        else:
            text = f"{self.output}: conforming devices may differ by {self.ulp:.3g} ULP"
            text += f", {self.codes:.2g} codes of 8 bits" if self.codes else ""
        few = {name: values for name, values in self.near.items() if len(values) <= _MOST_NUMBERS}
        if few:
            text += f", near {shown(few, 2)}"
        if self.line:
            text += f"; most is lost at {display_path(self.file, self.line)}"
        if self.unbounded:
            text += f"; not bounded at {100.0 * self.unbounded:.0f} % of inputs"
        return text

    def data(self) -> dict[str, Any]:
        """The spread as JSON."""
        return {
            **vars(self),
            "codes": self.codes if np.isfinite(self.codes) else None,
            "near": {name: list(values) for name, values in self.near.items()},
        }


def portability(program: Program, given: Given, inputs: Mapping[str, Input]) -> list[Spread]:
    """How far the precision rules let each float output's values lie apart.

    Returns:
        nothing where bands can't be had.
    """
    try:
        outputs = run_watched(program, given, arithmetic=Bands()).outputs
    except (NotInterpretedError, FormulaError):
        return []
    found = []
    for name, band in outputs.items():
        if not is_vector(band) or (name.startswith("gl_") and band.vacuous.all()):
            continue
        with np.errstate(all="ignore"):
            wide = band.hi - band.lo
            known = np.isfinite(wide) & ~band.vacuous
            size = np.where(known, np.maximum(np.abs(band.lo), np.abs(band.hi)), 0.0)
            steps = wide / ulp(np.maximum(size, _SMALL * size.max(axis=0)))
            steps = np.where(known & (wide > 0.0), steps, 0.0).max(axis=-1)
            codes = (np.clip(band.hi, 0.0, 1.0) - np.clip(band.lo, 0.0, 1.0)) * CODES
            codes = np.where(known, codes, 0.0).max(axis=-1) * (program.stage == "fragment")
        open_ones = float((~known).any(axis=-1).mean())
        row = int((codes if codes.max() > 0.0 else steps).argmax())
        file, line = _costliest(program, given, row, _lost)
        found.append(
            Spread(
                output=name, precision="highp", codes=float(codes.max()), ulp=float(steps.max()),
                near=example(given, row, inputs) if steps.max() else {}, file=file, line=line,
                unbounded=open_ones,
            )
        )  # fmt: skip
    return found


def _lost(event: Stored, row: int) -> float:
    return precision_loss(event, row) if is_vector(event.value) else 0.0


def _costliest(
    program: Program, given: Given, row: int, cost: Callable[[Stored, int], float]
) -> tuple[str, int]:
    """The line of the statement that loses most at an invocation; "" and 0 if none does."""
    some, own = alone(program, given, row)
    events: list[Stored] = []
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        interpret(program, some.each, some.bindings, Bands(), count=some.count, trace=events.append)
        costs = [(cost(event, own), event.line) for event in events if event.mask[own]]
    finite = [one for one in costs if np.isfinite(one[0]) and one[0] > 0.0]
    return program.place(max(finite)[1]) if finite else ("", 0)


def sample(given: Given) -> Given:
    """Some of the invocations, whole quads from all over."""
    if given.count <= MOST:
        return given
    start: Array = np.linspace(0, given.count // 4 - 1, MOST // 4).astype(np.int64) * 4
    return given.part((start[:, None] + np.arange(4)).ravel())
