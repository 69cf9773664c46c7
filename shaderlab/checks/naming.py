"""What an expectation's names mean: which pass, draw and attachment, and what they hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.checks.inputs import Inputs
from shaderlab.errors import CaseError, nearest
from shaderlab.frame import Array, Frame, Image, PassDraw
from shaderlab.model import Formula, Property, Scene, Sweep, Value, output_of
from shaderlab.model import Output as PassOutput


def split_output(name: str, scene: Scene | None = None) -> tuple[str | None, str]:
    """An output's pass (None for the last) and its own name.

    With the scene's passes known, "VS_OUT.FragPos" is a block's member unless a pass is called
    VS_OUT; without them, what stands before the last dot is a pass.
    """
    if scene is None:
        split = output_of(name)
        return (split.pass_name, split.name) if isinstance(split, PassOutput) else (None, split)
    head, dot, rest = name.partition(".")
    if dot and any(head == description.name for description in scene.passes):
        return head, rest
    return None, name


def draw_key(scene: Scene, pass_name: str | None, draw: int) -> PassDraw:
    """The (pass, draw) that an expectation means; negative draws count from the last one."""
    description = scene.find_pass(pass_name)
    count = len(description.draws)
    if not -count <= draw < count:
        raise CaseError(f"pass {description.name!r} has {count} draws, there is no draw {draw}")
    return description.name, draw % count


def find_image(name: str, scene: Scene, frame: Frame) -> Image:
    """The attachment an output's name means; without a pass, the last pass's."""
    pass_name, own = split_output(name, scene)
    key = (pass_name or frame.order[-1], own)
    if key not in frame.images:
        known = [f"{p}.{n}" for p, n in frame.images]
        raise CaseError(f"there is no output {name!r}", remedy=nearest(name, known))
    return frame.images[key]


@dataclass(frozen=True, kw_only=True)
class Subject:
    """What a formula is about: measured values (count, components), and the inputs they came of.

    `image` and `covered` (height, width) are None where vertices are judged.
    """

    measured: Array
    inputs: Inputs
    format: str = "rgba32f"
    image: Image | None = None
    covered: npt.NDArray[np.bool_] | None = None


def subject_of(expectation: Formula, scene: Scene, frame: Frame) -> Subject:
    """The vertices or the covered pixels that a formula judges, with what their shader got."""
    pass_name, name = split_output(expectation.output, scene)
    key = draw_key(scene, pass_name, expectation.draw)

    def given(each: dict[str, Array]) -> Inputs:
        return inputs_of(frame, key, each=each, given=expectation.given)

    if key in frame.vertices and (key[0], name) not in frame.images:
        samples = frame.vertices[key]
        return Subject(measured=samples.outputs[name], inputs=given(dict(samples.inputs)))
    image = find_image(expectation.output, scene, frame)
    covered = frame.fragments[key].covered
    whole = bool(covered.all())

    def of_covered(values: Array) -> Array:
        # Most draws cover everything; then nothing need be copied.
        return values.reshape(-1, *values.shape[2:]) if whole else values[covered]

    each = {name: of_covered(values) for name, values in pixel_inputs(frame, key).items()}
    return Subject(
        measured=of_covered(image.values),
        inputs=given(each),
        format=image.format,
        image=image,
        covered=covered,
    )


def inputs_of(
    frame: Frame,
    key: PassDraw,
    *,
    each: Mapping[str, Array],
    given: Mapping[str, Any],
    decimal: Mapping[str, Array] | None = None,
) -> Inputs:
    """All that a reference may ask for about one draw: its bindings, what differs from value to
    value, the check's own constants, and where the driver takes samples (`sample_positions` of its
    own pass, `edge_sample_positions` of the pass "edge")."""
    inputs = Inputs.of(frame.bindings[key], each=each, given=given, decimal=decimal)
    found = {f"{name}_sample_positions": p for name, p in frame.sample_positions.items()}
    if key[0] in frame.sample_positions:
        found["sample_positions"] = frame.sample_positions[key[0]]
    found = {name: p for name, p in found.items() if name not in inputs.exact}
    return replace(inputs, shared={**found, **inputs.shared}, arrays=inputs.arrays | found.keys())


def pixel_inputs(frame: Frame, key: PassDraw) -> dict[str, Array]:
    """Captured inputs of every pixel of a draw, `frag_coord` among them."""
    fragments = frame.fragments[key]
    return {**fragments.inputs, "frag_coord": fragments.frag_coord}


def reference_for(expectation: Value, scene: Scene) -> Any:
    """The value's own reference, or that of the formula of the same output."""
    if expectation.reference is not None:
        return expectation.reference
    for other in scene.expect:
        if isinstance(other, Property):
            continue
        if isinstance(other, Formula | Sweep) and other.output == expectation.output:
            return other.reference
    return None
