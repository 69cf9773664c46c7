"""The values that an expectation judges, and the inputs that its reference gets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.drivers.programs import images
from shaderlab.errors import CaseError, nearest
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, Frame, Image, PassDraw
from shaderlab.model.scene import UniformValue

from ..judging.inputs import Inputs
from .base import OfOutput
from .needs import CapturedFragments, CapturedVertices


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
    expectation: OfOutput, given: Mapping[str, UniformValue], scene: Scene, frame: Frame
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
    covered = frame.answers[CapturedFragments(key)].covered
    if frame.bindings[key].computes:  # every element and texel, whatever invocations there are
        covered = np.ones(image.values.shape[:2], bool)
    whole = bool(covered.all())

    def of_covered(values: Array) -> Array:
        # Most draws cover everything; then nothing need be copied.
        return values.reshape(-1, *values.shape[2:]) if whole else values[covered]

    each = {name: of_covered(values) for name, values in pixel_inputs(frame, key, image).items()}
    return Subject(
        measured=of_covered(image.values),
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
    """The attachment that an output's name means; without a pass, the last pass's.

    Raises:
        CaseError: there is no such output; names those that there are.
    """
    pass_name, own = scene.split_output(name)
    key = (pass_name or frame.order[-1], own)
    if key not in frame.images:
        known = [f"{p}.{n}" for p, n in frame.images]
        raise CaseError(f"there is no output {name!r}", remedy=nearest(name, known))
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
    fragments = frame.answers[CapturedFragments(key)]
    bindings = frame.bindings[key]
    if bindings.computes:
        found = images.laid_out(fragments.inputs, image)
        if any(image is frame.images.get((key[0], name)) for name in bindings.images):
            found["texel"] = images.texel_places(image)
        return found
    return {**fragments.inputs, "frag_coord": fragments.frag_coord}
