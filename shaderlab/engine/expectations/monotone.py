"""monotone: an output never falls, or never rises, while an input goes through rising values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.frame import Array
from shaderlab.model.state import one_of

from .law import UNVARIED, Finding, Law, least


@dataclass(frozen=True)
class Monotone(Law):
    """`output` never falls ("increasing") or never rises ("decreasing") while the input `over`
    goes through `values`; with `strict`, it never stays the same either. Of vectors, each
    component. An output that changes nowhere fails.

    Raises:
        CaseError: fewer than two values, or values that do not rise.
    """

    kind = "monotone"

    output: str
    _: KW_ONLY
    values: Sequence[float]
    direction: str = "increasing"
    strict: bool = False

    def __post_init__(self) -> None:
        one_of("monotone", "direction", self.direction, ("increasing", "decreasing"))
        if len(self.values) < 2 or any(a >= b for a, b in pairwise(self.values)):
            raise CaseError(f"monotone {self.output!r}: values must be two or more that rise")
        self.name_by_default(f"{self.output} {self.direction}")

    @property
    def steps(self) -> Sequence[Mapping[str, Any]]:
        return [{str(self.over): float(v)} for v in self.values]

    def find(self, measured: Array) -> Finding:
        rising = self.direction == "increasing"
        rises = (1 if rising else -1) * np.diff(measured, axis=0)
        wrong = int((rises <= 0.0 if self.strict else rises < 0.0).sum())
        i, c = least(rises)
        before = measured[i]
        low, high = (before, np.inf) if rising else (-np.inf, before)
        verb = ("falls" if rising else "rises") + (" or stays" if self.strict else "")
        message = f"it {verb} in {wrong} of {rises.size} steps" if wrong else ""
        if not rises.any():
            message = f"it is the same at all {len(measured)} values: {UNVARIED}"
        return Finding((i + 1, c), before, low, high, wrong, message)


monotone = Monotone
