"""What an audit found, as data and in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from shaderlab.files import display_path

from ..equivalence.answer import shown
from .portability import Spread


@dataclass(frozen=True, kw_only=True)
class Hazard:
    """A hazard of a shader.

    Attributes:
        file, line: where it is.
        kind: of hazard, such as "division by 0".
        message: what happens there, in words.
        evident: whether the inputs below do it, in float32, and an output depends on it; else it
            is possible: `message` says what it takes.
        inputs: an invocation at which it happens, by name.
        outputs: what that invocation writes, by the names of the outputs that depend on it.
        calls: the lines of the calls that lead there, the outermost first.
    """

    file: str
    line: int
    kind: str
    message: str
    evident: bool = True
    inputs: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    outputs: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    calls: tuple[int, ...] = ()

    def __str__(self) -> str:
        text = f"{display_path(self.file, self.line)}: {self.message}"
        if not self.evident:
            text += " (possible)"
        if self.inputs:
            text += f"\n    with {shown(self.inputs)}"
        if self.outputs:
            text += f"\n    {shown(self.outputs)}"
        return text

    def data(self) -> dict[str, Any]:
        """The hazard as JSON."""
        return {
            **vars(self),
            "inputs": {name: _numbers(values) for name, values in self.inputs.items()},
            "outputs": {name: _numbers(values) for name, values in self.outputs.items()},
            "calls": list(self.calls),
        }


@dataclass(frozen=True, kw_only=True)
class Audit:
    """What was found in one shader.

    Attributes:
        file: the shader.
        hazards: by line, evident ones and possible ones.
        tried: how many invocations were run.
        inputs: what each input was given, in words, by name.
        refused: why nothing can be said of it, if so.
        spreads: how far devices may differ at each output, if that was asked for.
    """

    file: str
    hazards: tuple[Hazard, ...]
    tried: int
    inputs: Mapping[str, str] = field(default_factory=dict)
    refused: str = ""
    spreads: tuple[Spread, ...] = ()

    @property
    def clean(self) -> bool | None:
        """Whether there is no evident hazard; None where that can't be said."""
        if self.refused:
            return None
        return not any(hazard.evident for hazard in self.hazards)

    def lines(self, possible: bool = True) -> Iterator[str]:
        """The audit in words, with possible hazards or with their number alone."""
        if self.refused:
            yield f"can't say: {self.refused}"
            return
        yield from map(str, self.spreads)
        evident = [hazard for hazard in self.hazards if hazard.evident]
        yield from map(str, self.hazards if possible else evident)
        text = f"{len(evident) or 'no'} hazard{'' if len(evident) == 1 else 's'}"
        others = len(self.hazards) - len(evident)
        if others:
            text += f", {others} possible"
        yield f"{display_path(self.file)}: {text} on {self.tried:,} inputs"

    def data(self) -> dict[str, Any]:
        """The audit as JSON."""
        return {
            "file": self.file,
            "clean": self.clean,
            "hazards": [hazard.data() for hazard in self.hazards],
            "tried": self.tried,
            "inputs": dict(self.inputs),
            "refused": self.refused,
            "spreads": [spread.data() for spread in self.spreads],
        }


def _numbers(values: tuple[float, ...]) -> list[float | str]:
    """As JSON has them, which has no NaN and no infinity."""
    return [value if math.isfinite(value) else str(value) for value in values]
