"""Writing down what shaders got: fragment inputs, vertices, and single invocations on demand.

A shader is judged by the very float32 values that it read, so that each stage is judged by itself
(no rounding of an earlier stage, of interpolation or of an upload can be taken for its mistake).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from shaderlab.errors import CaseError, UnsupportedError, nearest
from shaderlab.frame import Array, Bindings, Fragments, PassDraw, Samples
from shaderlab.gl import bind, formats, stages
from shaderlab.gl import state as fixed
from shaderlab.gl.prepare import PreparedDraw
from shaderlab.gl.programs import PRIMITIVES, output_locations, set_uniforms, vertex_array
from shaderlab.gl.runner import Session, drain_errors, submit
from shaderlab.gl.target import RenderTarget
from shaderlab.glsl.spirv import Variable
from shaderlab.model import Draw, Mesh, State, Target

PROBE_WIDTH = 256
_MAX_OUTPUTS = 8


def fragments(session: Session, key: PassDraw) -> Fragments:
    """Draw a pass once more, with draw `key` writing its inputs beside its colours.

    The pass's other draws run as well and wipe out what they cover, so `covered` is what is seen
    of the draw in the end. Blending and colour masks are off.

    Raises:
        UnsupportedError: the fragment shader has more outputs than leave room for its inputs.
    """
    interface = session.prepared[key[0]][key[1]].interface
    inputs = list(interface.varyings.values())
    room = _MAX_OUTPUTS - len(interface.outputs) - 1
    if room < 1:
        raise UnsupportedError(
            f"{len(interface.outputs)} outputs leave no room to capture inputs beside them"
        )
    values: dict[str, Array] = {}
    for start in range(0, max(len(inputs), 1), room):
        coord, got = _capture_group(session, key, inputs[start : start + room])
        values.update(got)
    return Fragments(covered=coord[..., 3] > 0.0, frag_coord=coord, inputs=values)


def _capture_group(
    session: Session, key: PassDraw, group: Sequence[Variable]
) -> tuple[Array, dict[str, Array]]:
    description = session.scene.find_pass(key[0])
    prepared = session.prepared[key[0]]
    subject = prepared[key[1]]
    text, captured = stages.capture_fragment(subject.text("fragment") or "", group)
    colors = {n: formats.for_output(v.type) for n, v in subject.interface.outputs.items()}
    colors[stages.COORD] = "rgba32f"
    colors.update({c.output: c.format for c in captured})
    plain = replace(description.target, colors=colors, clear=(0.0,) * 4, samples=0)
    target = RenderTarget(session.runner.device, plain, colors, session.extent(description))
    try:
        target.clear()
        for index, draw in enumerate(prepared):
            ending = text if index == key[1] else _blank(draw)
            state = replace(draw.draw.state, blend=None, srgb=False, color_mask=(True,) * 4)
            bindings = session.bindings[key[0], index]
            _draw_instead(session, draw, ending, bindings, target, state)
        coord = target.read(stages.COORD).values
        got = {
            c.variable.name: target.read(c.output).values[..., : c.variable.components]
            for c in captured
        }
    finally:
        target.release()
    return coord, got


def _blank(draw: PreparedDraw) -> str:
    """The draw's fragment shader, its coordinate written as zero: covered by somebody else."""
    text, _ = stages.capture_fragment(draw.text("fragment") or "", ())
    return text.replace(f"{stages.COORD} = gl_FragCoord;", f"{stages.COORD} = vec4(0.0);")


def _draw_instead(
    session: Session,
    draw: PreparedDraw,
    fragment: str,
    bindings: Bindings,
    target: RenderTarget,
    state: State,
) -> None:
    runner = session.runner
    texts = {s.stage: s.text for s in draw.sources} | {"fragment": fragment}
    program = runner.programs.link(texts)
    session.use(program, draw, bindings)
    vao = vertex_array(runner.device, program, draw.draw.mesh)
    target.bind(output_locations(program, target.colors))
    fixed.apply(state, target.size)
    submit(vao, program, draw)
    drain_errors()


def vertices(
    session: Session, key: PassDraw, bindings: Bindings | None = None, mesh: Mesh | None = None
) -> Samples:
    """Run the vertex stage over a mesh (the draw's own by default), once a stored vertex.

    Outputs are gl_Position and every `out` variable; inputs are the attributes.

    Raises:
        UnsupportedError: an output is a matrix or an array.
    """
    draw = session.prepared[key[0]][key[1]]
    runner = session.runner
    mesh = mesh or draw.draw.mesh
    assert mesh is not None
    outputs = {"gl_Position": "vec4"}
    for name, variable in draw.interface.vertex_outputs.items():
        if variable.array is not None or variable.type.startswith("mat"):
            raise UnsupportedError(f"capturing {name!r}: {variable.type} outputs of vertex shaders")
        outputs[name] = variable.type
    text = {"vertex": draw.text("vertex") or ""}
    program = runner.programs.link(text, feedback=tuple(outputs))
    sizes = [formats.components_of(kind) for kind in outputs.values()]
    # Transform feedback without a complete framebuffer returns zeros without an error.
    target = RenderTarget(runner.device, Target(), {"unused": "r8"}, (1, 1))
    try:
        target.clear()
        fixed.apply(State(), (1, 1))
        session.use(program, draw, bindings or session.bindings[key])
        vao = vertex_array(runner.device, program, replace(mesh, indices=None, primitive="points"))
        buffer = runner.device.context.buffer(reserve=4 * sum(sizes) * mesh.vertices)
        vao.transform(buffer, mode=PRIMITIVES["points"], vertices=mesh.vertices)
        drain_errors()
        raw = np.frombuffer(buffer.read(), np.float32).reshape(mesh.vertices, sum(sizes))
    finally:
        target.release()
    columns = np.split(raw, np.cumsum(sizes)[:-1], axis=1)
    got = {
        name: np.ascontiguousarray(part).view(formats.numpy_type(kind))
        for (name, kind), part in zip(outputs.items(), columns, strict=True)
    }
    return Samples(inputs=dict(mesh.attributes), outputs=got)


