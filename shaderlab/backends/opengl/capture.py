"""Writing down what shaders got: fragment inputs, vertices, and single invocations on demand.

A shader is judged by the very float32 values that it read, so that each stage is judged by itself
(no rounding of an earlier stage, of interpolation or of an upload can be taken for its mistake).
Vertices are captured in `feedback`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from shaderlab.backends.opengl import state as fixed
from shaderlab.backends.opengl.drawing import Drawing, drain_errors, submit
from shaderlab.backends.opengl.linking import output_locations
from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.backends.opengl.target import RenderTarget
from shaderlab.backends.opengl.vertices import vertex_array
from shaderlab.backends.passes import plain_state
from shaderlab.errors import ShaderError
from shaderlab.frame import Array, Bindings, PassDraw, Samples
from shaderlab.model import Pass, Target
from shaderlab.programs.fragment_capture import numbered
from shaderlab.programs.fragment_probe import fragment_probe, refused
from shaderlab.programs.stages import NUMBER


def redrawn(
    drawing: Drawing, description: Pass, target: Target, texts: Sequence[str]
) -> Mapping[str, Array]:
    """As `PassSession.redrawn`.

    Raises:
        ShaderError: the driver refuses a text.
    """
    name, colors = description.name, dict(target.colors or {})
    with RenderTarget(drawing.device, target, colors, drawing.extent(description)) as made:
        for index, (draw, text) in enumerate(zip(drawing.programs[name], texts, strict=True)):
            named = not drawing.device.takes_spirv
            program, vao = drawing.ready(
                draw, drawing.bindings[name, index], made,
                fragment=text if named else numbered(text, index), fixed=plain_state(draw),
                only_active=True,
            )  # fmt: skip
            if named and (number := program.get(NUMBER, None)) is not None:
                number.value = index + 1.0
            submit(vao, program, draw)
            drain_errors()
        return {name: made.read(name).values for name in colors}


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
