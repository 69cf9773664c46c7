"""What the laws share: a property of an output that holds while inputs vary, without a reference.

Each law runs the program on inputs that it gives itself, as a `sweep` does; inputs that it does not
vary stay as the case has them, or as `at` says. Inputs of the stage are gathered into one draw; a
uniform costs a draw for each of its values.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Array, Frame, Samples
from shaderlab.model.records import Outcome, Row, Worst
from shaderlab.model.scene import UniformValue

from ..judging.distance import plain, ulp_distance
from .base import OfOutput
from .needs import Probe

Figure = float | Sequence[float]
UNVARIED = "the law would hold of any constant\n→ vary an input that the output depends on"


@dataclass(frozen=True)
class Finding:
    """What a law says of its runs.

    `place` (run, component) is the value nearest to breaking the law, or breaking it most. It is
    shown beside `reference` between `low` and `high`, with `measured` in place of the runs where
    the law judges something made of them. `wrong` counts what breaks the law, and `message` says
    it. `widths` is the distance to show; by default infinite where the law is broken.
    """

    place: tuple[int, int]
    reference: Any
    low: Any
    high: Any
    wrong: int = 0
    message: str = ""
    rows: tuple[Row, ...] = ()
    measured: Array | None = None
    widths: float | None = None


@dataclass(frozen=True, kw_only=True)
class Law(OfOutput):
    """A law of an output while the input `over` varies; `at` are other inputs by name, those that
    it leaves out stay as the case has them."""

    over: str | tuple[str, str]
    at: Mapping[str, UniformValue] = field(default_factory=dict)

    @property
    @abstractmethod
    def steps(self) -> Sequence[Mapping[str, Any]]:
        """The inputs of each run by name."""

    def require_steps(self) -> None:
        """Raise CaseError if there is nothing to run."""
        if not self.steps:
            raise CaseError(f"{self.name}: needs values of {self.over!r}")

    @abstractmethod
    def find(self, measured: Array) -> Finding:
        """Hold finite float64 values (runs, components) against the law."""

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        self.is_of_vertex(scene, programs)  # raises where there is no such output
        yield Probe(self, [{**self.at, **step} for step in self.steps])

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        samples: Samples = frame.answers[Probe(self)]
        measured = samples.outputs[self.own_name(scene)].astype(np.float64)
        finite = np.isfinite(measured)
        if finite.all():
            found = self.find(measured)
        else:
            i, c = (int(k) for k in np.argwhere(~finite)[0])
            count = int((~finite).sum())
            found = Finding(
                (i, c), measured[i], -np.inf, np.inf, count, f"{count} values are not finite"
            )
        return Judgement(
            outcome=Outcome(
                name=self.name,
                kind=self.kind,
                status="fail" if found.message else "pass",
                message=found.message,
                judged=int(measured.size),
                outside=found.wrong,
                worst=self._worst(found, samples, measured),
                rows=found.rows,
            )
        )

    def _worst(self, found: Finding, samples: Samples, measured: Array) -> Worst:
        i, c = found.place
        values = measured[i] if found.measured is None else found.measured
        reference, low, high = (
            np.broadcast_to(part, values.shape) for part in (found.reference, found.low, found.high)
        )
        broken = math.inf if found.message else 0.0
        return Worst(
            pixel=None,
            component=c,
            measured=plain(values),
            reference=plain(reference),
            low=plain(low),
            high=plain(high),
            ulp=ulp_distance(values[c], float(reference[c])),
            widths=broken if found.widths is None else found.widths,
            inputs={
                name: plain(samples.inputs[name][i])
                for name in dict.fromkeys((*self.steps[i], *self.at))
                if name in samples.inputs and samples.inputs[name][i].ndim == 1
            },
        )


def least(values: Array) -> tuple[int, int]:
    """The place (run, component) of the least value, the first of equals."""
    index, component = np.unravel_index(int(np.argmin(values)), values.shape)
    return int(index), int(component)
