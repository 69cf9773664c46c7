"""WebGL2 behind the protocol of `shaderlab.drivers`: the backend and its sessions."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from shaderlab.compiler.diagnostics import DRIVER
from shaderlab.compiler.reflection import Variable
from shaderlab.compiler.sources import Source
from shaderlab.errors import DriverError, ShaderError, UnsupportedError, Verdict
from shaderlab.model.frame import Array, AttributeReading, Bindings, BlockReading, PassDraw
from shaderlab.model.mesh import Mesh

from .. import Answers
from ..passes import DeviceBackend, PassSession
from ..programs import bind, stages
from ..programs.captures import Captured, Parts, Texts
from ..programs.module_texts import HEIGHT, write_point_texts
from ..programs.prepare import PreparedDraw
from ..programs.stages import VaryingPart
from ..programs.textures import components_of, numpy_type
from .device import Calls, Device, Object, Objects, decode
from .program import Linker, Program, apply_state, check_state, find_refusal, translate
from .target import RenderTarget
from .textures import BoundTextures

_KINDS = {"f": "FLOAT", "i": "INT", "u": "UNSIGNED_INT"}


@dataclass(frozen=True)
class VertexArray:
    """A vertex array and what a draw takes of it: `count` vertices of a primitive."""

    handle: Object
    primitive: str
    count: int
    indexed: bool
    locations: Mapping[str, tuple[int, int]]

    def draw(self, gl: Calls, instances: int) -> None:
        gl.bindVertexArray(self.handle)
        mode = getattr(gl, self.primitive.upper())
        if self.indexed:
            gl.drawElementsInstanced(mode, self.count, gl.UNSIGNED_INT, 0, instances)
        else:
            gl.drawArraysInstanced(mode, 0, self.count, instances)


def vertex_array(own: Objects, mesh: Mesh | None, declared: Mapping[str, Variable]) -> VertexArray:
    """Return a mesh's vertex array for a stage with these inputs, or one of three vertices."""
    gl, made = own.gl, own.new("VertexArray")
    gl.bindVertexArray(made)
    if mesh is None:
        return VertexArray(made, "triangles", 3, False, {})
    if mesh.indices is not None:
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, own.new("Buffer"))
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, mesh.indices.astype("u4"), gl.STATIC_DRAW)
    buffers = []
    for parts in mesh.parts():
        buffers.append(own.new("Buffer"))
        gl.bindBuffer(gl.ARRAY_BUFFER, buffers[-1])
        gl.bufferData(gl.ARRAY_BUFFER, b"".join(piece for _, piece in parts), gl.STATIC_DRAW)
    locations = {}
    for name, place in mesh.placements().items():
        variable = declared.get(name)
        if variable is None or variable.location is None:
            continue
        gl.bindBuffer(gl.ARRAY_BUFFER, buffers[place.buffer])
        array, integer = mesh.inputs[name], numpy_type(variable.type)().dtype.kind in "iu"
        columns = array.shape[2] if array.ndim == 3 else 1
        letter = "u" if variable.type[0] == "u" else array.dtype.kind
        kind = getattr(gl, _KINDS[letter])
        size = array.shape[1]
        for column in range(columns):
            at = variable.location + column
            offset = place.offset + column * size * array.itemsize
            gl.enableVertexAttribArray(at)
            if integer:
                gl.vertexAttribIPointer(at, size, kind, place.stride, offset)
            else:
                gl.vertexAttribPointer(at, size, kind, False, place.stride, offset)
            gl.vertexAttribDivisor(at, place.divisor)
        locations[name] = (variable.location, place.buffer)
    count = mesh.vertices if mesh.indices is None else len(mesh.indices)
    return VertexArray(made, mesh.primitive, count, mesh.indices is not None, locations)


_AT_ONCE = 8  # vectors; every device captures 16, and some of those are the author's own
_CHANNELS = 4
_FRAGMENT = "#version 330 core\nvoid main() {}\n"


