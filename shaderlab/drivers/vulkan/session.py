"""Vulkan behind the protocol of `shaderlab.drivers`: the backend and its sessions."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from shaderlab.compiler.diagnostics import DRIVER
from shaderlab.compiler.reflection import Variable
from shaderlab.compiler.sources import Source
from shaderlab.compiler.spirv import ExecutionMode, parse
from shaderlab.errors import DriverError, ShaderError, UnsupportedError, Verdict
from shaderlab.model.frame import Array, AttributeReading, Bindings, BlockReading, PassDraw
from shaderlab.model.scene import Target

from .. import Answers, Evaluation
from ..passes import DeviceBackend, PassSession
from ..programs import bind, stages
from ..programs.captures import Captured, Parts, Texts, primitive_corners
from ..programs.module_texts import HEIGHT, make_sources, write_point_texts
from ..programs.prepare import PreparedDraw
from ..resources import COVERING
from .bindings import (
    BoundImage,
    BoundTextures,
    Ready,
    block_buffers,
    draw_covering,
    layout_of,
    new_set,
    upload,
)
from .device import Buffer, Device, Resources, Structs, check, constant, ffi, lib, recording
from .images import RenderTarget, new_image, new_view, write
from .program import (
    Layout,
    Linker,
    Program,
    adapt_fragment,
    check_capabilities,
    compile_modules,
    pipeline_state,
    sampler_place,
)

# Source: Vulkan 1.3 Specification, chapter Queries.
_STATISTICS = {
    "vertices_submitted": "INPUT_ASSEMBLY_VERTICES",
    "primitives_submitted": "INPUT_ASSEMBLY_PRIMITIVES",
    "vertex_shader_invocations": "VERTEX_SHADER_INVOCATIONS",
    "geometry_shader_invocations": "GEOMETRY_SHADER_INVOCATIONS",
    "geometry_primitives_emitted": "GEOMETRY_SHADER_PRIMITIVES",
    "clipping_input_primitives": "CLIPPING_INVOCATIONS",
    "clipping_output_primitives": "CLIPPING_PRIMITIVES",
    "fragment_shader_invocations": "FRAGMENT_SHADER_INVOCATIONS",
}
_STORES = "vertexPipelineStoresAndAtomics"


class VulkanSession(PassSession[RenderTarget, Linker]):
    target_class = RenderTarget
    device: Device
    _textures: BoundTextures

    def start(self) -> None:
        self.subpixel_step = 2.0**-self.device.limits.subPixelPrecisionBits
        own = self.stack.enter_context(Resources(self.device))
        self._textures = BoundTextures(self.folder, self.images, self.targets, own, self.linker)

    def render(
        self,
        draw: PreparedDraw,
        bindings: Bindings,
        target: RenderTarget,
        *,
        query: tuple[Any, int] | None = None,
    ) -> None:
        """As `PassSession.render`; `query` is a pool of one query, and the flags it begins with."""
        with Resources(self.device) as own:
            ready = self.ready(own, draw, bindings, target)
            with recording(self.device) as commands:
                if query is not None:
                    lib.vkCmdResetQueryPool(commands.handle, query[0], 0, 1)
                    lib.vkCmdBeginQuery(commands.handle, query[0], 0, query[1])
                ready.record(commands, target)
                if query is not None:
                    lib.vkCmdEndQuery(commands.handle, query[0], 0)

    def ready(
        self,
        own: Resources,
        draw: PreparedDraw,
        bindings: Bindings,
        target: RenderTarget,
        stored: Mapping[str, Buffer] | None = None,
    ) -> Ready:
        """Return all that a draw takes, on the device; `own` is released after it, `stored` are
        storage buffers by the names of their blocks."""
        description, state = draw.draw, draw.draw.state
        if not description.vertex_array:
            raise UnsupportedError("vertex_array=False: Vulkan has no vertex arrays to leave out")
        program = self.program(draw)
        locations = program.locations(target.colors)
        vertices = layout_of(description.mesh, program.attributes)
        colors = tuple(target.formats(locations, srgb=state.srgb).items())
        fixed = pipeline_state(state)
        layout = Layout(vertices, colors, target.depth, target.samples, fixed)
        values = {**bindings.uniforms, HEIGHT: np.array([target.size[1]], np.float32)}
        buffers, count = upload(own, description.mesh), description.instances
        bound = self._descriptors(own, program, draw, values, stored or {})
        return Ready(program, layout, locations, state, buffers, count, bound)

    def program(self, draw: PreparedDraw) -> Program:
        own = draw.texts
        if "fragment" in own:
            own["fragment"] = adapt_fragment(own["fragment"])
        own = write_point_texts(draw.draw, own)
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
        for name, block in bind.uniform_blocks(draw.interface).items():
            self._shared.check(draw.draw.blocks[name], block)
        buffers = block_buffers(own, program.bindings, values, stored)
        images: dict[str, BoundImage] = {}
        for name, source in draw.draw.textures.items():
            if sampler_place(name, program.bindings) is None:
                self._inactive.add(name)
                continue
            images[name] = self._textures.bind(draw.interface.uniforms[name], source)
        return new_set(own, program.set_layout, program.bindings, buffers, images)

    def capture_outputs(
        self, draw: PreparedDraw, texts: Texts, parts: Parts, bindings: Bindings, count: int | None
    ) -> Captured:
        """Store them in a storage buffer, as the interface has it."""
        if _STORES not in self.device.features:
            raise UnsupportedError(f"capturing vertices: this device has no {_STORES}")
        mesh = draw.draw.mesh
        assert mesh is not None
        most, each = 1, mesh.vertices
        if "geometry" in texts:
            module = parse(compile_modules(make_sources(draw.texts, draw.sources))["geometry"])
            most = module.modes[ExecutionMode.OutputVertices][0]
            each = most * len(primitive_corners(mesh))
        program = stages.store_outputs(texts, parts, most)
        words = stages.count_words(parts) * each * draw.draw.instances
        own = {stages.PER_INSTANCE: np.array([each], np.int32)}
        given = replace(bindings, uniforms={**bindings.uniforms, **own})
        with (
            Resources(self.device) as resources,
            RenderTarget(self.device, Target(), {}, (1, 1)) as target,
        ):
            buffer = resources.buffer("storage_buffer", size=4 * words)
            ready = self.ready(
                resources, replace(draw, rewritten=program), given, target, {stages.BLOCK: buffer}
            )
            with recording(self.device) as commands:
                ready.record(commands, target)
            return stages.unpack_outputs(parts, buffer.bytes[: 4 * words].copy().view(np.uint32))

    def _count(self, key: PassDraw, counter: str) -> int:
        """Return what one draw makes the device count, its pass drawn once more."""
        kind, feature, bits = "OCCLUSION", "occlusionQueryPrecise", 0
        if counter == "primitives_generated":
            kind, feature = "PRIMITIVES_GENERATED_EXT", "primitivesGeneratedQuery"
        elif counter in _STATISTICS:
            kind, feature = "PIPELINE_STATISTICS", "pipelineStatisticsQuery"
            bits = constant(f"QUERY_PIPELINE_STATISTIC_{_STATISTICS[counter]}_BIT")
        if feature not in self.device.features:
            raise UnsupportedError(f"counting {counter}: this device has no {feature}")
        precise = constant("QUERY_CONTROL_PRECISE_BIT") if kind == "OCCLUSION" else 0
        with Resources(self.device) as own, self.fresh_target(key[0]) as target:
            what = {"queryType": constant(f"QUERY_TYPE_{kind}"), "pipelineStatistics": bits}
            pool = own.create("QueryPool", Structs()("QueryPoolCreateInfo", queryCount=1, **what))
            for index, draw in enumerate(self.programs[key[0]][: key[1] + 1]):
                query = (pool, precise) if index == key[1] else None
                self.render(draw, self.bindings[key[0], index], target, query=query)
            found = ffi.new("uint64_t *")
            flags = constant("QUERY_RESULT_64_BIT") | constant("QUERY_RESULT_WAIT_BIT")
            result = lib.vkGetQueryPoolResults(self.device.handle, pool, 0, 1, 8, found, 8, flags)
            check(result, f"counting {counter}")
            return int(found[0])

    def _read_attributes(self, key: PassDraw) -> Mapping[str, AttributeReading]:
        """Read the structure that makes the pipeline: Vulkan has no query for it."""
        draw = self.programs[key[0]][key[1]]
        if draw.draw.mesh is None:
            return {}
        declared = self.program(draw).attributes
        layout = layout_of(draw.draw.mesh, declared)
        streams = {location: layout.streams[number] for location, number, *_ in layout.attributes}
        found = {}
        for name, variable in declared.items():
            if variable.location in streams:
                found[name] = AttributeReading(*streams[variable.location])
        return found

    def _read_blocks(self, key: PassDraw) -> Mapping[str, BlockReading]:
        """Read the modules' offsets, which are those that a driver reads at."""
        draw = self.programs[key[0]][key[1]]
        bindings = self.program(draw).bindings
        found = {}
        for name, placed in bind.uniform_blocks(draw.interface).items():
            block = bindings[name].block if name in bindings else None
            own, ours = (
                {m.name: m.offset for m in each.members.values()} if each else {}
                for each in (block, placed)
            )
            found[name] = BlockReading(own, block.size if block else 0, ours, placed.size)
        return found

    answers: ClassVar[Answers] = {
        **PassSession.answers,
        "count": _count,
        "attributes": _read_attributes,
        "blocks": _read_blocks,
    }


