"""Writing down what shaders got: fragment inputs, vertices, and single invocations on demand.

A shader is judged by the very float32 values that it read, so that each stage is judged by itself
(no rounding of an earlier stage, of interpolation or of an upload can be taken for its mistake).
Vertices are captured in `feedback`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from shaderlab.backends.opengl import state as fixed
from shaderlab.backends.opengl.drawing import Drawing, drain_errors, submit
from shaderlab.backends.opengl.linking import output_locations, set_uniforms
from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.backends.opengl.target import RenderTarget
from shaderlab.backends.opengl.vertices import vertex_array
from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.frame import Array, Bindings, Fragments, PassDraw, Samples
from shaderlab.model import Mesh, State, Stencil, Target
from shaderlab.programs import bind, formats, stages, vertex_stages
from shaderlab.programs.prepare import PreparedDraw
from shaderlab.programs.varyings import Piece, assembled

PROBE_WIDTH = 256
_MAX_ATTRIBUTES = 16


def fragments(drawing: Drawing, key: PassDraw) -> Fragments:
    """Draw a pass once more, with draw `key` writing its inputs beside its colours.

    The pass's other draws run as well and wipe out what they cover, so `covered` is what is seen
    of the draw in the end. Blending and colour masks are off. A shader that may keep fragments out
    is captured a second time keeping them all.

    Raises:
        UnsupportedError: the fragment shader has so many outputs that none can be added, and they
            are declared in a way that leaves none out.
    """
    text = drawing.programs[key[0]][key[1]].text("fragment") or ""
    found = _captured(drawing, key, keep_all=False)
    if not (stages.may_discard(text) or stages.writes_depth(text)):
        return found
    return replace(found, undiscarded=_captured(drawing, key, keep_all=True))


def _captured(drawing: Drawing, key: PassDraw, *, keep_all: bool) -> Fragments:
    draw = drawing.programs[key[0]][key[1]]
    parts = stages.input_pieces(draw.text("fragment") or "", draw.interface.varyings.values())
    crowded = stages.crowded(draw.interface.outputs)
    room = stages.MOST_OUTPUTS - 1 - (0 if crowded else len(draw.interface.outputs))
    values: dict[Piece, Array] = {}
    for start in range(0, max(len(parts), 1), room):
        group = parts[start : start + room]
        coord, got = _capture_group(drawing, key, group, crowded, keep_all)
        values.update(got)
    return Fragments(covered=coord[..., 3] > 0.0, frag_coord=coord, inputs=assembled(values))


def _capture_group(
    drawing: Drawing, key: PassDraw, group: Sequence[Piece], crowded: bool, keep_all: bool
) -> tuple[Array, dict[Piece, Array]]:
    """`gl_FragCoord` and some of the inputs."""
    subject = drawing.programs[key[0]][key[1]]
    outputs = subject.interface.outputs
    text, captured = stages.capture_fragment(
        subject.text("fragment") or "", group, outputs if crowded else None, keep_all=keep_all
    )
    colors = {n: formats.for_output(v.type) for n, v in outputs.items() if not crowded}
    colors[stages.COORD] = "rgba32f"
    for piece, name in captured.items():
        colors[name] = formats.for_output(stages.padded_type(piece))
    images = _redrawn(drawing, key, text, colors)
    coord = images[stages.COORD]
    got = {
        piece: images[name][..., : formats.components_of(piece.type)]
        for piece, name in captured.items()
    }
    return coord, got


def written(
    drawing: Drawing, key: PassDraw, text: str, outputs: Mapping[str, str]
) -> Mapping[str, Array]:
    """Draw a pass once more, with draw `key` having another fragment text; see `Session.written`.

    Raises:
        ShaderError: the driver refuses the text.
    """
    ending, _ = stages.capture_fragment(text, ())
    images = _redrawn(drawing, key, ending, {**outputs, stages.COORD: "rgba32f"})
    seen = images[stages.COORD][..., 3:] > 0.0
    return {name: np.where(seen, images[name], 0) for name in outputs}


def _redrawn(
    drawing: Drawing, key: PassDraw, text: str, colors: Mapping[str, str]
) -> Mapping[str, Array]:
    """The attachments of a pass whose draw `key` has another fragment text; other draws only say
    that they are seen, blending and masks are off."""
    plain = replace(
        drawing.scene.find_pass(key[0]).target, colors=colors, clear=(0.0,) * 4, samples=0
    )
    size = drawing.extent(drawing.scene.find_pass(key[0]))
    with RenderTarget(drawing.device, plain, colors, size) as target:
        for index, draw in enumerate(drawing.programs[key[0]]):
            program, vao = drawing.ready(
                draw, drawing.bindings[key[0], index], target,
                fragment=text if index == key[1] else _blank(draw),
                fixed=replace(draw.draw.state, blend=None, srgb=False, color_mask=(True,) * 4),
            )  # fmt: skip
            submit(vao, program, draw)
            drain_errors()
        return {name: target.read(name).values for name in colors}


def _blank(draw: PreparedDraw) -> str:
    """The draw's fragment shader, 1/w written as −1: another draw is seen."""
    crowded = len(draw.interface.outputs) + 1 > stages.MOST_OUTPUTS
    unwanted = draw.interface.outputs if crowded else None
    text, _ = stages.capture_fragment(draw.text("fragment") or "", (), unwanted)
    return text.replace(
        f"{stages.COORD} = gl_FragCoord;", f"{stages.COORD} = vec4(0.0, 0.0, 0.0, -1.0);"
    )


