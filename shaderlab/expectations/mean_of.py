"""mean_of: the mean of an output over many samples does not differ from a figure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.expectations.law import At, Figure, Finding, Law
from shaderlab.frame import Array
from shaderlab.judging.figures import shown
from shaderlab.model import UniformValue
from shaderlab.records import Row


@dataclass(frozen=True, kw_only=True)
class MeanOf(Law):
    """The mean does not differ from `equals` at this significance (two-sided z-test)."""

    kind = "mean"

    equals: Figure
    significance: float

    def find(self, measured: Array) -> Finding:
        count = len(measured)
        expected = np.broadcast_to(np.asarray(self.equals, np.float64), measured.shape[1:])
        mean = measured.mean(axis=0)
        error = measured.std(axis=0, ddof=1) / math.sqrt(count)
        difference = mean - expected
        with np.errstate(all="ignore"):
            z = np.where(difference == 0.0, 0.0, difference / error)
        chance = np.array([math.erfc(abs(value) / math.sqrt(2.0)) for value in z])
        wrong = chance < self.significance
        rows = tuple(
            Row(
                label="mean" if measured.shape[1] == 1 else f"mean of {'xyzw'[k]}",
                expected=shown(expected[k]),
                measured=f"{mean[k]:.6g} ± {error[k]:.2g} (n = {count})",
                ok=not wrong[k],
                note=f"z = {z[k]:.2f}, p = {chance[k]:.2g}, α = {self.significance:g}",
            )
            for k in range(measured.shape[1])
        )
        c = int(np.argmin(chance))
        message = (
            f"a mean of {mean[c]:.6g} or further off has a chance of {chance[c]:.2g} "
            f"among {count} samples"
        )
        return Finding(
            (int(np.argmax(np.abs(measured[:, c] - expected[c]))), c),
            expected,
            expected - error,
            expected + error,
            int(wrong.sum()),
            message if wrong.any() else "",
            rows,
            measured=mean,
            widths=float(np.abs(z[c])),
        )


def mean_of(
    output: str,
    equals: Figure,
    *,
    over: str,
    values: Sequence[UniformValue],
    significance: float = 1e-3,
    at: At = None,
    draw: int = -1,
    name: str = "",
) -> MeanOf:
    """The mean of `output` over many samples is `equals`: a two-sided z-test, for each component.

    A shader whose true mean is `equals` fails at `significance` in 1/significance choices of
    samples; the samples are given, so the same shader always gets the same verdict.

    Args:
        output: what is judged.
        equals: the expected mean, a number or one for each component.
        over: the input that the samples are taken over (a seed, a coordinate).
        values: one for each sample, at least 30 for the normal distribution to be a fair guess.
        significance: the test's level α, in 0…1.
        at: other inputs.
        draw: which draw's program.
        name: how outcomes call it.
    """
    steps = tuple({over: v} for v in values)
    if len(steps) < 30 or not 0.0 < significance < 1.0:
        raise CaseError("mean_of: needs 30 samples or more, and a significance between 0 and 1")
    return MeanOf(
        output=output,
        over=over,
        steps=steps,
        equals=equals,
        significance=significance,
        at=at or {},
        draw=draw,
        name=name or f"mean of {output}",
    )