def probe_vertices(
    session: Session, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
) -> Samples:
    """Run the vertex stage on given attributes (count, components); the others keep the values
    of the mesh's first vertex."""
    mesh = session.prepared[key[0]][key[1]].draw.mesh
    assert mesh is not None
    count = len(next(iter(inputs.values())))
    attributes = {
        name: inputs[name] if name in inputs else np.repeat(values[:1], count, axis=0)
        for name, values in mesh.attributes.items()
    }
    return vertices(session, key, bindings, Mesh(attributes=attributes))


def probe_fragments(
    session: Session, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
) -> Samples:
    """Run the fragment stage on given inputs, each an array (count, components).

    Each sample is a point of one pixel, so that nothing is interpolated; tests and blending are
    off. Inputs that are not given take the value a domain has at the centre of the screen.

    Raises:
        CaseError: an input has no value, or is none of the shader's.
    """
    draw = session.prepared[key[0]][key[1]]
    runner = session.runner
    variables = draw.interface.varyings
    count = max((len(v) for v in inputs.values()), default=1)
    complete = _complete(draw.draw, variables, inputs, count)
    width = min(count, PROBE_WIDTH)
    size = (width, -(-count // width))
    version = stages.version_line(draw.text("fragment") or "")
    vertex = stages.probe_vertex(version, variables.values())
    colors = {n: formats.for_output(v.type) for n, v in draw.interface.outputs.items()}
    texts = {"vertex": vertex, "fragment": draw.text("fragment") or ""}
    program = runner.programs.link(texts)
    target = RenderTarget(runner.device, Target(), colors, size)
    try:
        target.clear()
        fixed.apply(State(), size)
        session.use(program, replace(draw, draw=_without_domain(draw.draw)), bindings)
        set_uniforms(program, {stages.PREFIX + "size": np.array(size, np.int32)})
        attributes = {f"{stages.PREFIX}in_{name}": v for name, v in complete.items()}
        attributes = attributes or {"unused": np.zeros((count, 1), np.float32)}
        mesh = Mesh(attributes=attributes, primitive="points")
        vao = vertex_array(runner.device, program, mesh)
        target.bind(output_locations(program, target.colors))
        vao.render(PRIMITIVES["points"], vertices=count)
        drain_errors()
        outputs = {
            name: target.read(name).values.reshape(-1, formats.COLOR[word].components)
            for name, word in colors.items()
        }
    finally:
        target.release()
    kinds = draw.interface.outputs
    outputs = {n: v[:count, : formats.components_of(kinds[n].type)] for n, v in outputs.items()}
    return Samples(inputs=complete, outputs=outputs)


def _complete(
    draw: Draw, variables: Mapping[str, Variable], inputs: Mapping[str, Array], count: int
) -> dict[str, Array]:
    for name in inputs:
        if name not in variables:
            raise CaseError(f"{draw.fragment} reads no {name!r}", remedy=nearest(name, variables))
    complete = {}
    for name, variable in variables.items():
        if name in inputs:
            value: Any = inputs[name]
        elif draw.domain is not None:
            ramp = draw.domain[name]
            parts = (np.asarray(v, np.float64) for v in (ramp.origin, ramp.dx, ramp.dy))
            origin, dx, dy = parts
            value = np.atleast_1d(origin + 0.5 * dx + 0.5 * dy)[None]
        else:
            raise CaseError(
                f"{draw.fragment} also reads {name!r} ({variable.type})",
                remedy=f"give it a value: at={{…, {name!r}: …}}",
            )
        shaped = np.broadcast_to(value, (count, variable.components))
        complete[name] = np.ascontiguousarray(shaped.astype(formats.numpy_type(variable.type)))
    return complete


def _without_domain(draw: Draw) -> Draw:
    """The draw with no ramps to upload: its vertex stage is the probe's."""
    return replace(draw, domain={}) if draw.domain is not None else draw


def exact_inputs(variables: Mapping[str, Variable], values: Mapping[str, Any]) -> dict[str, Array]:
    """Given input values as (1, components) arrays of the type that the shader gets."""
    return {
        name: bind.uniform_arrays(variables[name], value)[0].reshape(1, -1)
        for name, value in values.items()
        if name in variables
    }