class WebGLSession(PassSession[RenderTarget, Linker]):
    target_class = RenderTarget
    device: Device
    _textures: BoundTextures

    def start(self) -> None:
        self.subpixel_step = 2.0 ** -self.device.gl.about["subpixel"]
        own = self.stack.enter_context(Objects(self.device.gl))
        self._textures = BoundTextures(self.folder, self.images, self.targets, self.device, own)

    def issue(self, key: PassDraw, draw: PreparedDraw, target: RenderTarget) -> None:
        super().issue(key, draw, target)

        def note(errors: list[int]) -> None:
            if errors:
                self._gl_errors[key] = tuple(errors)

        self.device.gl.ask_later(note, "errors")

    def finish(self) -> None:
        self.device.gl.ask("finish")

    def render(self, draw: PreparedDraw, bindings: Bindings, target: RenderTarget) -> None:
        state = draw.draw.state
        encodes = "srgb8_alpha8" in target.colors.values()
        check_state(state, samples=target.samples, encodes=encodes)
        program = self.program_of(draw)

        def draw_to(vertices: VertexArray) -> None:
            target.bind(program.outputs(target.colors))
            apply_state(self.device.gl, state, target.size)
            vertices.draw(self.device.gl, draw.draw.instances)

        values = {HEIGHT: np.array([target.size[1]], np.float32)}
        self.use(program, draw, bindings, values, draw_to)

    def program_of(self, draw: PreparedDraw) -> Program:
        """Return the program that draws."""
        return self.linker.link(write_point_texts(draw.draw, draw.texts), draw.sources)

    def use(
        self,
        program: Program,
        draw: PreparedDraw,
        bindings: Bindings,
        values: Mapping[str, np.ndarray],
        then: Callable[[VertexArray], None],
    ) -> None:
        """Set a program's uniforms, further `values` among them, bind its textures and its mesh,
        and go on with the vertex array."""
        if not draw.draw.vertex_array:
            raise UnsupportedError("vertex_array=False: WebGL2 always has a vertex array")
        gl = self.device.gl
        with Objects(gl) as own:
            gl.useProgram(program.handle)
            members = bind.block_members(draw.interface)
            for name, value in {**bindings.uniforms, **values, **draw.ramps}.items():
                if name not in members and not program.set(name, value) and name != HEIGHT:
                    self._inactive.add(name)
            self._blocks(own, program, draw, bindings)
            unit = 0
            for name, source in draw.draw.textures.items():
                if name not in program.locations:
                    self._inactive.add(name)
                    continue
                self._textures.bind(unit, draw.interface.uniforms[name], source)
                gl.uniform1i(program.locations[name], unit)
                unit += 1
            then(vertex_array(own, draw.draw.mesh, program.interface.attributes))
            gl.bindVertexArray(None)

    def _blocks(
        self, own: Objects, program: Program, draw: PreparedDraw, bindings: Bindings
    ) -> None:
        gl = self.device.gl
        for point, (name, block) in enumerate(bind.uniform_blocks(draw.interface).items()):
            self._shared.check(draw.draw.blocks[name], block)
            if name not in program.blocks:
                self._inactive.add(name)
                continue
            buffer = own.new("Buffer")
            gl.bindBuffer(gl.UNIFORM_BUFFER, buffer)
            gl.bufferData(
                gl.UNIFORM_BUFFER, bind.pack_block(block, bindings.uniforms), gl.STATIC_DRAW
            )
            gl.uniformBlockBinding(program.handle, program.blocks[name], point)
            gl.bindBufferBase(gl.UNIFORM_BUFFER, point, buffer)

    def capture_outputs(
        self, draw: PreparedDraw, texts: Texts, parts: Parts, bindings: Bindings, count: int | None
    ) -> Captured:
        """Capture them by transform feedback, as the interface has it."""
        assert count is not None, "without a geometry stage it is known"
        found: dict[VaryingPart, Array] = {}
        for start in range(0, len(parts), _AT_ONCE):
            group = parts[start : start + _AT_ONCE]
            text, names = stages.capture_vertex(texts["vertex"], group)
            program = self.linker.link(
                {**texts, "vertex": text, "fragment": _FRAGMENT}, feedback=tuple(names.values())
            )
            raw = self._feed_back(draw, program, bindings, 4 * _CHANNELS * len(group) * count)
            rows = raw.reshape(count, len(group), _CHANNELS)
            for number, piece in enumerate(group):
                part = np.ascontiguousarray(rows[:, number, : components_of(piece.type)])
                found[piece] = part.view(numpy_type(piece.type))
        return found

    def _feed_back(
        self, draw: PreparedDraw, program: Program, bindings: Bindings, size: int
    ) -> Array:
        """Return the floats, of so many bytes, that a draw's vertices leave in a buffer."""
        gl = self.device.gl
        with Objects(gl) as own:
            buffer = own.new("Buffer")

            def feed(vertices: VertexArray) -> None:
                gl.bindFramebuffer(gl.FRAMEBUFFER, None)
                gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, buffer)
                gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, bytes(size), gl.STREAM_READ)
                gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, buffer)
                gl.enable(gl.RASTERIZER_DISCARD)
                gl.beginTransformFeedback(gl.POINTS)
                vertices.draw(gl, draw.draw.instances)
                gl.endTransformFeedback()
                gl.disable(gl.RASTERIZER_DISCARD)

            self.use(program, draw, bindings, {}, feed)
            data, errors = gl.ask_all(
                [("contents", gl.TRANSFORM_FEEDBACK_BUFFER, size), ("errors",)]
            )
            gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, None)
        if errors:
            raise DriverError(f"capturing vertices: WebGL2 raised {', '.join(map(hex, errors))}")
        return decode(data, np.float32)

    def _read_attributes(self, key: PassDraw) -> Mapping[str, AttributeReading]:
        """Return what WebGL2 says of each attribute's place."""
        draw = self.programs[key[0]][key[1]]
        if draw.draw.mesh is None:
            return {}
        program = self.program_of(draw)
        gl = self.device.gl
        found = {}
        with Objects(gl) as own:
            made = vertex_array(own, draw.draw.mesh, program.interface.attributes)
            for name, (at, buffer) in made.locations.items():
                questions = [
                    ("getVertexAttribOffset", at, gl.VERTEX_ATTRIB_ARRAY_POINTER),
                    ("getVertexAttrib", at, gl.VERTEX_ATTRIB_ARRAY_STRIDE),
                    ("getVertexAttrib", at, gl.VERTEX_ATTRIB_ARRAY_DIVISOR),
                ]
                found[name] = AttributeReading(buffer, *gl.ask_all(questions))
            gl.bindVertexArray(None)
        return found

    def _read_blocks(self, key: PassDraw) -> Mapping[str, BlockReading]:
        """Return what WebGL2 says of each block's members."""
        draw = self.programs[key[0]][key[1]]
        program = self.program_of(draw)
        gl, found = self.device.gl, {}
        for name, block in bind.uniform_blocks(draw.interface).items():
            offsets: dict[str, int] = {}
            size = 0
            if name in program.blocks:
                which = (program.handle, program.blocks[name])
                whole = ("getActiveUniformBlockParameter", *which, gl.UNIFORM_BLOCK_DATA_SIZE)
                size, offsets = gl.ask_all([whole, ("offsets", *which)])
            placed = {member.name: member.offset for member in block.members.values()}
            own = {}
            for member in placed:
                # SPIRV-Cross gives each block an instance: its members have its name in front.
                for said in (f"{name}.{member}", f"{name}.{member}[0]"):
                    if said in offsets:
                        own[member] = offsets[said]
            found[name] = BlockReading(own, size, placed, block.size)
        return found

    def _count(self, key: PassDraw, counter: str) -> int:
        raise UnsupportedError(f"counting {counter}: WebGL2 only says whether there was any")

    def _locations(self, key: PassDraw) -> Mapping[str, int]:
        """Number the uniforms: WebGL2 only says whether there is one."""
        draw = self.programs[key[0]][key[1]]
        program = self.program_of(draw)
        active = list(program.locations)
        return {
            name: active.index(name) if name in active else -1 for name in draw.interface.uniforms
        }

    answers: ClassVar[Answers] = {
        **PassSession.answers,
        "count": _count,
        "attributes": _read_attributes,
        "blocks": _read_blocks,
        "locations": _locations,
        "gl_errors": PassSession.find_errors,
    }


class WebGLBackend(DeviceBackend):
    linker_class = Linker
    session_class = WebGLSession
    device: Device

    def in_use(self) -> AbstractContextManager[object]:
        self.device.gl.start_afresh()
        return super().in_use()

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        """Of the ESSL that SPIRV-Cross makes of a program. A stage alone is only compiled."""
        texts = {source.stage: source.text for source in sources}
        try:
            essl, _ = translate(texts, sources)
        except UnsupportedError:
            raise
        except ShaderError as error:
            raise DriverError(
                "WebGL2 gets ESSL made of a module, and of this program there is none",
                file=error.file,
                line=error.line,
            ) from error
        with Objects(self.device.gl) as own:
            refused = find_refusal(self.device.gl, own.new("Program"), essl)
        said = (sources[0].diagnostic(refused),) if refused else ()
        return Verdict(target=DRIVER, ok=not refused, diagnostics=said)

    def close(self) -> None:
        self.device.close()
