"""bounded: an output stays between two bounds while an input varies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.frame import Array
from shaderlab.model.scene import UniformValue

from .law import Figure, Finding, Law, least


@dataclass(frozen=True)
class Bounded(Law):
    """low ≤ `output` ≤ high while the input `over` takes each of `values`. The bounds are numbers,
    or one for each component.

    Raises:
        CaseError: a lower bound above its upper one, none at all, or no values.
    """

    kind = "bounded"

    output: str
    low: Figure
    high: Figure
    _: KW_ONLY
    values: Sequence[UniformValue]

    def __post_init__(self) -> None:
        if not np.all(np.asarray(self.low, float) <= np.asarray(self.high, float)):
            raise CaseError(f"bounded {self.output!r}: {self.low} … {self.high} holds no number")
        if np.any(np.isinf(self.low) & np.isinf(self.high)):
            raise CaseError(f"bounded {self.output!r}: {self.low} … {self.high} bounds nothing")
        self.name_by_default(f"{self.output} bounded")
        self.require_steps()

    @property
    def steps(self) -> Sequence[Mapping[str, Any]]:
        return [{str(self.over): v} for v in self.values]

    def find(self, measured: Array) -> Finding:
        low = np.broadcast_to(np.asarray(self.low, np.float64), measured.shape)
        high = np.broadcast_to(np.asarray(self.high, np.float64), measured.shape)
        wrong = int(((measured < low) | (measured > high)).sum())
        i, c = least(np.minimum(measured - low, high - measured))
        nearest = np.clip(measured[i], low[i], high[i])
        message = f"{wrong} of {measured.size} values are out of bounds" if wrong else ""
        return Finding((i, c), nearest, low[i], high[i], wrong, message)


bounded = Bounded
