"""symmetric: f(x) = f(−x), or f(a, b) = f(b, a), or the same with the sign turned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.expectations.law import At, Finding, Law, least
from shaderlab.frame import Array


@dataclass(frozen=True, kw_only=True)
class Symmetric(Law):
    """Of each two runs, the second gives `sign` times the first, within `ulps`."""

    kind = "symmetric"

    sign: int
    ulps: int

    def find(self, measured: Array) -> Finding:
        one, other = measured[0::2], self.sign * measured[1::2]
        larger = np.maximum(np.abs(one), np.abs(other))
        step = np.spacing(larger.astype(np.float32)).astype(np.float64)
        off = np.abs(one - other) / step
        wrong = int((off > self.ulps).sum())
        i, c = least(-off)
        room = self.ulps * step[i]
        message = f"{wrong} of {off.size} pairs differ by more than {self.ulps} ULP"
        return Finding(
            (2 * i + 1, c),
            one[i],
            one[i] - room,
            one[i] + room,
            wrong,
            message if wrong else "",
            measured=other[i],
        )


def symmetric(
    output: str,
    *,
    over: str | tuple[str, str],
    values: Sequence[Any],
    odd: bool = False,
    ulps: int = 0,
    at: At = None,
    draw: int = -1,
    name: str = "",
) -> Symmetric:
    """f(x) = f(−x) for each of `values` of one input; or, `over` two inputs, f(a, b) = f(b, a) for
    each pair (a, b).

    Args:
        output: what is judged.
        over: an input's name, or two.
        values: numbers or vectors, or pairs of them.
        odd: f(x) = −f(−x), or f(a, b) = −f(b, a), instead.
        ulps: how many float32 steps the two may differ by; none says, the same numbers.
        at: other inputs.
        draw: which draw's program.
        name: how outcomes call it.
    """
    steps: list[dict[str, Any]] = []
    for value in values:
        if isinstance(over, str):
            steps += [{over: value}, {over: np.negative(value).tolist()}]
        else:
            one, other = value
            steps += [dict(zip(over, pair, strict=True)) for pair in ((one, other), (other, one))]
    if not steps or ulps < 0:
        raise CaseError(f"symmetric {output!r}: needs values, and ulps of 0 or more")
    label = over if isinstance(over, str) else " and ".join(over)
    return Symmetric(
        output=output,
        over=label,
        steps=tuple(steps),
        sign=-1 if odd else 1,
        ulps=ulps,
        at=at or {},
        draw=draw,
        name=name or f"{output} symmetric in {label}",
    )
