"""Drawing a scene's passes, and reading back what they drew."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from shaderlab.compiler.reflection import Variable
from shaderlab.compiler.sources import Source
from shaderlab.compiler.spirv import parse
from shaderlab.errors import UnsupportedError
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, Bindings
from shaderlab.model.scene import Target
from shaderlab.model.state import State

from .. import Evaluation, Size
from ..passes import PassSession
from ..programs import blocks, stages
from ..programs.module_texts import HEIGHT, as_drawn, sources_of
from ..programs.prepare import PreparedDraw, Programs
from ..programs.stages import Piece
from ..programs.vertex_capture import corners
from ..resources import COVERING
from . import state as fixed
from .api import Structs
from .bindings import BoundTextures, Ready
from .device import Buffer, Commands, Device, Resources, recording
from .images import fill, new_image, new_view
from .program import (
    BoundImage,
    Layout,
    Linker,
    Program,
    block_buffers,
    for_vulkan,
    modules_of,
    new_set,
    sampler_place,
)
from .target import RenderTarget
from .vertices import VertexBuffers, VertexLayout, layout_of, upload


class Drawing(PassSession[RenderTarget, Linker]):
    """One scene on the device: its targets and textures, kept until the session ends."""

    device: Device
    _textures: BoundTextures

    def __init__(
        self, linker: Linker, scene: Scene, programs: Programs, size: Size, stack: ExitStack
    ) -> None:
        super().__init__(linker, scene, programs, size, stack)
        self.subpixel_step = 2.0**-self.device.limits.subPixelPrecisionBits
        self._resources = stack.enter_context(Resources(self.device))
        self._textures = BoundTextures(
            self.folder, self.images, self.targets, self._resources, linker
        )
        self._shared = blocks.SharedLayouts()

    def new_target(self, target: Target, colors: Mapping[str, str], size: Size) -> RenderTarget:
        return RenderTarget(self.device, target, colors, size)

    def render(
        self,
        draw: PreparedDraw,
        bindings: Bindings,
        target: RenderTarget,
        *,
        texts: Mapping[str, str] | None = None,
        fixed_state: State | None = None,
        around: Callable[[Commands, Callable[[], None]], None] | None = None,
    ) -> None:
        """As `PassSession.render`; `around` records the draw by calling what it is given, with
        commands of its own before and after."""
        with Resources(self.device) as own:
            ready = self.ready(own, draw, bindings, target, texts=texts, fixed_state=fixed_state)
            with recording(self.device) as commands:

                def drawn() -> None:
                    target.begin(commands, ready.locations, srgb=ready.state.srgb)
                    ready.record(commands, target.size)
                    target.end(commands)

                if around is None:
                    drawn()
                else:
                    around(commands, drawn)

    def ready(
        self,
        own: Resources,
        draw: PreparedDraw,
        bindings: Bindings,
        target: RenderTarget,
        *,
        texts: Mapping[str, str] | None = None,
        fixed_state: State | None = None,
        stored: Mapping[str, Buffer] | None = None,
    ) -> Ready:
        """All that a draw takes, on the device; `own` are what is released after it.

        Args:
            texts, fixed_state: as in `render`.
            stored: storage buffers by the names of their blocks.
        """
        description, state = draw.draw, fixed_state or draw.draw.state
        if not description.vertex_array:
            raise UnsupportedError("vertex_array=False: Vulkan has no vertex arrays to leave out")
        program = self.program(draw, texts or draw.texts)
        locations = program.locations(target.colors)
        layout = Layout(
            layout_of(description.mesh, program.attributes),
            tuple(target.formats(locations, srgb=state.srgb).items()),
            target.depth, target.samples, fixed.in_pipeline(state),
        )  # fmt: skip
        values = {**bindings.uniforms, HEIGHT: np.array([target.size[1]], np.float32)}
        return Ready(
            program, layout, locations, state,
            upload(own, description.mesh, program.attributes), description.instances,
            self._descriptors(own, program, draw, values, stored or {}),
        )  # fmt: skip

    def program(self, draw: PreparedDraw, texts: Mapping[str, str]) -> Program:
        """The program of a draw, its stages having these texts."""
        own = dict(texts)
        if "fragment" in own:
            own["fragment"] = for_vulkan(own["fragment"])
        own = as_drawn(draw.draw, own)
        return self.linker.link(own, draw.sources)

    def _descriptors(
        self,
        own: Resources,
        program: Program,
        draw: PreparedDraw,
        values: dict[str, Array],
        stored: Mapping[str, Buffer],
    ) -> object:
        values |= draw.ramps
        for name, block in blocks.uniform_blocks(draw.interface).items():
            self._shared.check(draw.draw.blocks[name], block)
        buffers = block_buffers(own, program.bindings, values, stored)
        images: dict[str, BoundImage] = {}
        for name, source in draw.draw.textures.items():
            if sampler_place(name, program.bindings) is None:
                self._inactive.add(name)
                continue
            images[name] = self._textures.bound(draw.interface.uniforms[name], source)
        return new_set(own, program.set_layout, program.bindings, buffers, images)


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


_OUTPUT_VERTICES = 26  # SPIR-V's execution mode for max_vertices
_FEATURE = "vertexPipelineStoresAndAtomics"


def vertex_outputs(
    drawing: Drawing,
    draw: PreparedDraw,
    texts: Mapping[str, str],
    parts: Sequence[Piece],
    bindings: Bindings,
    count: int | None,
) -> Mapping[Piece, Array]:
    """As `PassSession.vertex_outputs`, by a storage buffer.

    Raises:
        UnsupportedError: the device's vertex stages can't write to buffers.
    """
    if _FEATURE not in drawing.device.features:
        raise UnsupportedError(f"capturing vertices: this device has no {_FEATURE}")
    mesh = draw.draw.mesh
    assert mesh is not None
    most, each = 1, mesh.vertices
    if "geometry" in texts:
        module = parse(modules_of(sources_of(draw.texts, draw.sources))["geometry"])
        most = module.modes[_OUTPUT_VERTICES][0]
        each = most * len(corners(mesh))
    program = stages.storing(texts, parts, most)
    words = stages.words_of(parts) * each * draw.draw.instances
    own = {stages.PER_INSTANCE: np.array([each], np.int32)}
    given = replace(bindings, uniforms={**bindings.uniforms, **own})
    with (
        Resources(drawing.device) as resources,
        RenderTarget(drawing.device, Target(), {}, (1, 1)) as target,
    ):
        buffer = resources.buffer("storage_buffer", size=4 * words)
        ready = drawing.ready(
            resources, draw, given, target, texts=program, stored={stages.BLOCK: buffer}
        )
        with recording(drawing.device) as commands:
            target.begin(commands, {})
            ready.record(commands, target.size)
            target.end(commands)
        return stages.restored(parts, buffer.bytes[: 4 * words].copy().view(np.uint32))
