"""sweep: the band holds along one input, all others fixed; the report draws the curve."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Frame
from shaderlab.model.records import Curve
from shaderlab.model.scene import UniformValue

from ..judging.banded import judge_band
from .formula import OfReference, Reference
from .needs import Probe
from .subject import inputs_of


@dataclass(frozen=True)
class Sweep(OfReference):
    """The band holds while the input `over` takes each of `values`; the report draws the curve.

    `at` gives other inputs by name; those that it leaves out stay as the case has them. For the
    rest see `Formula`.
    """

    kind = "sweep"
    judges = "curve"

    output: str
    reference: Reference
    _: KW_ONLY
    over: str
    values: Sequence[float]
    at: Mapping[str, UniformValue] = field(default_factory=dict)
    log_x: bool = False

    def __post_init__(self) -> None:
        self.name_by_default(f"{self.output} over {self.over}")
        object.__setattr__(self, "values", tuple(float(v) for v in self.values))
        if not self.values:
            raise CaseError(
                f"sweep of {self.output!r}: there are no values of {self.over!r}",
                remedy="values=[0.0, 0.5, 1.0], or np.linspace(0.0, 1.0, 50)",
            )

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        self.is_of_vertex(scene, programs)  # raises where there is no such output
        yield Probe(self, [{**self.at, self.over: value} for value in self.values])

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        key, samples = self.key(scene), frame.answers[Probe(self)]
        inputs = inputs_of(
            frame, key, each=dict(samples.inputs), given=self.given, decimal=samples.decimal
        )
        banded = judge_band(
            samples.outputs[self.own_name(scene)], self.reference, inputs, rules=self.rules
        )
        component = int(np.argmax(np.ptp(banded.reference, axis=0)))
        several = banded.measured.shape[1] > 1
        curve = Curve(
            title=self.name,
            x_label=self.over,
            y_label=f"{self.output}.{'xyzw'[component]}" if several else self.output,
            x=tuple(self.values),
            measured=tuple(banded.measured[:, component].tolist()),
            reference=tuple(banded.reference[:, component].tolist()),
            low=tuple(banded.low[:, component].tolist()),
            high=tuple(banded.high[:, component].tolist()),
            log_x=self.log_x,
        )
        return self.judgement(scene, banded, banded.verdict(), curve=curve)


sweep = Sweep
