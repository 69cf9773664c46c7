"""Drawing a scene's passes, and reading back what they drew."""

from collections.abc import Container, Iterable, Mapping, Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

from shaderlab.compiler.diagnostics import parse_driver_log
from shaderlab.compiler.reflection import Variable
from shaderlab.compiler.sources import Source
from shaderlab.errors import DriverError, ShaderError, UnsupportedError
from shaderlab.model.frame import Array, Bindings, Image, PassDraw
from shaderlab.model.mesh import Mesh
from shaderlab.model.phases import phase
from shaderlab.model.scene import Target

from .. import Drawn, Evaluation
from ..passes import PassSession
from ..programs import bind, stages, storage
from ..programs.prepare import PreparedDraw, describe_draw
from ..programs.stages import VaryingPart
from ..programs.textures import components_of, numpy_type
from ..resources import COVERING
from .buffers import UniformBuffers, VertexArray, bind_storage_buffer, make_vertex_array
from .device import GL, Device, apply_state, gl_constant, require_inputs
from .linking import Linker, output_locations, set_uniforms
from .target import RenderTarget
from .textures import BoundTextures, bind_images, read_images


class Drawing(PassSession[RenderTarget, Linker]):
    target_class = RenderTarget
    device: Device
    _textures: BoundTextures

    def start(self) -> None:
        stack = self.stack
        self._textures = BoundTextures(self.folder, self.images, self.targets, self.device, stack)
        self._blocks = UniformBuffers(self.device, stack)
        self._arrays: dict[tuple[int, int], tuple[Any, Mesh | None, VertexArray]] = {}
        self.shares_captures = not self.device.takes_spirv
        self._locations: dict[tuple[int, tuple[str, ...]], Mapping[str, int]] = {}

    def draw(self, only: Container[str] | None = None) -> Drawn:
        recorder = self.device.recorder
        with nullcontext() if recorder is None else recorder.recording():
            return super().draw(only)

    def at(self, pass_name: str | None, draw: int | None = None) -> None:
        self.device.at(pass_name, draw)

    def finish(self) -> None:
        self.device.context.finish()

    def compute(self, key: PassDraw, draw: PreparedDraw) -> None:
        storage.require_supported(draw.draw, draw.interface)
        with phase("draw", describe_draw(key, draw)):
            given = self.bind(draw)
            found = storage.bind_storage(draw.draw, draw.interface, given, self.folder, self.images)
            self.bindings[key] = found
            program = self._link(draw)
            self.use(program, draw, found)
            drain_errors()
            left = dispatch(self.device, program, draw, found)
            errors = drain_errors()
        self.images |= {(key[0], name): image for name, image in left.items()}
        if errors:
            self._gl_errors[key] = errors

    def use(
        self, program: Any, draw: PreparedDraw, bindings: Bindings, *, only_active: bool = False
    ) -> None:
        """Set uniforms and bind textures; with `only_active`, of those that the program knows."""
        set_uniforms(program, draw.ramps)
        members = bind.block_members(draw.interface)
        plain = {
            name: value
            for name, value in bindings.uniforms.items()
            if name not in members and not (only_active and program.get(name, None) is None)
        }
        self._inactive.update(set_uniforms(program, plain))
        self._inactive.update(self._blocks.bind(program, draw, bindings.uniforms))
        for unit, (name, source) in enumerate(draw.draw.textures.items()):
            variable = draw.interface.uniforms[name]
            if not self._textures.bind(program, unit, variable, source):
                self._inactive.add(name)

    def issue(self, key: PassDraw, draw: PreparedDraw, target: RenderTarget) -> None:
        program, vao = self.set_up(draw, self.bindings[key], target)
        drain_errors()
        submit(vao, program, draw)
        errors = drain_errors()
        if errors:
            self._gl_errors[key] = errors

    def render(self, draw: PreparedDraw, bindings: Bindings, target: RenderTarget) -> None:
        program, vao = self.set_up(draw, bindings, target)
        submit(vao, program, draw)
        drain_errors()

    def set_up(
        self, draw: PreparedDraw, bindings: Bindings, target: RenderTarget
    ) -> tuple[Any, VertexArray]:
        """Bind and set everything for a draw, which `submit` then issues: its program and vertex
        array. Raises what `render` does."""
        require_inputs(self.device, draw)
        program = self._link(draw)
        self.use(program, draw, bindings, only_active=draw.rewritten is not None)
        vao = self._vertex_array(program, draw.draw.mesh)
        key = id(program), tuple(target.colors)  # the program is kept with its vertex array
        if key not in self._locations:
            self._locations[key] = output_locations(program, target.colors)
        target.bind(self._locations[key])
        apply_state(draw.draw.state, target.size, self.device.version)
        return program, vao

    def _link(self, draw: PreparedDraw) -> Any:
        require_glsl(self.device, draw)
        try:
            return self.linker.link(draw.texts)
        except ShaderError as error:
            raise ShaderError(
                error.message, file=draw.authored[-1].path, remedy=error.remedy
            ) from error

    def _vertex_array(self, program: Any, mesh: Mesh | None) -> VertexArray:
        key = (id(program), id(mesh))
        if key not in self._arrays:
            made = make_vertex_array(self.device, program, mesh)
            # Program and mesh are kept with it, so that nothing else gets their identity.
            self._arrays[key] = (program, mesh, made)
        return self._arrays[key][2]