def probe_fragments(
    drawing: Drawing, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
) -> Samples:
    """Run the fragment stage on given inputs, each an array (count, components).

    Each sample is a point of one pixel, so that nothing is interpolated; tests and blending are
    off. Inputs that are not given take the value a domain has at the centre of the screen.

    Raises:
        CaseError: an input has no value, or is none of the shader's.
        UnsupportedError: the lab can't write a vertex stage that feeds the shader.
    """
    draw = drawing.programs[key[0]][key[1]]
    complete = bind.complete_inputs(draw.draw, draw.interface.varyings, inputs)
    count = max((len(v) for v in inputs.values()), default=1)
    width = min(count, PROBE_WIDTH)
    size = (width, -(-count // width))
    program, columns = _fed(drawing, draw)
    colors = {n: formats.for_output(v.type) for n, v in draw.interface.outputs.items()}
    attributes = {name: bind.piece_of(complete, piece) for piece, name in columns.items()}
    attributes = attributes or {stages.PREFIX + "nothing": np.zeros((count, 1), np.float32)}
    # There are no ramps to upload: the vertex stage is the probe's.
    own = draw if draw.draw.domain is None else replace(draw, draw=replace(draw.draw, domain={}))
    # What is kept counts one up in the stencil buffer; a discarded point leaves its clear value.
    discards = stages.may_discard(draw.text("fragment") or "")
    plain = Target(depth="depth24_stencil8") if discards else Target()
    counting = State(stencil=Stencil(depth_pass="incr")) if discards else State()
    with RenderTarget(drawing.device, plain, colors, size) as target:
        fixed.apply(counting, size)
        drawing.use(program, own, bindings)
        set_uniforms(program, {stages.PREFIX + "size": np.array(size, np.int32)})
        mesh = Mesh(attributes=attributes, primitive="points")
        vao = vertex_array(drawing.device, program, mesh)
        target.bind(output_locations(program, target.colors))
        vao.render(GL.GL_POINTS)
        drain_errors()
        outputs = {
            name: target.read(name).values.reshape(-1, formats.COLOR[word].components)
            for name, word in colors.items()
        }
        kept = target.read("stencil").values.reshape(-1)[:count] if discards else np.ones(count)
    kinds = draw.interface.outputs
    outputs = {n: v[:count, : formats.components_of(kinds[n].type)] for n, v in outputs.items()}
    return Samples(inputs=complete, outputs=outputs, discarded=int((kept == 0).sum()))


def _fed(drawing: Drawing, draw: PreparedDraw) -> tuple[Any, dict[Piece, str]]:
    """The draw's fragment shader behind a vertex stage that feeds it from attributes."""
    text = draw.text("fragment") or ""
    vertex, columns = vertex_stages.probe_vertex(text, draw.interface.varyings.values())
    remedy = "judge it over the frame (formula, or value at a Pixel)"
    if len(columns) > _MAX_ATTRIBUTES:
        raise UnsupportedError(
            f"running {draw.draw.fragment} on given inputs: it reads {len(columns)} vectors, "
            f"{_MAX_ATTRIBUTES} can be given",
            remedy=remedy,
        )
    try:
        return drawing.linker.link({"vertex": vertex, "fragment": text}), columns
    except ShaderError as error:
        raise UnsupportedError(
            f"running {draw.draw.fragment} on given inputs: no vertex stage can be written that "
            f"declares them as it does ({error.message})",
            remedy=remedy,
        ) from error
