"""Where a figure must lie: as printed, or between two ends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self, TypedDict

from shaderlab.errors import CaseError


class Bounds(TypedDict, total=False):
    """How a case says where a figure must lie, in one of three ways.

    `equals` with `digits`: it rounds to `equals` at so many decimals. `at_most` and `at_least`,
    one or both. `between` two ends.
    """

    equals: float | None
    digits: int | None
    at_most: float | None
    at_least: float | None
    between: tuple[float, float] | None


@dataclass(frozen=True, kw_only=True)
class Bound:
    """low ≤ figure ≤ high. `digits` is for a printed figure, which is in the middle; None for
    other bounds."""

    low: float = -math.inf
    high: float = math.inf
    digits: int | None = None

    @classmethod
    def of(cls, label: str, given: Bounds) -> Self | None:
        """The bound that a case gives for the measure `label`; None where it gives none.

        Raises:
            CaseError: it says two things, or holds no number, or all.
        """
        said = {name: value for name, value in given.items() if value is not None}
        ways = [{"equals", "digits"}, {"at_most", "at_least"}, {"between"}]
        if sum(bool(way & said.keys()) for way in ways) > 1:
            raise CaseError(f"measure {label!r}: give equals, or between, or at_most and at_least")
        if ("equals" in said) != ("digits" in said):
            raise CaseError(f"measure {label!r}: equals and digits go together")
        if not said:
            return None
        equals, digits = given.get("equals"), given.get("digits")
        if equals is not None and digits is not None:
            half = 0.5 * 10.0**-digits * (1.0 + 1e-6)
            return cls(low=equals - half, high=equals + half, digits=digits)
        at_least, at_most = given.get("at_least"), given.get("at_most")
        low, high = given.get("between") or (
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
