"""Writing down what fragment shaders got, and running them on given inputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from shaderlab.backends.vulkan.drawing import Drawing
from shaderlab.backends.vulkan.target import RenderTarget
from shaderlab.errors import ShaderError
from shaderlab.frame import Array, Bindings, Fragments, PassDraw, Samples
from shaderlab.programs import fragment_capture
from shaderlab.programs.fragment_probe import fragment_probe, refused


def fragments(drawing: Drawing, key: PassDraw) -> Fragments:
    """As `Session.fragments`."""
    return fragment_capture.fragments(
        drawing.programs[key[0]][key[1]],
        lambda text, colors: _redrawn(drawing, key, text, colors),
    )


def written(
    drawing: Drawing, key: PassDraw, text: str, outputs: Mapping[str, str]
) -> Mapping[str, Array]:
    """As `Session.written`."""
    return fragment_capture.written(
        text, outputs, lambda text, colors: _redrawn(drawing, key, text, colors)
    )


def probe_fragments(
    drawing: Drawing, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
) -> Samples:
    """As `Session.probe_fragments`."""
    draw = drawing.programs[key[0]][key[1]]
    probe = fragment_probe(draw, inputs)
    with RenderTarget(drawing.device, probe.target, probe.colors, probe.size) as target:
        given = probe.bindings(bindings)
        try:
            drawing.render(probe.draw, given, target, texts=probe.texts)
        except ShaderError as error:
            raise refused(draw, error.message) from error
        images = {name: target.read(name).values for name in probe.colors}
        return probe.samples(images, target.read("stencil").values if probe.discards else None)


def _redrawn(
    drawing: Drawing, key: PassDraw, text: str, colors: Mapping[str, str]
) -> Mapping[str, Array]:
    """The attachments of a pass whose draw `key` has another fragment text; other draws only say
    that they are seen, blending and masks are off."""
    description = drawing.scene.find_pass(key[0])
    plain = replace(description.target, colors=colors, clear=(0.0,) * 4, samples=0)
    with RenderTarget(drawing.device, plain, colors, drawing.extent(description)) as target:
        for index, draw in enumerate(drawing.programs[key[0]]):
            own = text if index == key[1] else fragment_capture.blank(draw)
            drawing.render(
                draw, drawing.bindings[key[0], index], target,
                texts={**draw.texts, "fragment": own},
                fixed_state=replace(
                    draw.draw.state, blend=None, srgb=False, color_mask=(True,) * 4
                ),
            )  # fmt: skip
        return {name: target.read(name).values for name in colors}
