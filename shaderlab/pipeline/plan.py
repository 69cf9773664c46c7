"""What a scene's expectations need beyond its pictures: which captures and probes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from shaderlab.backends import Session
from shaderlab.checks import draw_key, split_output
from shaderlab.errors import CaseError, nearest
from shaderlab.frame import Array, Bindings, PassDraw, Samples
from shaderlab.model import (
    AttributeLayout,
    BlockLayout,
    Cost,
    Coverage,
    Formula,
    GlCall,
    InactiveUniforms,
    Pixel,
    Property,
    Query,
    Scene,
    Sweep,
    Value,
)
from shaderlab.programs import bind
from shaderlab.programs.inputs import exact_inputs
from shaderlab.programs.prepare import PreparedDraw, Programs
from shaderlab.programs.varyings import elements
from shaderlab.programs.vertices import vertex_outputs


@dataclass(frozen=True)
class Plan:
    """Draws to capture, expectations to probe, and what to ask the driver: draws whose memory is
    read or whose uniforms are looked for, (pass, draw, counter) to count, passes to time with the
    number of times, and expectations that call the API."""

    fragments: frozenset[PassDraw]
    vertices: frozenset[PassDraw]
    probes: tuple[int, ...]
    attributes: frozenset[PassDraw] = frozenset()
    blocks: frozenset[PassDraw] = frozenset()
    queries: frozenset[tuple[str, int, str]] = frozenset()
    timings: Mapping[str, int] = field(default_factory=dict)
    located: frozenset[PassDraw] = frozenset()
    calls: tuple[int, ...] = ()


def plan(scene: Scene, prepared: Programs) -> Plan:
    """Read the scene's expectations.

    Raises:
        CaseError: one names a pass, a draw or an output that does not exist.
    """
    fragments: set[PassDraw] = set()
    vertices: set[PassDraw] = set()
    probes: list[int] = []
    asked = _asked(scene)
    located: set[PassDraw] = set()
    for index, expectation in enumerate(scene.expect):
        if isinstance(expectation, Coverage):
            fragments.add(draw_key(scene, expectation.pass_name, expectation.draw))
        if isinstance(expectation, InactiveUniforms):
            located.add(draw_key(scene, expectation.pass_name, expectation.draw))
        if not isinstance(expectation, Formula | Sweep | Value):
            continue
        _, name = split_output(expectation.output, scene)
        key = key_of(scene, expectation)
        draw = prepared[key[0]][key[1]]
        at_pixels = isinstance(expectation, Formula) or (
            isinstance(expectation, Value) and isinstance(expectation.at, Pixel)
        )
        of_depth = at_pixels and name in _of_depth(scene, key, draw)
        of_vertex = not of_depth and _is_of_vertex(name, draw)
        if isinstance(expectation, Formula):
            (vertices if of_vertex else fragments).add(key)
        elif isinstance(expectation, Value) and isinstance(expectation.at, Pixel):
            fragments.add(key)
        else:
            probes.append(index)
    return replace(
        asked,
        fragments=frozenset(fragments),
        vertices=frozenset(vertices),
        probes=tuple(probes),
        located=frozenset(located),
        calls=tuple(i for i, e in enumerate(scene.expect) if isinstance(e, GlCall)),
    )


def _asked(scene: Scene) -> Plan:
    """What the expectations ask the driver itself."""
    attributes: set[PassDraw] = set()
    blocks: set[PassDraw] = set()
    queries: set[tuple[str, int, str]] = set()
    timings: dict[str, int] = {}
    for expectation in scene.expect:
        match expectation:
            case AttributeLayout():
                attributes.add(draw_key(scene, expectation.pass_name, expectation.draw))
            case BlockLayout():
                blocks.add(draw_key(scene, expectation.pass_name, expectation.draw))
            case Query():
                key = draw_key(scene, expectation.pass_name, expectation.draw)
                queries.add((*key, expectation.counter))
            case Cost():
                for name in expectation.passes:
                    known = scene.find_pass(name).name
                    timings[known] = max(timings.get(known, 0), expectation.repeats)
    return Plan(
        frozenset(),
        frozenset(),
        (),
        attributes=frozenset(attributes),
        blocks=frozenset(blocks),
        queries=frozenset(queries),
        timings=timings,
    )


def key_of(scene: Scene, expectation: Formula | Sweep | Value) -> PassDraw:
    """The pass and draw that an expectation's output comes from."""
    pass_name, _ = split_output(expectation.output, scene)
    return draw_key(scene, pass_name, expectation.draw)


