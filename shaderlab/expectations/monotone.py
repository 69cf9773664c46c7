"""monotone: an output never falls, or never rises, while an input goes through rising values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.expectations.law import At, Finding, Law, least
from shaderlab.frame import Array
from shaderlab.model import one_of


@dataclass(frozen=True, kw_only=True)
class Monotone(Law):
    """From one run to the next the output never falls (`sign` 1) or never rises (−1)."""

    kind = "monotone"

    sign: int
    strict: bool

    def find(self, measured: Array) -> Finding:
        rises = self.sign * np.diff(measured, axis=0)
        wrong = int((rises <= 0.0 if self.strict else rises < 0.0).sum())
        i, c = least(rises)
        before = measured[i]
        low, high = (before, np.inf) if self.sign > 0 else (-np.inf, before)
        verb = ("falls" if self.sign > 0 else "rises") + (" or stays" if self.strict else "")
        message = f"it {verb} in {wrong} of {rises.size} steps" if wrong else ""
        return Finding((i + 1, c), before, low, high, wrong, message)


def monotone(
    output: str,
    *,
    over: str,
    values: Sequence[float],
    direction: str = "increasing",
    strict: bool = False,
    at: At = None,
    draw: int = -1,
    name: str = "",
) -> Monotone:
    """`output` never falls ("increasing") or never rises ("decreasing") while the input `over`
    goes through `values`; with `strict`, it never stays the same either. Of vectors, each
    component.

    Raises:
        CaseError: fewer than two values, or values that do not rise.
    """
    one_of("monotone", "direction", direction, ("increasing", "decreasing"))
    numbers = [float(v) for v in values]
    if len(numbers) < 2 or any(a >= b for a, b in pairwise(numbers)):
        raise CaseError(f"monotone {output!r}: values must be two or more that rise")
    return Monotone(
        output=output,
        over=over,
        steps=tuple({over: v} for v in numbers),
        sign=1 if direction == "increasing" else -1,
        strict=strict,
        at=at or {},
        draw=draw,
        name=name or f"{output} {direction}",
    )
