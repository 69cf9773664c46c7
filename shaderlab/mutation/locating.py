"""Which statement a killed mutant is traced to: the first at which what the driver computes leaves
the band of the shader as it was."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from shaderlab.analysis.driver_values import driver_values
from shaderlab.analysis.explain import Trace, trace_invocations
from shaderlab.analysis.interpreter import Bands, Stored
from shaderlab.analysis.invocations import Invocations, sample_fragments
from shaderlab.analysis.self_check import find_outside
from shaderlab.engine.evaluation import Evaluation
from shaderlab.errors import ShaderlabError
from shaderlab.files import display_path
from shaderlab.model.frame import PassDraw

_MOST_PIXELS = 1024
Traces = Mapping[PassDraw, tuple[Invocations, Trace] | None]


def trace_draws(right: Evaluation) -> Traces:
    """Return what each draw's fragments store in bands, while the scene is on the device; None for
    those that can't be interpreted."""
    return {key: _trace_of(right, key) for key in right.drawn.bindings}


def _trace_of(evaluation: Evaluation, key: PassDraw) -> tuple[Invocations, Trace] | None:
    try:
        inputs = sample_fragments(evaluation, key, _MOST_PIXELS)
        return (inputs, trace_invocations(inputs, Bands())) if inputs.count else None
    except ShaderlabError:
        return None


def find_first_wrong(
    wrong: Evaluation, right: Evaluation, traces: Traces
) -> tuple[Invocations, Trace, Stored | None] | None:
    """Return the first value that a wrong shader stores and the right one does not allow.

    Looks at the draws whose fragment shader differs; None if no output leaves its band.

    Raises:
        ShaderlabError: the driver can't draw the shader's statements.
    """
    for key, found in traces.items():
        if found is None or key[0] not in wrong.programs:
            continue
        text = wrong.programs[key[0]][key[1]].text("fragment") or ""
        if text != right.programs[key[0]][key[1]].text("fragment"):
            inputs, trace = found
            if _leaves_band(wrong, key, inputs, trace):
                return inputs, trace, _first_outside(wrong, key, inputs, trace)
    return None


def locate_mistake(wrong: Evaluation, right: Evaluation, traces: Traces) -> str:
    """Return the place and name of the first value that is wrong, "lamp.frag:12: diffuse"; "" where
    none is found."""
    try:
        found = find_first_wrong(wrong, right, traces)
    except ShaderlabError:
        return ""
    if found is None or found[2] is None:
        return ""
    file, line = found[0].program.place(found[2].line)
    return f"{display_path(file, line)}: {found[2].name}"


def _leaves_band(wrong: Evaluation, key: PassDraw, inputs: Invocations, trace: Trace) -> bool:
    """Whether an output of a wrong drawing lies outside of the right program's band."""
    assert inputs.pixels is not None
    at = inputs.pixels[:, 1], inputs.pixels[:, 0]
    images = {n: i for (name, n), i in wrong.drawn.images.items() if name == key[0]}
    drawn = replace(inputs, measured={name: image.values[at] for name, image in images.items()})
    flags = (find_outside(drawn, name, band) for name, band in trace.outputs.items())
    return any(found is not None and bool(found.any()) for found in flags)


def _first_outside(
    wrong: Evaluation, key: PassDraw, inputs: Invocations, trace: Trace
) -> Stored | None:
    """The first value of the driver's that is not in the band of what was stored there."""
    seen = driver_values(wrong, key, inputs, trace.stored, trace.undecided)
    for found in seen:
        if (found.reached & ~found.watched.allows(found.values)).any():
            return found.watched.event
    return None
