"""Where a figure must lie: as printed, or between two ends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

from shaderlab.errors import CaseError


@dataclass(frozen=True, kw_only=True)
class Bound:
    """low ≤ figure ≤ high. `digits` is for a printed figure, which is in the middle; None for
    other bounds."""

    low: float = -math.inf
    high: float = math.inf
    digits: int | None = None

    @classmethod
    def of(
        cls,
        label: str,
        *,
        equals: float | None = None,
        digits: int | None = None,
        at_most: float | None = None,
        at_least: float | None = None,
        between: tuple[float, float] | None = None,
    ) -> Self | None:
        """Return the bound that a case gives for the measure `label`; None where it gives none.

        It says so in one of three ways: the figure rounds to `equals` at so many `digits`; it is
        `at_most` so much, or `at_least`, or both; or it lies `between` two ends.

        Raises:
            CaseError: it says two things, or holds no number, or all.
        """
        ways = [(equals, digits), (at_most, at_least), (between,)]
        given = sum(any(part is not None for part in way) for way in ways)
        if given > 1:
            raise CaseError(f"measure {label!r}: give equals, or between, or at_most and at_least")
        if (equals is None) != (digits is None):
            raise CaseError(f"measure {label!r}: equals and digits go together")
        if not given:
            return None
        if equals is not None and digits is not None:
            half = 0.5 * 10.0**-digits * (1.0 + 1e-6)
            return cls(low=equals - half, high=equals + half, digits=digits)
        low, high = between or (
            -math.inf if at_least is None else at_least,
            math.inf if at_most is None else at_most,
        )
        if not low <= high or (math.isinf(low) and math.isinf(high)):
            raise CaseError(f"measure {label!r}: {low} … {high} bounds no figure")
        return cls(low=float(low), high=float(high))

    def __contains__(self, figure: float) -> bool:
        return math.isfinite(figure) and self.low <= figure <= self.high

    def __str__(self) -> str:
        if self.digits is not None:
            return f"{(self.low + self.high) / 2:.{self.digits}f}"
        if math.isinf(self.low):
            return f"≤ {self.high:g}"
        if math.isinf(self.high):
            return f"≥ {self.low:g}"
        return f"{self.low:g} … {self.high:g}"
