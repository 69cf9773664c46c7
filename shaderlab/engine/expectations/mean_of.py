"""mean_of: the mean of an output over many samples does not differ from a figure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.frame import Array
from shaderlab.model.records import Row
from shaderlab.model.scene import UniformValue

from ..judging.distance import shown
from .law import Figure, Finding, Law


@dataclass(frozen=True)
class MeanOf(Law):
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

    kind = "mean"

    output: str
    equals: Figure
    _: KW_ONLY
    values: Sequence[UniformValue]
    significance: float = 1e-3

    def __post_init__(self) -> None:
        if len(self.values) < 30 or not 0.0 < self.significance < 1.0:
            raise CaseError("mean_of: needs 30 samples or more, and a significance between 0 and 1")
        self.name_by_default(f"mean of {self.output}")

    @property
    def steps(self) -> Sequence[Mapping[str, Any]]:
        return [{str(self.over): v} for v in self.values]

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


mean_of = MeanOf
