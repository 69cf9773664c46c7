"""Writing down what shaders got: fragment inputs, vertices, and single invocations on demand.

A shader is judged by the very float32 values that it read, so that each stage is judged by itself
(no rounding of an earlier stage, of interpolation or of an upload can be taken for its mistake).
Vertices are captured in `feedback`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from shaderlab.backends.opengl import state as fixed
from shaderlab.backends.opengl.drawing import Drawing, drain_errors, submit
from shaderlab.backends.opengl.linking import output_locations
from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.backends.opengl.target import RenderTarget
from shaderlab.backends.opengl.vertices import vertex_array
from shaderlab.errors import ShaderError
from shaderlab.frame import Array, Bindings, Fragments, PassDraw, Samples
from shaderlab.programs import fragment_capture
from shaderlab.programs.fragment_probe import fragment_probe, refused


def fragments(drawing: Drawing, key: PassDraw) -> Fragments:
    """As `Session.fragments`: see `shaderlab.programs.fragment_capture`."""
    return fragment_capture.fragments(
        drawing.programs[key[0]][key[1]],
        lambda text, colors: _redrawn(drawing, key, text, colors),
    )


def written(
    drawing: Drawing, key: PassDraw, text: str, outputs: Mapping[str, str]
) -> Mapping[str, Array]:
    """Draw a pass once more, with draw `key` having another fragment text; see `Session.written`.

    Raises:
        ShaderError: the driver refuses the text.
    """
    return fragment_capture.written(
        text, outputs, lambda text, colors: _redrawn(drawing, key, text, colors)
    )


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
                fragment=text if index == key[1] else fragment_capture.blank(draw),
                fixed=replace(draw.draw.state, blend=None, srgb=False, color_mask=(True,) * 4),
            )  # fmt: skip
            submit(vao, program, draw)
            drain_errors()
        return {name: target.read(name).values for name in colors}


def probe_fragments(
    drawing: Drawing, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
) -> Samples:
    """Run the fragment stage on given inputs, each an array (count, components); tests and
    blending are off.

    Raises:
        CaseError: an input has no value, or is none of the shader's.
        UnsupportedError: the lab can't write a vertex stage that feeds the shader.
    """
    draw = drawing.programs[key[0]][key[1]]
    probe = fragment_probe(draw, inputs)
    try:
        program = drawing.linker.link(probe.texts)
    except ShaderError as error:
        raise refused(draw, error.message) from error
    with RenderTarget(drawing.device, probe.target, probe.colors, probe.size) as target:
        fixed.apply(probe.draw.draw.state, probe.size, drawing.device.version)
        given = probe.bindings(bindings)
        drawing.use(program, probe.draw, given)
        vao = vertex_array(drawing.device, program, probe.draw.draw.mesh)
        target.bind(output_locations(program, target.colors))
        vao.render(GL.GL_POINTS)
        drain_errors()
        images = {name: target.read(name).values for name in probe.colors}
        return probe.samples(images, target.read("stencil").values if probe.discards else None)
