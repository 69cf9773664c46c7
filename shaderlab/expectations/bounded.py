"""bounded: an output stays between two bounds while an input varies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.expectations.law import At, Figure, Finding, Law, least
from shaderlab.frame import Array
from shaderlab.model import UniformValue


@dataclass(frozen=True, kw_only=True)
class Bounded(Law):
    """low ≤ output ≤ high."""

    kind = "bounded"

    low: Figure
    high: Figure

    def find(self, measured: Array) -> Finding:
        low = np.broadcast_to(np.asarray(self.low, np.float64), measured.shape)
        high = np.broadcast_to(np.asarray(self.high, np.float64), measured.shape)
        wrong = int(((measured < low) | (measured > high)).sum())
        i, c = least(np.minimum(measured - low, high - measured))
        nearest = np.clip(measured[i], low[i], high[i])
        message = f"{wrong} of {measured.size} values are out of bounds" if wrong else ""
        return Finding((i, c), nearest, low[i], high[i], wrong, message)


def bounded(
    output: str,
    low: Figure,
    high: Figure,
    *,
    over: str,
    values: Sequence[UniformValue],
    at: At = None,
    draw: int = -1,
    name: str = "",
) -> Bounded:
    """low ≤ `output` ≤ high while the input `over` takes each of `values`. The bounds are numbers,
    or one for each component.

    Raises:
        CaseError: a lower bound above its upper one.
    """
    if not np.all(np.asarray(low, float) <= np.asarray(high, float)):
        raise CaseError(f"bounded {output!r}: {low} … {high} holds no number")
    return Bounded(
        output=output,
        low=low,
        high=high,
        over=over,
        steps=tuple({over: v} for v in values),
        at=at or {},
        draw=draw,
        name=name or f"{output} bounded",
    )
