"""What a stage got and gave, in a draw or on given inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shaderlab.drivers.programs.bind import declared, exact_inputs, value_arrays
from shaderlab.drivers.programs.prepare import PreparedDraw
from shaderlab.drivers.programs.stages import changes_inputs, elements, may_keep_out
from shaderlab.errors import CaseError, UnsupportedError, nearest
from shaderlab.model.activity import doing
from shaderlab.model.expectation import Need, Programs
from shaderlab.model.frame import Array, Bindings, Fragments, PassDraw, Samples

from .base import Context, OfOutput

BEFORE_RASTERISATION = ("vertex", "tess_control", "tess_evaluation", "geometry")


@dataclass(frozen=True)
class CapturedFragments(Need):
    """What the fragment shader of a draw got, at each pixel; of a dispatch, what its invocations
    got."""

    key: PassDraw

    def answer(self, context: Context) -> Fragments:
        with doing("draw", f"capturing the inputs of {context.draw_in_words(self.key)}"):
            return context.session.capture_fragments(self.key)

    def misplaced(self, found: Fragments, programs: Programs) -> str:
        """As `Fragments.misplaced`; "" where the shader may count from elsewhere."""
        draw = programs[self.key[0]][self.key[1]]
        if draw.draw.compute or changes_inputs(draw.text("fragment") or ""):
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
            text, other_text = own.text("fragment") or "", other.text("fragment") or ""
            if text != other_text and may_keep_out(text + other_text):
                return False
        return True


@dataclass(frozen=True)
class CapturedVertices(Need):
    """What the last stage before rasterisation got and gave, at each vertex of a draw."""

    key: PassDraw

    def answer(self, context: Context) -> Samples:
        with doing("draw", f"capturing the inputs of {context.draw_in_words(self.key)}"):
            return context.session.capture_vertices(self.key)

    def has_same_answer(self, programs: Programs, others: Programs) -> bool:
        name, index = self.key
        return _same_stages(programs[name][index], others[name][index])


class Probe(Need):
    """A draw's program run on inputs that an expectation gives.

    Inputs of the stage are gathered into one draw; a uniform takes one draw for each value.

    Args:
        expectation: whose output is probed. Two probes of one expectation are the same one.
        steps: inputs and uniforms of each run, by name; all have the same names.
    """

    def __init__(self, expectation: OfOutput, steps: Sequence[Mapping[str, Any]] = ()) -> None:
        self._expectation = expectation
        self._steps = steps

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Probe) and other._expectation is self._expectation

    def __hash__(self) -> int:
        return id(self._expectation)

    def answer(self, context: Context) -> Samples:
        """Run the program. Raises CaseError for a name that is no input and no uniform."""
        with doing("draw", f"sampling for {self._expectation.name!r}"):
            return self._answer(context)

    def _answer(self, context: Context) -> Samples:
        expectation, session, steps = self._expectation, context.session, self._steps
        scene = session.scene
        key = expectation.key(scene)
        draw, bindings = session.programs[key[0]][key[1]], context.bindings[key]
        if draw.draw.compute:
            raise UnsupportedError(
                f"{draw.draw.compute}: running a compute stage on given inputs",
                remedy="judge what it leaves in its buffers: formula, exact, measure, or "
                "value(…, at=Pixel(element, 0))",
            )
        of_vertex = expectation.is_of_vertex(scene, session.programs)
        variables = draw.interface.attributes if of_vertex else draw.interface.varyings
        inputs = {variable.name: variable for variable in elements(variables.values())}
        for word in steps[0]:
            if word not in inputs and word not in bindings.uniforms:
                raise CaseError(
                    f"{expectation.output}: {word!r} is no input of "
                    f"{' + '.join(draw.draw.shaders)}",
                    remedy=nearest(word, [*inputs, *bindings.uniforms]),
                )
        uniforms = [name for name in steps[0] if name not in inputs]

        def bound(step: Mapping[str, Any]) -> Bindings:
            return _with_uniforms(bindings, draw, {n: step[n] for n in uniforms})

        def run(runs: Sequence[Bindings], given: Mapping[str, Array]) -> list[Samples]:
            if not of_vertex:
                return session.probe(key, "fragment", runs, given)
            found = session.probe(key, "vertex", runs, given)
            if expectation.own_name(scene) not in found[0].outputs:
                raise UnsupportedError(
                    f"running {draw.draw.geometry or draw.draw.tess_evaluation} on given inputs: "
                    "it takes whole primitives",
                    remedy="judge what it makes of the mesh (formula), with a mesh that has these "
                    "inputs",
                )
            return found

        def samples(some: Sequence[Mapping[str, Any]], given: Bindings, got: Samples) -> Samples:
            exact = {n: _repeated(given.uniforms[n], len(some)) for n in uniforms}
            decimal = {n: _repeated(given.decimal[n], len(some)) for n in uniforms}
            for n in (name for name in steps[0] if name not in uniforms):
                decimal[n] = np.array([np.atleast_1d(np.asarray(s[n], np.float64)) for s in some])
            return replace(got, inputs={**got.inputs, **exact}, decimal=decimal)

        if not uniforms:
            given = [exact_inputs(inputs, step) for step in steps]
            joined = {n: np.concatenate([g[n] for g in given]) for n in given[0]}
            changed = bound(steps[0])
            return samples(steps, changed, run([changed], joined)[0])
        changes = [bound(step) for step in steps]
        if len(uniforms) == len(steps[0]):
            found = run(changes, {})
        else:
            found = [
                run([change], exact_inputs(inputs, step))[0]
                for change, step in zip(changes, steps, strict=True)
            ]
        each = zip(steps, changes, found, strict=True)
        return _joined([samples([step], change, got) for step, change, got in each])


def _same_stages(one: PreparedDraw, other: PreparedDraw) -> bool:
    """Whether all stages before rasterisation are the same."""
    return all(one.text(stage) == other.text(stage) for stage in BEFORE_RASTERISATION)


def _with_uniforms(bindings: Bindings, draw: PreparedDraw, values: Mapping[str, Any]) -> Bindings:
    exact, decimal = dict(bindings.uniforms), dict(bindings.decimal)
    known = declared(draw.interface)
    for name, value in values.items():
        exact[name], decimal[name] = value_arrays(known[name], value)
    return replace(bindings, uniforms=exact, decimal=decimal)


def _repeated(value: Array, count: int) -> Array:
    return np.repeat(value[None], count, axis=0)


def _joined(parts: Sequence[Samples]) -> Samples:
    def join(group: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
        return {name: np.concatenate([part[name] for part in group]) for name in group[0]}

    return Samples(
        inputs=join([p.inputs for p in parts]),
        outputs=join([p.outputs for p in parts]),
        decimal=join([p.decimal for p in parts]),
        discarded=sum(p.discarded for p in parts),
    )
