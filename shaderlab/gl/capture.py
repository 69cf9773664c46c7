"""Writing down what shaders got: fragment inputs, vertices, and single invocations on demand.

A shader is judged by the very float32 values that it read, so that each stage is judged by itself
(no rounding of an earlier stage, of interpolation or of an upload can be taken for its mistake).
Vertices are captured in `shaderlab.gl.feedback`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from shaderlab.errors import CaseError, ShaderError, UnsupportedError, nearest
from shaderlab.frame import Array, Bindings, Fragments, PassDraw, Samples
from shaderlab.gl import bind, capture_cache, formats, stages
from shaderlab.gl import state as fixed
from shaderlab.gl.feedback import probe_vertices, vertices
from shaderlab.gl.prepare import PreparedDraw
from shaderlab.gl.programs import output_locations, set_uniforms
from shaderlab.gl.runner import Session, drain_errors, submit
from shaderlab.gl.target import RenderTarget
from shaderlab.gl.varyings import Piece, assembled, elements
from shaderlab.gl.vertices import PRIMITIVES, vertex_array
from shaderlab.glsl.spirv import Variable
from shaderlab.model import Draw, Mesh, State, Target

__all__ = ["exact_inputs", "fragments", "probe_fragments", "probe_vertices", "vertices"]

PROBE_WIDTH = 256
_MAX_ATTRIBUTES = 16


def fragments(session: Session, key: PassDraw) -> Fragments:
    """Draw a pass once more, with draw `key` writing its inputs beside its colours.

    The pass's other draws run as well and wipe out what they cover, so `covered` is what is seen
    of the draw in the end. Blending and colour masks are off.

    Where a scene before it must have had the same fragments, theirs are used (see
    `shaderlab.gl.capture_cache`); those arrays can't be written to.

    Raises:
        UnsupportedError: the fragment shader has so many outputs that none can be added, and they
            are declared in a way that leaves none out.
    """
    same = capture_cache.identity(session, key)
    return session.runner.captures.get(same, lambda: _captured(session, key))


def _captured(session: Session, key: PassDraw) -> Fragments:
    draw = session.prepared[key[0]][key[1]]
    parts = stages.input_pieces(draw.text("fragment") or "", draw.interface.varyings.values())
    crowded = stages.crowded(draw.interface.outputs)
    room = stages.MOST_OUTPUTS - 1 - (0 if crowded else len(draw.interface.outputs))
    values: dict[Piece, Array] = {}
    for start in range(0, max(len(parts), 1), room):
        coord, got = _capture_group(session, key, parts[start : start + room], crowded)
        values.update(got)
    return Fragments(covered=coord[..., 3] > 0.0, frag_coord=coord, inputs=assembled(values))


def _capture_group(
    session: Session, key: PassDraw, group: Sequence[Piece], crowded: bool
) -> tuple[Array, dict[Piece, Array]]:
    description = session.scene.find_pass(key[0])
    prepared = session.prepared[key[0]]
    subject = prepared[key[1]]
    outputs = subject.interface.outputs
    text, captured = stages.capture_fragment(
        subject.text("fragment") or "", group, outputs if crowded else None
    )
    colors = {n: formats.for_output(v.type) for n, v in outputs.items() if not crowded}
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
            c.piece: target.read(c.output).values[..., : formats.components_of(c.piece.type)]
            for c in captured
        }
    finally:
        target.release()
    return coord, got


def _blank(draw: PreparedDraw) -> str:
    """The draw's fragment shader, its coordinate written as zero: covered by somebody else."""
    crowded = len(draw.interface.outputs) + 1 > stages.MOST_OUTPUTS
    unwanted = draw.interface.outputs if crowded else None
    text, _ = stages.capture_fragment(draw.text("fragment") or "", (), unwanted)
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


def probe_fragments(
    session: Session, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
) -> Samples:
    """Run the fragment stage on given inputs, each an array (count, components).

    Each sample is a point of one pixel, so that nothing is interpolated; tests and blending are
    off. Inputs that are not given take the value a domain has at the centre of the screen.

    Raises:
        CaseError: an input has no value, or is none of the shader's.
        UnsupportedError: the lab can't write a vertex stage that feeds the shader.
    """
    draw = session.prepared[key[0]][key[1]]
    runner = session.runner
    variables = {v.name: v for v in elements(draw.interface.varyings.values())}
    count = max((len(v) for v in inputs.values()), default=1)
    complete = _complete(draw.draw, variables, inputs, count)
    width = min(count, PROBE_WIDTH)
    size = (width, -(-count // width))
    program, columns = _fed(session, draw)
    colors = {n: formats.for_output(v.type) for n, v in draw.interface.outputs.items()}
    target = RenderTarget(runner.device, Target(), colors, size)
    try:
        target.clear()
        fixed.apply(State(), size)
        session.use(program, replace(draw, draw=_without_domain(draw.draw)), bindings)
        set_uniforms(program, {stages.PREFIX + "size": np.array(size, np.int32)})
        attributes = {name: _column(complete, piece) for piece, name in columns.items()}
        attributes = attributes or {stages.PREFIX + "nothing": np.zeros((count, 1), np.float32)}
        mesh = Mesh(attributes=attributes, primitive="points")
        vao = vertex_array(runner.device, program, mesh)
        target.bind(output_locations(program, target.colors))
        vao.render(PRIMITIVES["points"])
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


def _fed(session: Session, draw: PreparedDraw) -> tuple[Any, dict[Piece, str]]:
    """The draw's fragment shader behind a vertex stage that feeds it from attributes."""
    text = draw.text("fragment") or ""
    vertex, columns = stages.probe_vertex(text, draw.interface.varyings.values())
    remedy = "judge it over the frame (formula, or value at a Pixel)"
    if len(columns) > _MAX_ATTRIBUTES:
        raise UnsupportedError(
            f"running {draw.draw.fragment} on given inputs: it reads {len(columns)} vectors, "
            f"{_MAX_ATTRIBUTES} can be given",
            remedy=remedy,
        )
    try:
        return session.runner.programs.link({"vertex": vertex, "fragment": text}), columns
    except ShaderError as error:
        raise UnsupportedError(
            f"running {draw.draw.fragment} on given inputs: no vertex stage can be written that "
            f"declares them as it does ({error.message})",
            remedy=remedy,
        ) from error


def _column(values: Mapping[str, Array], piece: Piece) -> Array:
    """The part of the inputs that goes into one attribute."""
    whole = values[piece.name]
    return np.ascontiguousarray(whole[..., int(piece.path[1:-1])]) if piece.path else whole


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
        shaped = np.broadcast_to(value, (count, *bind.shape_of(variable.type)))
        complete[name] = np.ascontiguousarray(shaped.astype(formats.numpy_type(variable.type)))
    return complete


def _without_domain(draw: Draw) -> Draw:
    """The draw with no ramps to upload: its vertex stage is the probe's."""
    return replace(draw, domain={}) if draw.domain is not None else draw


def exact_inputs(variables: Mapping[str, Variable], values: Mapping[str, Any]) -> dict[str, Array]:
    """Given input values as arrays (1, components), matrices (1, rows, columns), of the type that
    the shader gets."""
    known = {v.name: v for v in elements(variables.values())}
    return {
        name: bind.uniform_arrays(known[name], value)[0][None]
        for name, value in values.items()
        if name in known
    }
