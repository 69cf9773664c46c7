"""symmetric: f(x) = f(−x), or f(a, b) = f(b, a), or the same with the sign turned."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.frame import Array

from .law import UNVARIED, Finding, Law, least


@dataclass(frozen=True)
class Symmetric(Law):
    """f(x) = f(−x) for each of `values` of one input; or, `over` two inputs, f(a, b) = f(b, a) for
    each pair (a, b).

    Args:
        output: what is judged.
        over: an input's name, or two.
        values: numbers or vectors, or pairs of them.
        odd: f(x) = −f(−x), or f(a, b) = −f(b, a), instead.
        ulps: how many float32 steps the two may differ by; 0 asks for the same numbers.
        at: other inputs.
        draw: which draw's program.
        name: how outcomes call it.
    """

    kind = "symmetric"

    output: str
    _: KW_ONLY
    values: Sequence[Any]
    odd: bool = False
    ulps: int = 0

    def __post_init__(self) -> None:
        try:
            self.steps  # noqa: B018
        except (TypeError, ValueError):
            both = "numbers or vectors" if isinstance(self.over, str) else "pairs"
            raise CaseError(f"symmetric {self.output!r}: values must be {both}") from None
        if not self.steps or not 0 <= self.ulps < 2**23:
            raise CaseError(f"symmetric {self.output!r}: needs values, and ulps from 0 to 2²³ - 1")
        if not self.odd and all(map(_mirrors_itself, self.steps[0::2], self.steps[1::2])):
            raise CaseError(
                f"symmetric {self.output!r}: all values are their own mirror images",
                remedy="give values other than 0, or pairs of two different ones",
            )
        label = self.over if isinstance(self.over, str) else " and ".join(self.over)
        self.name_by_default(f"{self.output} symmetric in {label}")

    @functools.cached_property
    def steps(self) -> Sequence[Mapping[str, Any]]:
        """Each value and its mirror image, one after the other."""
        found: list[dict[str, Any]] = []
        for value in self.values:
            if isinstance(self.over, str):
                found += [{self.over: value}, {self.over: np.negative(value).tolist()}]
            else:
                pairs = (value, tuple(reversed(value)))
                found += [dict(zip(self.over, pair, strict=True)) for pair in pairs]
        return found

    def find(self, measured: Array) -> Finding:
        one, other = measured[0::2], (-1 if self.odd else 1) * measured[1::2]
        larger = np.maximum(np.abs(one), np.abs(other))
        step = np.spacing(larger.astype(np.float32)).astype(np.float64)
        off = np.abs(one - other) / step
        wrong = int((off > self.ulps).sum())
        i, c = least(-off)
        room = self.ulps * step[i]
        message = ""
        if wrong:
            message = f"{wrong} of {off.size} pairs differ by more than {self.ulps} ULP"
        elif not np.ptp(measured, axis=0).any():
            message = f"it is the same at all values: {UNVARIED}"
        return Finding(
            (2 * i + 1, c),
            one[i],
            one[i] - room,
            one[i] + room,
            wrong,
            message,
            measured=other[i],
        )


def _mirrors_itself(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return all(np.array_equal(one[name], other[name]) for name in one)


symmetric = Symmetric