def require_glsl(device: Device, draw: PreparedDraw) -> None:
    """Raise UnsupportedError for a shader of a newer GLSL than the driver takes."""
    for source in draw.sources:
        number, profile = source.version
        if profile != "es" and number > device.glsl:
            raise UnsupportedError(
                f"#version {number}: this driver takes GLSL up to {device.glsl}", file=source.path
            )


def submit(vao: VertexArray, program: Any, draw: PreparedDraw) -> None:
    description = draw.draw
    if description.state.point_size is None:
        # A shader that gives points no size gets the default one, a pixel.
        (GL.glEnable if "gl_PointSize" in draw.last_text else GL.glDisable)(
            GL.GL_PROGRAM_POINT_SIZE
        )
    mode = gl_constant(description.mesh.primitive if description.mesh else "triangles")
    if description.mesh is not None and mode == GL.GL_PATCHES:
        GL.glPatchParameteri(GL.GL_PATCH_VERTICES, description.mesh.patch_vertices)
    if not description.vertex_array:
        GL.glUseProgram(program.glo)
        GL.glBindVertexArray(0)
        GL.glDrawArrays(mode, 0, vao.count)
        return
    vao.render(mode, instances=description.instances)


def drain_errors() -> tuple[int, ...]:
    """Return all GL errors raised since the last call, oldest first."""
    return tuple(map(int, islice(iter(GL.glGetError, GL.GL_NO_ERROR), 16)))


def has_compute(device: Device) -> bool:
    """Whether a device has compute shaders and storage buffers."""
    return device.version >= 430


def dispatch(
    device: Device, program: Any, draw: PreparedDraw, bindings: Bindings
) -> Mapping[str, Image]:
    """Run a program that is linked and whose uniforms and textures are set. Returns what is left in
    each image and each member that is not `readonly`; of what has no effect what it held before, as
    `bindings` have it. Raises DriverError: the driver lays a block out differently."""
    known, values = storage.find_slots(draw.interface), bindings.buffers
    buffers: list[tuple[Any, bytearray, Mapping[str, storage.Slot]]] = []
    with ExitStack() as stack:
        for point, (name, block) in enumerate(storage.storage_blocks(draw.interface).items()):
            members = {slot.name: slot for slot in known.values() if slot.block == name}
            data = storage.pack_storage(block, members, values)
            buffer = device.context.buffer(data)
            stack.callback(buffer.release)
            buffers.append((buffer, data, members))
            bind_storage_buffer(program, block, buffer, point)
        textures = bind_images(device, program, bindings.images, stack)
        GL.glUseProgram(program.glo)
        GL.glDispatchCompute(*draw.draw.groups)
        GL.glMemoryBarrier(GL.GL_BUFFER_UPDATE_BARRIER_BIT | GL.GL_TEXTURE_UPDATE_BARRIER_BIT)
        # Drivers compute when they are made to: a program that hangs, hangs here.
        device.context.finish()
        device.at(None)
        changed = read_images(textures, bindings.images)
        left = {n: i for n, i in changed.items() if not draw.interface.uniforms[n].readonly}
        for buffer, data, inside in buffers:
            data[:] = buffer.read()
            left |= {
                name: storage.member_image(slot, storage.unpack_storage(slot, data, values[name]))
                for name, slot in inside.items()
                if not slot.member.readonly
            }
        return left