def picture_of(scene: Scene, images: Collection[tuple[str, str]]) -> tuple[str, str]:
    """The (pass, output) that is the case's picture: the one it names, or the last pass's first.

    Raises:
        CaseError: the case names an output that is not there.
    """
    if not scene.case.picture:
        last = scene.passes[-1].name
        return next(key for key in images if key[0] == last)
    pass_name, name = split_output(scene.case.picture)
    key = (pass_name or scene.passes[-1].name, name)
    if key not in images:
        known = [".".join(k) for k in images]
        raise CaseError(
            f"there is no output {scene.case.picture!r} to be the picture",
            remedy=nearest(scene.case.picture, known),
        )
    return key


def probe(
    session: Session, bound: Mapping[PassDraw, Bindings], expectation: Value | Sweep
) -> Samples:
    """Run the draw's program on the inputs that a `value` or `sweep` gives.

    `bound` is what the draws were drawn with. Inputs of the stage are gathered into one draw; a
    uniform takes one draw for each value.

    Raises:
        CaseError: a name is neither an input of the stage nor a uniform.
    """
    key = key_of(session.scene, expectation)
    draw, bindings = session.programs[key[0]][key[1]], bound[key]
    of_vertex = _is_of_vertex(split_output(expectation.output, session.scene)[1], draw)
    declared = draw.interface.attributes if of_vertex else draw.interface.varyings
    inputs = {variable.name: variable for variable in elements(declared.values())}
    at = expectation.at
    assert not isinstance(at, Pixel)
    steps: list[dict[str, Any]] = [dict(at)]
    if isinstance(expectation, Property):
        steps = [{**at, **step} for step in expectation.steps]
    elif isinstance(expectation, Sweep):
        steps = [{**at, expectation.over: v} for v in expectation.values]
    for word in steps[0]:
        if word not in inputs and word not in bindings.uniforms:
            known = [*inputs, *bindings.uniforms]
            raise CaseError(
                f"{expectation.output}: {word!r} is no input of {' + '.join(draw.draw.shaders)}",
                remedy=nearest(word, known),
            )
    uniform_names = [n for n in steps[0] if n not in inputs]
    run = session.probe_vertices if of_vertex else session.probe_fragments

    def samples(some: list[dict[str, Any]]) -> Samples:
        changed = _with_uniforms(bindings, draw, {n: some[0][n] for n in uniform_names})
        got = [exact_inputs(inputs, step) for step in some]
        joined = {n: np.concatenate([g[n] for g in got]) for n in got[0]}
        result = run(key, changed, joined)
        exact = {n: _repeated(changed.uniforms[n], len(some)) for n in uniform_names}
        decimal = {n: _repeated(changed.decimal[n], len(some)) for n in uniform_names}
        for n in joined:
            decimal[n] = np.array([np.atleast_1d(np.asarray(s[n], np.float64)) for s in some])
        return replace(result, inputs={**result.inputs, **exact}, decimal=decimal)

    if not uniform_names:
        return samples(steps)
    return _joined([samples([step]) for step in steps])


def _is_of_vertex(name: str, draw: PreparedDraw) -> bool:
    outputs = draw.interface.outputs
    if name in outputs:
        return False
    of_vertex = [] if draw.draw.mesh is None and name != "gl_Position" else vertex_outputs(draw)
    if name in of_vertex:
        if draw.draw.mesh is None:
            raise CaseError(f"{name!r} is the lab's own vertex stage's: draw a mesh to judge it")
        return True
    raise CaseError(f"there is no output {name!r}", remedy=nearest(name, [*outputs, *of_vertex]))


def _of_depth(scene: Scene, key: PassDraw, draw: PreparedDraw) -> tuple[str, ...]:
    """The names that a pass's depth attachment goes by, unless its shader has such an output."""
    if scene.find_pass(key[0]).target.depth is None:
        return ()
    return tuple(name for name in ("depth", "stencil") if name not in draw.interface.outputs)


def _with_uniforms(bindings: Bindings, draw: PreparedDraw, values: Mapping[str, Any]) -> Bindings:
    exact, decimal = dict(bindings.uniforms), dict(bindings.decimal)
    known = bind.declared(draw.interface)
    for name, value in values.items():
        exact[name], decimal[name] = bind.uniform_arrays(known[name], value)
    return replace(bindings, uniforms=exact, decimal=decimal)


def _repeated(value: Array, count: int) -> Array:
    return np.repeat(value[None], count, axis=0)


def _joined(parts: list[Samples]) -> Samples:
    def join(pick: Any) -> dict[str, Array]:
        return {name: np.concatenate([pick(p)[name] for p in parts]) for name in pick(parts[0])}

    return Samples(
        inputs=join(lambda p: p.inputs),
        outputs=join(lambda p: p.outputs),
        decimal=join(lambda p: p.decimal),
    )
