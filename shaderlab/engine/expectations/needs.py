"""What a stage got and gave, in a draw or on given inputs; the values that are judged."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.drivers import Session
from shaderlab.drivers.programs import storage
from shaderlab.drivers.programs.bind import convert_inputs, convert_value, find_declared_uniforms
from shaderlab.drivers.programs.prepare import PreparedDraw
from shaderlab.drivers.programs.stages import array_elements, changes_inputs, may_drop_fragments
from shaderlab.engine.expectations.base import Context, OutputExpectation
from shaderlab.engine.judging.references import Inputs
from shaderlab.errors import CaseError, UnsupportedError, suggest
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Programs
from shaderlab.model.frame import (
    Array,
    Bindings,
    Fragments,
    Frame,
    Image,
    PassDraw,
    Samples,
    TypedNeed,
)
from shaderlab.model.phases import phase
from shaderlab.model.scene import UniformValue

BEFORE_RASTERISATION = ("vertex", "tess_control", "tess_evaluation", "geometry")


@dataclass(frozen=True)
class CapturedFragments(TypedNeed[Fragments]):
    """What a draw's fragment shader got, at each pixel, or a dispatch's invocations."""

    key: PassDraw

    def answer(self, context: Context) -> Fragments:
        with phase("draw", f"capturing the inputs of {context.describe_draw(self.key)}"):
            return context.session.capture_fragments(self.key)

    def misplaced(self, found: Fragments, programs: Programs) -> str:
        """As `Fragments.misplaced`; "" where the shader may count from elsewhere."""
        draw = programs[self.key[0]][self.key[1]]
        if draw.draw.compute or changes_inputs(draw.text("fragment")):
            return ""
        return found.misplaced

    def has_same_answer(self, programs: Programs, others: Programs) -> bool:
        for own, other in zip(programs[self.key[0]], others[self.key[0]], strict=True):
            if own.draw is not other.draw:
                return False  # other state may let other fragments through
            if own.draw.compute:
                return False  # an earlier pass may have left something else
            if not _same_stages(own, other):
                return False
            text, other_text = own.text("fragment"), other.text("fragment")
            if text != other_text and may_drop_fragments(text + other_text):
                return False
        return True


@dataclass(frozen=True)
class CapturedVertices(TypedNeed[Samples]):
    """What the last stage before rasterisation got and gave, at each vertex of a draw."""

    key: PassDraw

    def answer(self, context: Context) -> Samples:
        with phase("draw", f"capturing the inputs of {context.describe_draw(self.key)}"):
            return context.session.capture_vertices(self.key)

    def has_same_answer(self, programs: Programs, others: Programs) -> bool:
        name, index = self.key
        return _same_stages(programs[name][index], others[name][index])


@dataclass(frozen=True, eq=False)
class OwnSamples(TypedNeed[Samples]):
    """A draw's program run for one expectation alone: two of one kind are the same if they are of
    the very same expectation."""

    expectation: Any

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other.expectation is self.expectation

    def __hash__(self) -> int:
        return hash((type(self), id(self.expectation)))


@dataclass(frozen=True, eq=False)
class Probe(OwnSamples):
    """A draw's program run on inputs that an expectation of its output gives.

    Inputs of the stage are gathered into one draw; a uniform takes one draw for each value. `steps`
    are inputs and uniforms of each run, by name; all have the same names.
    """

    expectation: OutputExpectation
    steps: Sequence[Mapping[str, Any]] = ()

    def answer(self, context: Context) -> Samples:
        """Run the program. Raises CaseError for a name that is no input and no uniform."""
        with phase("draw", f"sampling for {self.expectation.name!r}"):
            return self._answer(context)

    def _answer(self, context: Context) -> Samples:
        session, steps = context.session, self.steps
        key = self.expectation.key(session.scene)
        draw, bindings = session.programs[key[0]][key[1]], context.bindings[key]
        if draw.draw.compute:
            raise UnsupportedError(
                f"{draw.draw.compute}: running a compute stage on given inputs",
                remedy="judge what it leaves in its buffers: formula, exact, measure, or "
                "value(…, at=Pixel(element, 0))",
            )
        of_vertex = self.expectation.is_of_vertex(session.scene, session.programs)
        variables = draw.interface.attributes if of_vertex else draw.interface.varyings
        inputs = {variable.name: variable for variable in array_elements(variables.values())}
        uniforms = [name for name in steps[0] if name not in inputs]
        for name in uniforms:
            if name not in bindings.uniforms:
                raise CaseError(
                    f"{self.expectation.output}: {name!r} is not an input of "
                    f"{' + '.join(draw.draw.shaders)}",
                    remedy=suggest(name, [*inputs, *bindings.uniforms]),
                )
        groups = [[step] for step in steps] if uniforms else [steps]
        changes = [
            _replace_uniforms(bindings, draw, {name: group[0][name] for name in uniforms})
            for group in groups
        ]
        if len(uniforms) == len(steps[0]):
            found = self._run(session, of_vertex, changes, {})
        else:
            found = []
            for group, change in zip(groups, changes, strict=True):
                each = [convert_inputs(inputs, step) for step in group]
                given = {name: np.concatenate([one[name] for one in each]) for name in each[0]}
                found += self._run(session, of_vertex, [change], given)
        parts = zip(groups, changes, found, strict=True)
        return _join([_add_inputs(got, group, change, uniforms) for group, change, got in parts])

    def _run(
        self,
        session: Session,
        of_vertex: bool,
        runs: Sequence[Bindings],
        given: Mapping[str, Array],
    ) -> list[Samples]:
        key = self.expectation.key(session.scene)
        found = session.probe(key, "vertex" if of_vertex else "fragment", runs, given)
        if of_vertex and self.expectation.own_name(session.scene) not in found[0].outputs:
            draw = session.programs[key[0]][key[1]].draw
            raise UnsupportedError(
                f"running {draw.geometry or draw.tess_evaluation} on given inputs: "
                "it takes whole primitives",
                remedy="judge what it makes of the mesh (formula), with a mesh that has these "
                "inputs",
            )
        return found


def _add_inputs(
    got: Samples, steps: Sequence[Mapping[str, Any]], given: Bindings, uniforms: Sequence[str]
) -> Samples:
    count = len(steps)
    exact = {name: np.repeat(given.uniforms[name][None], count, axis=0) for name in uniforms}
    decimal = {name: np.repeat(given.decimal[name][None], count, axis=0) for name in uniforms}
    for name in (name for name in steps[0] if name not in exact):
        decimal[name] = np.array([np.atleast_1d(np.asarray(s[name], np.float64)) for s in steps])
    return replace(got, inputs={**got.inputs, **exact}, decimal=decimal)


def _same_stages(one: PreparedDraw, other: PreparedDraw) -> bool:
    return all(one.text(stage) == other.text(stage) for stage in BEFORE_RASTERISATION)


def _replace_uniforms(
    bindings: Bindings, draw: PreparedDraw, values: Mapping[str, Any]
) -> Bindings:
    exact, decimal = dict(bindings.uniforms), dict(bindings.decimal)
    known = find_declared_uniforms(draw.interface)
    for name, value in values.items():
        exact[name], decimal[name] = convert_value(known[name], value)
    return replace(bindings, uniforms=exact, decimal=decimal)


def _join(parts: Sequence[Samples]) -> Samples:
    if len(parts) == 1:
        return parts[0]

    def join(group: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
        return {name: np.concatenate([part[name] for part in group]) for name in group[0]}

    return Samples(
        inputs=join([p.inputs for p in parts]),
        outputs=join([p.outputs for p in parts]),
        decimal=join([p.decimal for p in parts]),
        discarded=sum(p.discarded for p in parts),
    )


@dataclass(frozen=True, kw_only=True)
class Subject:
    """Measured values (count, components), and the inputs that they came of.

    `image` and `covered` (height, width) are None where vertices are judged.
    """

    measured: Array
    inputs: Inputs
    format: str = "rgba32f"
    image: Image | None = None
    covered: npt.NDArray[np.bool_] | None = None


def subject_of(
    expectation: OutputExpectation, given: Mapping[str, UniformValue], scene: Scene, frame: Frame
) -> Subject:
    """The vertices or the covered pixels of an output, with what their shader got.

    `given` are the expectation's own constants. Raises CaseError for an output that is not there.
    """
    key, name = expectation.key(scene), expectation.own_name(scene)
    samples = frame.answers.get(CapturedVertices(key))
    if samples is not None and (key[0], name) not in frame.images:
        samples = samples.of_output(name)
        inputs = inputs_of(frame, key, each=dict(samples.inputs), given=given)
        return Subject(measured=samples.outputs[name], inputs=inputs)
    image = find_image(expectation.output, scene, frame)
    covered = frame.answer(CapturedFragments(key)).covered
    if frame.bindings[key].computes:  # every element and texel, whatever invocations there are
        covered = np.ones(image.values.shape[:2], bool)
    whole = bool(covered.all())

    def take_covered(values: Array) -> Array:
        # Most draws cover everything; then nothing need be copied.
        return values.reshape(-1, *values.shape[2:]) if whole else values[covered]

    each = {name: take_covered(values) for name, values in pixel_inputs(frame, key, image).items()}
    return Subject(
        measured=take_covered(image.values),
        inputs=inputs_of(
            frame, key, each=each, given=given, decimal=decimal_inputs(frame, key, each)
        ),
        format=image.format,
        image=image,
        covered=covered,
    )


def decimal_inputs(frame: Frame, key: PassDraw, each: Mapping[str, Array]) -> dict[str, Array]:
    """What the buffers of a dispatch held before, as the case wrote it, of those that differ from
    element to element; (count, components)."""
    bindings = frame.bindings[key]
    return {
        name: bindings.decimal[name] if name in bindings.arrays else bindings.decimal[name][None]
        for name in bindings.buffers.keys() & each.keys()
    }


def find_image(name: str, scene: Scene, frame: Frame) -> Image:
    """The attachment that an output's name means; without a pass, the last pass's. Raises
    CaseError: there is no such output; names those that there are."""
    pass_name, own = scene.split_output(name)
    key = (pass_name or frame.order[-1], own)
    if key not in frame.images:
        known = [f"{p}.{n}" for p, n in frame.images]
        raise CaseError(f"there is no output {name!r}", remedy=suggest(name, known))
    return frame.images[key]


def inputs_of(
    frame: Frame,
    key: PassDraw,
    *,
    each: Mapping[str, Array],
    given: Mapping[str, Any],
    decimal: Mapping[str, Array] | None = None,
) -> Inputs:
    """All that a reference may ask for about one draw: its bindings, what differs from value to
    value, the expectation's own constants, and where the driver takes samples (`sample_positions`
    of its own pass, `edge_sample_positions` of the pass "edge")."""
    inputs = Inputs.of(frame.bindings[key], each=each, given=given, decimal=decimal)
    found = {f"{name}_sample_positions": p for name, p in frame.sample_positions.items()}
    if key[0] in frame.sample_positions:
        found["sample_positions"] = frame.sample_positions[key[0]]
    found = {name: p for name, p in found.items() if name not in inputs.exact}
    return replace(inputs, shared={**found, **inputs.shared}, arrays=inputs.arrays | found.keys())


def pixel_inputs(frame: Frame, key: PassDraw, image: Image) -> dict[str, Array]:
    """Captured inputs of every pixel of a draw's output, `frag_coord` among them; of a dispatch
    what there is one of for each element or texel of that output, and where each `texel` is."""
    fragments = frame.answer(CapturedFragments(key))
    bindings = frame.bindings[key]
    if bindings.computes:
        found = storage.lay_out(fragments.inputs, image)
        if any(image is frame.images.get((key[0], name)) for name in bindings.images):
            found["texel"] = storage.texel_places(image)
        return found
    return {**fragments.inputs, "frag_coord": fragments.frag_coord}