def evaluate(
    device: Device, linker: Linker, evaluation: Evaluation, inputs: Array, outputs: Array
) -> None:
    context, size = device.context, evaluation.size
    context.enable_only(moderngl.NOTHING)
    # The framebuffer that is bound may be a scene's, which is gone by now.
    context.detect_framebuffer(0).use()
    with ExitStack() as stack:
        if len(inputs):
            texture = context.texture_array((*size, len(inputs)), 1, inputs, dtype="u4")
            stack.callback(texture.release)
            texture.use(0)
        first = 0
        for source, words in evaluation.passes:
            program = _link_function(linker, source)
            made = [context.texture(size, 1, dtype="u4") for _ in range(words)]
            target = context.framebuffer(made)
            for each in (target, *made):
                stack.callback(each.release)
            _set_inputs(device, program, evaluation, stack)
            target.use()
            for n in range(words):
                GL.glClearBufferuiv(GL.GL_COLOR, n, np.zeros(4, np.uint32))
            context.vertex_array(program, []).render(vertices=3)
            for n in range(words):
                target.read_into(outputs[first + n], None, 1, attachment=n, dtype="u4")
            first += words
    error = context.error
    if error != "GL_NO_ERROR":
        raise DriverError(f"the driver raised {error} while it called a function")


def _link_function(linker: Linker, source: Source) -> Any:
    try:
        return linker.link({"vertex": COVERING, "fragment": source.text})
    except ShaderError as error:
        log = parse_driver_log(error.message.partition("\n")[2], source, ok=False)
        errors = [each for each in log if each.severity == "error"]
        if not errors:
            raise
        first = errors[0]
        raise ShaderError(first.message, file=first.file, line=first.line) from error


def _set_inputs(device: Device, program: Any, evaluation: Evaluation, stack: ExitStack) -> None:
    if "shaderlab_input" in program:
        program["shaderlab_input"].value = 0
    if len(evaluation.shared) and "shaderlab_shared" in program:
        shared = program["shaderlab_shared"]
        shared.write(evaluation.shared[: shared.array_length].tobytes())
    set_uniforms(program, evaluation.uniforms)
    textures = BoundTextures(Path(evaluation.folder), {}, {}, device, stack)
    for unit, (name, (kind, source)) in enumerate(evaluation.textures.items(), start=1):
        variable = Variable(name=name, type=kind)
        textures.texels("the function", variable, source)  # raises where they don't fit
        textures.bind(program, unit, variable, source)


# What every OpenGL 3.3 driver can write of one vertex in one draw.
MAX_COMPONENTS = 64
UNDEFINED = np.uint32(0xFFFFFFFF)
"""The bits of an output that nothing writes: NaN in floats, −1 and the largest number in others."""


def capture_outputs(
    drawing: Drawing,
    draw: PreparedDraw,
    texts: Mapping[str, str],
    parts: Sequence[VaryingPart],
    bindings: Bindings,
    count: int | None,
) -> dict[VaryingPart, Array]:
    """As `PassSession.capture_outputs`, by transform feedback; without a `count` the vertices are
    counted first. Raises DriverError: the driver writes down fewer vertices than it says there are.
    """
    found: dict[VaryingPart, Array] = {}
    written = _find_written(drawing, texts, parts)
    for group in _group_parts([piece for piece in parts if piece.name in written]):
        sizes = [components_of(piece.type) for piece in group]
        names = tuple(dict.fromkeys(piece.name for piece in group))
        program = drawing.linker.link(texts, feedback=names)
        mode = int(program.geometry_output or GL.GL_POINTS)  # of strips the single primitives
        if "tess_evaluation" in texts:
            mode = gl_constant(stages.patch_primitive(texts["tess_evaluation"]))
        if count is None:
            count, _ = _draw_into_buffer(drawing, draw, program, mode, bindings, 1, 4 * sum(sizes))
        _, data = _draw_into_buffer(drawing, draw, program, mode, bindings, count, 4 * sum(sizes))
        raw = np.frombuffer(data, np.float32).reshape(count, sum(sizes))
        columns = np.split(raw, np.cumsum(sizes)[:-1], axis=1)
        for piece, part in zip(group, columns, strict=True):
            found[piece] = np.ascontiguousarray(part).view(numpy_type(piece.type))
    undefined = {p: np.full((count or 0, components_of(p.type)), UNDEFINED) for p in parts}
    return {p: found.get(p, u.view(numpy_type(p.type))) for p, u in undefined.items()}


