"""Fragment shaders over a grid: words in by a texture array, words out by attachments."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shaderlab.compiler.interface import Variable
from shaderlab.compiler.sources import Source
from shaderlab.model.frame import Array
from shaderlab.model.scene import Target
from shaderlab.model.state import State

from .. import Evaluation
from ..attachments import COVERING
from .api import Structs
from .bound_textures import BoundTextures
from .commands import recording
from .descriptors import BoundImage, block_buffers, new_set, sampler_place
from .images import fill, new_image, new_view
from .linking import Linker
from .memory import Resources
from .modules import for_vulkan
from .program import Layout
from .ready import Ready
from .target import RenderTarget
from .vertices import VertexBuffers, VertexLayout

_INPUT, _SHARED = "shaderlab_input", "shaderlab_shared"


def evaluate(linker: Linker, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
    """See `shaderlab.drivers.Backend.evaluate`."""
    with Resources(linker.device) as own:
        images = _textures(linker, own, evaluation)
        if len(inputs):
            images[_INPUT] = _input(own, evaluation, inputs)
        first = 0
        for source, words in evaluation.passes:
            outputs[first : first + words] = _drawn(linker, evaluation, source, images)
            first += words


def _drawn(
    linker: Linker, evaluation: Evaluation, source: Source, images: dict[str, BoundImage]
) -> Array:
    """What one pass writes: (words, height, width, lanes)."""
    texts = {"vertex": COVERING, "fragment": for_vulkan(source.text)}
    program = linker.link(texts, [source])
    word = "r32ui" if evaluation.lanes == 1 else "rgba32ui"
    colors = dict.fromkeys(program.outputs, word)
    with (
        Resources(linker.device) as own,
        RenderTarget(linker.device, Target(), colors, evaluation.size) as to,
    ):
        used = {n: i for n, i in images.items() if sampler_place(n, program.bindings)}
        values = dict(evaluation.uniforms)
        members = [b.block.members for b in program.bindings.values() if b.block is not None]
        count = next((m[_SHARED].array for m in members if _SHARED in m), None)
        if count is not None:
            values[_SHARED] = evaluation.shared[:count]
        buffers = block_buffers(own, program.bindings, values)
        bound = new_set(own, program.set_layout, program.bindings, buffers, used)
        locations = program.locations(colors)
        formats = tuple((at, word) for at in locations)
        layout = Layout(VertexLayout(), formats, "", 1, State())
        ready = Ready(program, layout, locations, State(), VertexBuffers((), None, 3), 1, bound)
        with recording(linker.device) as commands:
            to.begin(commands, locations)
            ready.record(commands, evaluation.size)
            to.end(commands)
        return np.stack([to.read(locations[at]).values for at in sorted(locations)])


def _input(own: Resources, evaluation: Evaluation, inputs: Array) -> BoundImage:
    word = "r32ui" if evaluation.lanes == 1 else "rgba32ui"
    image = new_image(
        own, word, evaluation.size, "sampled", "transfer_dst", kind="2DArray", layers=len(inputs)
    )
    fill(own.device, image, [inputs])
    sampler = own.create("Sampler", Structs()("SamplerCreateInfo"))
    return BoundImage(new_view(own, image, sampled=True), sampler)


def _textures(linker: Linker, own: Resources, evaluation: Evaluation) -> dict[str, BoundImage]:
    textures = BoundTextures(Path(evaluation.folder), {}, {}, own, linker)
    found = {}
    for name, (kind, source) in evaluation.textures.items():
        variable = Variable(name=name, type=kind)
        textures.texels("the function", variable, source)  # raises where they don't fit
        found[name] = textures.bound(variable, source)
    return found
