"""formula and sweep: an output lies in the band derived from a reference, at every covered pixel or
vertex, or along one input."""

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any

import numpy as np

from shaderlab.bands import Rules
from shaderlab.engine.expectations.base import OutputExpectation
from shaderlab.engine.expectations.needs import (
    CapturedFragments,
    CapturedVertices,
    Probe,
    inputs_of,
    subject_of,
)
from shaderlab.engine.judging.banded import Banded, independent_references, judge_band
from shaderlab.engine.judging.references import parameter_names, parameters_of
from shaderlab.errors import CaseError, suggest
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Array, Frame, Image
from shaderlab.model.records import Row
from shaderlab.model.scene import UniformValue

Reference = Callable[..., Any]


@dataclass(frozen=True, kw_only=True)
class ReferenceExpectation(OutputExpectation):
    """An expectation that holds an output against a reference's band.

    Attributes:
        reference: a formula over float64 arrays and bands alike.
        given: further inputs of it by name, as exact float32 values.
        rules: precision rules; None for the default ones.
    """

    reference: Any
    given: Mapping[str, UniformValue] = field(default_factory=dict)
    rules: Rules | None = None

    def __post_init__(self) -> None:
        if self.reference is not None:
            self.require_read(self.reference, *getattr(self, "also", {}).values())

    def require_read(self, *references: Any) -> None:
        """Raise CaseError for a name in `given` that neither these nor `discards` ask for."""
        asking = filter(None, (*references, self.discards))
        taken = {name for reference in asking for name in parameters_of(reference)}
        stands = parameter_names(*self.given)
        read = {name for parameter in taken & stands.keys() for name in stands[parameter]}
        for name in sorted(self.given.keys() - read):
            raise CaseError(
                f"{self.kind} {self.output!r}: given has {name!r}, which no reference asks for",
                remedy=suggest(name, taken),
            )

    def judgement(
        self,
        scene: Scene,
        banded: Banded,
        verdict: tuple[str, str],
        rows: Sequence[Row] = (),
        *,
        covered: Array | None = None,
        rows_show_worst: bool = False,
        **shown: Any,
    ) -> Judgement:
        """The judgement of banded values; `shown` is what else `Judgement` has to show."""
        status, message = verdict
        outcome = banded.outcome(
            covered,
            name=self.name,
            kind=self.kind,
            status=status,
            message=message,
            rows=tuple(rows),
            rows_show_worst=rows_show_worst,
            sources=(banded.source,),
        )
        return Judgement(outcome=outcome, output=(self.key(scene), self.own_name(scene)), **shown)


@dataclass(frozen=True)
class Formula(ReferenceExpectation):
    """Every covered pixel (or vertex) of `output` lies in the band derived from `reference`.

    The reference's parameters are found by name: captured varyings (or attributes), uniforms
    (`light.constant` as `light_constant`), textures, `frag_coord`, and what `given` adds.

    Args:
        output: see `OutputExpectation`.
        reference: a formula over float64 arrays and bands alike, built with `shaderlab.glslmath`.
        draw: which draw of the pass the inputs come from; the last by default.
        given: further inputs by name, as exact float32 values.
        also: independent implementations by name; in float64 each must lie in the band too.
        rules: other precision rules than the default ones.
        name: how outcomes call it; the output's name by default.
    """

    kind = "formula"

    output: str
    reference: Reference
    _: KW_ONLY
    also: Mapping[str, Reference] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for implementation in self.also.values():
            if implementation is self.reference:
                raise CaseError(f"formula {self.output!r}: also= has the reference itself")

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        key = self.key(scene)
        of_pixels = self.is_of_depth(scene, programs) or not self.is_of_vertex(scene, programs)
        yield CapturedFragments(key) if of_pixels else CapturedVertices(key)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        subject = subject_of(self, self.given, scene, frame)
        banded = judge_band(
            subject.measured,
            self.reference,
            subject.inputs,
            rules=self.rules,
            format=subject.format,
        )
        rows = independent_references(banded, self.also)
        status, message = banded.verdict()
        if status == "pass" and not all(row.ok for row in rows):
            status, message = "fail", "an independent implementation is outside the band"
        covered, image = subject.covered, subject.image
        pictures = None
        if image is not None and covered is not None:
            pictures = functools.partial(_pictures, image, covered, banded)
        return self.judgement(
            scene, banded, (status, message), rows, covered=covered, pictures=pictures
        )


def _pictures(image: Image, covered: Array, banded: Banded) -> dict[str, Any]:
    def lay_out(values: Array, nothing: float) -> Array:
        shape = (*covered.shape, *values.shape[1:])
        if len(values) == covered.size:  # as most draws have it: nothing need be copied
            return values.reshape(shape)
        full = np.full(shape, nothing, values.dtype)
        full[covered] = values
        return full

    def reference() -> Array:
        values = banded.reference
        if image.values.dtype.kind in "iu":
            values = np.nan_to_num(np.rint(values)).astype(image.values.dtype)
        return lay_out(values, 0)

    return {
        "measured": lay_out(banded.measured, 0),
        "reference": reference,
        "distance": lambda: lay_out(banded.measure_distances(), np.nan),
        "covered": covered,
        "exact": banded.band.values_at,
        "low": banded.low.__getitem__,
        "high": banded.high.__getitem__,
        "outside": lambda rows: ~banded.inside[rows],
        "unit": np.asarray(banded.unit or 0.0),
    }


@dataclass(frozen=True)
class Sweep(ReferenceExpectation):
    """The band holds while the input `over` takes each of `values`; the report draws the curve.

    `at` gives other inputs by name; what it leaves out stays. For the rest see `Formula`.
    """

    kind = "sweep"
    named = "{self.output} over {self.over}"

    output: str
    reference: Reference
    _: KW_ONLY
    over: str
    values: Sequence[float]
    at: Mapping[str, UniformValue] = field(default_factory=dict)
    log_x: bool = False

    def __post_init__(self) -> None:
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
        key, samples = self.key(scene), frame.answer(Probe(self))
        inputs = inputs_of(
            frame, key, each=dict(samples.inputs), given=self.given, decimal=samples.decimal
        )
        banded = judge_band(
            samples.outputs[self.own_name(scene)], self.reference, inputs, rules=self.rules
        )
        drawn = banded.curve(self.name, self.over, self.output, self.values)
        curve = replace(drawn, log_x=self.log_x)
        return self.judgement(scene, banded, banded.verdict(), curve=curve)


formula = Formula
sweep = Sweep