def _find_written(
    drawing: Drawing, texts: Mapping[str, str], parts: Sequence[VaryingPart]
) -> set[str]:
    """Return the names of those outputs that the program has. A driver may drop one that is
    declared and never written, and then refuses to capture it. Raises ShaderError: it refuses the
    program as well if nothing is captured."""

    def is_linked(names: Iterable[str]) -> bool:
        try:
            return bool(drawing.linker.link(texts, feedback=tuple(names)))
        except ShaderError:
            return False

    groups = [dict.fromkeys(piece.name for piece in group) for group in _group_parts(parts)]
    names = {name for group in groups for name in group}
    if all(map(is_linked, groups)):
        return names
    drawing.linker.link(texts)
    return {name for name in names if is_linked([name])}


def _group_parts(parts: Sequence[VaryingPart]) -> list[list[VaryingPart]]:
    """Divide the parts into groups that one draw captures; a matrix stays together."""
    groups: list[list[VaryingPart]] = [[]]
    room = MAX_COMPONENTS
    for name in dict.fromkeys(piece.name for piece in parts):
        own = [piece for piece in parts if piece.name == name]
        size = sum(components_of(piece.type) for piece in own)
        if size > room:
            groups.append([])
            room = MAX_COMPONENTS
        groups[-1].extend(own)
        room -= size
    return groups


def _draw_into_buffer(
    drawing: Drawing,
    draw: PreparedDraw,
    program: Any,
    mode: int,
    bindings: Bindings,
    room: int,
    stride: int,
) -> tuple[int, bytes]:
    """Draw into a buffer with room for so many vertices of `stride` bytes: how many there would
    have been, and what was written. Raises DriverError: the buffer is large enough, but less was
    written."""
    corner_count = {GL.GL_LINES: 2, GL.GL_TRIANGLES: 3}.get(mode, 1)
    device = drawing.device
    # Transform feedback without a complete framebuffer returns zeros without an error.
    target = RenderTarget(device, Target(), {"unused": "r8"}, (1, 1))
    buffer = device.context.buffer(reserve=max(room * stride, 4))
    queries = np.atleast_1d(GL.glGenQueries(2))
    try:
        target.clear()
        drawing.use(program, draw, bindings)
        vao = make_vertex_array(device, program, draw.draw.mesh)
        GL.glUseProgram(program.glo)
        GL.glBindBufferBase(GL.GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffer.glo)
        GL.glEnable(GL.GL_RASTERIZER_DISCARD)
        GL.glBeginQuery(GL.GL_PRIMITIVES_GENERATED, queries[0])
        GL.glBeginQuery(GL.GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, queries[1])
        GL.glBeginTransformFeedback(mode)
        submit(vao, program, replace(draw, draw=replace(draw.draw, vertex_array=True)))
        GL.glEndTransformFeedback()
        GL.glEndQuery(GL.GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN)
        GL.glEndQuery(GL.GL_PRIMITIVES_GENERATED)
        generated, written = (
            int(GL.glGetQueryObjectuiv(query, GL.GL_QUERY_RESULT)) for query in queries
        )
        drain_errors()
        data = buffer.read(room * stride) if room else b""
    finally:
        GL.glDisable(GL.GL_RASTERIZER_DISCARD)
        GL.glBindBufferBase(GL.GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0)
        GL.glDeleteQueries(2, queries)
        buffer.release()
        target.release()
    if written < generated and generated * corner_count <= room:
        raise DriverError(f"transform feedback wrote {written} of {generated} primitives")
    return generated * corner_count, data