_INPUT, _SHARED = "shaderlab_input", "shaderlab_shared"
_WORD = "r32ui"


class VulkanBackend(DeviceBackend):
    linker_class = Linker
    session_class = VulkanSession
    device: Device
    linker: Linker

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        """Check that the device has each capability of the program's modules: it has no compiler
        for GLSL that could refuse it."""
        try:
            modules = compile_modules(sources)
        except ShaderError as error:
            raise DriverError(
                "a Vulkan driver takes no GLSL, and this program has no SPIR-V modules",
                file=error.file,
                line=error.line,
            ) from error
        check_capabilities(self.device, modules)
        return Verdict(target=DRIVER, ok=True)

    def evaluate(self, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
        with Resources(self.device) as own:
            images = self._textures(own, evaluation)
            if len(inputs):
                images[_INPUT] = _upload_inputs(own, evaluation, inputs)
            first = 0
            for source, words in evaluation.passes:
                outputs[first : first + words] = self._draw_words(evaluation, source, images)
                first += words

    def _draw_words(
        self, evaluation: Evaluation, source: Source, images: dict[str, BoundImage]
    ) -> Array:
        """Draw one pass: (words, height, width)."""
        texts = {"vertex": COVERING, "fragment": adapt_fragment(source.text)}
        program = self.linker.link(texts, [source])
        colors = dict.fromkeys(program.outputs, _WORD)
        with (
            Resources(self.device) as own,
            RenderTarget(self.device, Target(), colors, evaluation.size) as target,
        ):
            used = {n: i for n, i in images.items() if sampler_place(n, program.bindings)}
            values = dict(evaluation.uniforms)
            members = [b.block.members for b in program.bindings.values() if b.block is not None]
            count = next((m[_SHARED].array for m in members if _SHARED in m), None)
            if count is not None:
                values[_SHARED] = evaluation.shared[:count]
            buffers = block_buffers(own, program.bindings, values)
            draw_covering(own, program, target, buffers, used)
            locations = program.locations(colors)
            return np.stack([target.read(locations[at]).values[..., 0] for at in sorted(locations)])

    def _textures(self, own: Resources, evaluation: Evaluation) -> dict[str, BoundImage]:
        textures = BoundTextures(Path(evaluation.folder), {}, {}, own, self.linker)
        found = {}
        for name, (kind, source) in evaluation.textures.items():
            variable = Variable(name=name, type=kind)
            textures.texels("the function", variable, source)  # raises where they don't fit
            found[name] = textures.bind(variable, source)
        return found

    def close(self) -> None:
        self.linker.release()
        self.device.close()


def _upload_inputs(own: Resources, evaluation: Evaluation, inputs: Array) -> BoundImage:
    uses, count = ("sampled", "transfer_dst"), len(inputs)
    image = new_image(own, _WORD, evaluation.size, *uses, kind="2DArray", layers=count)
    write(own.device, image, [inputs[..., None]])
    sampler = own.create("Sampler", Structs()("SamplerCreateInfo"))
    return BoundImage(new_view(own, image, sampled=True), sampler)
