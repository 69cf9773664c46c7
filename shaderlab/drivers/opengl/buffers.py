"""Buffers on the device: meshes, the vertex arrays that read them, uniform and storage blocks."""

import ctypes
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Block
from shaderlab.errors import DriverError
from shaderlab.model.frame import Array, AttributeReading, BlockReading
from shaderlab.model.mesh import Mesh, Placement
from shaderlab.model.scene import UniformBuffer

from ..programs import bind
from ..programs.prepare import PreparedDraw
from .device import GL, Device, gl_constant
from .linking import has_names, read_resource

_KINDS = {"f": 0x1406, "i": 0x1404, "u": 0x1405}
_INDICES = {1: 0x1401, 2: 0x1403, 4: 0x1405}  # GL_UNSIGNED_BYTE, _SHORT and _INT, by bytes


class DeviceBuffer:
    """A buffer that is made without any contents; moderngl's always reserves some. It is deleted
    when nothing refers to it any more, as moderngl's objects are."""

    def __init__(self, device: Device) -> None:
        self.glo = int(GL.glGenBuffers(1))
        self._device = device

    def __del__(self) -> None:
        context = self._device.context
        if context.gc_mode == "context_gc":  # see Device.make_current
            context.objects.append(self)

    def release(self) -> None:
        GL.glDeleteBuffers(1, np.array([self.glo], np.uint32))


@dataclass(frozen=True)
class VertexArray:
    """A vertex array and its buffers, for one program; a draw takes `count` vertices."""

    made: Any
    program: Any
    count: int
    buffers: tuple[DeviceBuffer, ...] = ()
    indices: Any = None

    def render(self, mode: int, *, instances: int = 1) -> None:
        GL.glUseProgram(self.program.glo)
        GL.glBindVertexArray(self.made.glo)
        if self.indices is None:
            GL.glDrawArraysInstanced(mode, 0, self.count, instances)
        else:
            kind = _INDICES[self.indices.size // self.count]
            GL.glDrawElementsInstanced(mode, self.count, kind, ctypes.c_void_p(0), instances)


def make_vertex_array(device: Device, program: Any, mesh: Mesh | None) -> VertexArray:
    """Make a vertex array of `mesh` for `program`, or one of three vertices without attributes.
    Raises DriverError: a buffer can't be mapped."""
    context = device.context
    # moderngl makes and deletes it; a program of modules is none of moderngl's.
    owner = program if has_names(program) else device.any_program
    if mesh is None:
        return VertexArray(context.vertex_array(owner, []), program, 3)
    indices = None if mesh.indices is None else context.buffer(mesh.indices)
    size = 4 if mesh.indices is None else mesh.indices.itemsize
    made = context.vertex_array(owner, [], index_buffer=indices, index_element_size=size)
    buffers = tuple(fill_buffer(device, parts, mesh) for parts in mesh.parts())
    for name, place in mesh.placements().items():
        member = program.get(name, None)
        if member is not None:  # else it is declared, but the driver found that it has no effect
            _point_attribute(made.glo, buffers[place.buffer].glo, member, mesh.inputs[name], place)
    count = mesh.vertices if mesh.indices is None else len(mesh.indices)
    return VertexArray(made, program, count, buffers, indices)


def read_layout(program: Any, vao: VertexArray, mesh: Mesh) -> dict[str, AttributeReading]:
    """Read where OpenGL itself finds each attribute; those without effect are left out."""
    names = [buffer.glo for buffer in vao.buffers]
    found = {}
    GL.glBindVertexArray(vao.made.glo)
    for name in mesh.inputs:
        member = program.get(name, None)
        if member is None:
            continue
        at = member.location
        pointer = ctypes.c_void_p()
        GL.glGetVertexAttribPointerv(at, GL.GL_VERTEX_ATTRIB_ARRAY_POINTER, ctypes.byref(pointer))
        stride, divisor, buffer = (
            int(np.ravel(GL.glGetVertexAttribiv(at, word))[0])
            for word in (
                GL.GL_VERTEX_ATTRIB_ARRAY_STRIDE,
                GL.GL_VERTEX_ATTRIB_ARRAY_DIVISOR,
                GL.GL_VERTEX_ATTRIB_ARRAY_BUFFER_BINDING,
            )
        )
        offset = pointer.value or 0
        found[name] = AttributeReading(names.index(buffer), offset, stride, divisor)
    GL.glBindVertexArray(0)
    return found


def fill_buffer(device: Device, parts: list[tuple[int, bytes]], mesh: Mesh) -> DeviceBuffer:
    whole = b"".join(piece for _, piece in parts)
    buffer = DeviceBuffer(device)
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, buffer.glo)
    given = whole if mesh.upload == "data" and whole else None
    GL.glBufferData(GL.GL_ARRAY_BUFFER, max(len(whole), 1), given, gl_constant(mesh.usage))
    if mesh.upload == "sub_data":
        for offset, piece in parts:
            GL.glBufferSubData(GL.GL_ARRAY_BUFFER, offset, len(piece), piece)
    elif mesh.upload == "map" and whole:
        write_mapped(GL.GL_ARRAY_BUFFER, whole)
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, 0)
    return buffer


def _point_attribute(vao: int, buffer: int, member: Any, array: Array, place: Placement) -> None:
    """Tell OpenGL how one attribute is read; a matrix takes a location for each column."""
    columns = array.shape[2] if array.ndim == 3 else 1
    components = array.shape[1]
    GL.glBindVertexArray(vao)
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, buffer)
    for column in range(columns):
        at = member.location + column
        pointer = ctypes.c_void_p(place.offset + column * components * array.itemsize)
        GL.glEnableVertexAttribArray(at)
        if member.shape in ("i", "I"):
            kind = _KINDS["u" if member.shape == "I" else array.dtype.kind]
            GL.glVertexAttribIPointer(at, components, kind, place.stride, pointer)
        else:
            kind = _KINDS[array.dtype.kind]
            GL.glVertexAttribPointer(at, components, kind, False, place.stride, pointer)
        GL.glVertexAttribDivisor(at, place.divisor)
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, 0)
    GL.glBindVertexArray(0)


def write_mapped(target: int, whole: bytes) -> None:
    """Fill the buffer bound to a target. Raises DriverError: it can't be mapped, or was lost."""
    address = GL.glMapBufferRange(target, 0, len(whole), GL.GL_MAP_WRITE_BIT)
    if not address:
        raise DriverError(f"the driver does not map a buffer of {len(whole)} bytes")
    ctypes.memmove(address, whole, len(whole))
    if not GL.glUnmapBuffer(target):
        raise DriverError("the driver lost a buffer's contents while it was mapped")


class UniformBuffers:
    """Makes each buffer when it is first bound; `stack` releases them in the end."""

    def __init__(self, device: Device, stack: ExitStack) -> None:
        self._device = device
        self._stack = stack
        self._shared = bind.SharedLayouts()
        self._made: dict[tuple[int, bytes], Any] = {}

    def bind(
        self, program: Any, draw: PreparedDraw, uniforms: Mapping[str, Array]
    ) -> Iterator[str]:
        """Bind a buffer to each uniform block of a program; yields the blocks without any effect.
        Raises CaseError: two programs that share a buffer lay it out differently; DriverError: the
        driver lays a block out differently."""
        for point, (name, block) in enumerate(bind.uniform_blocks(draw.interface).items()):
            index = find_block(program, block)
            if index is None:
                yield name
                continue
            check_layout(program, block)
            GL.glUniformBlockBinding(program.glo, index, point)
            buffer = self._buffer(draw.draw.blocks[name], block, bind.pack_block(block, uniforms))
            buffer.bind_to_uniform_block(point)

    def _buffer(self, source: UniformBuffer, block: Block, data: bytes) -> Any:
        """Return the one buffer of a UniformBuffer; a probe with other values gets another."""
        self._shared.check(source, block)
        key = (id(source), data)
        if key not in self._made:
            self._made[key] = self._device.context.buffer(data)
            self._stack.callback(self._made[key].release)
        return self._made[key]


def bind_storage_buffer(program: Any, block: Block, buffer: Any, point: int) -> None:
    """Bind a buffer to a storage block of a program; a module says the block's binding itself.
    Raises DriverError: the driver lays the block out differently."""
    if not has_names(program):
        buffer.bind_to_storage_buffer(block.binding or 0)
        return
    index = find_block(program, block)
    if index is not None:
        check_layout(program, block)
        GL.glShaderStorageBlockBinding(program.glo, index, point)
        buffer.bind_to_storage_buffer(point)


def find_block(program: Any, block: Block) -> int | None:
    """Find the index of a uniform or storage block in a program; None where it has no effect."""
    if not has_names(program):
        of_module: int | None = program.block(block.name) if block.kind == "uniform" else 0
        return of_module
    if block.kind == "uniform":
        index = int(GL.glGetUniformBlockIndex(program.glo, block.name.encode()))
    else:
        index = _find_resource(program, GL.GL_SHADER_STORAGE_BLOCK, block.name)
    return None if index == GL.GL_INVALID_INDEX else index


def read_block(program: Any, block: Block) -> BlockReading:
    """Read where the driver has a block's members, beside where the lab (or a module) has them."""
    placed = {name: member.offset for name, member in block.members.items()}
    index, size, offsets = find_block(program, block), 0, dict[str, int]()
    if index is not None:
        if block.kind == "uniform":
            got = np.zeros(1, np.int32)
            GL.glGetActiveUniformBlockiv(program.glo, index, GL.GL_UNIFORM_BLOCK_DATA_SIZE, got)
            size, find_offset = int(got[0]), _find_uniform_offset
        else:
            what = (GL.GL_SHADER_STORAGE_BLOCK, index, GL.GL_BUFFER_DATA_SIZE)
            size = read_resource(program.glo, *what) if has_names(program) else block.size
            find_offset = _find_storage_offset
        if not has_names(program):
            offsets = dict(placed)
        else:
            found = {n: find_offset(program, bind.member_name(block, n)) for n in placed}
            offsets = {name: offset for name, offset in found.items() if offset is not None}
    return BlockReading(offsets, size, placed, block.size)


def check_layout(program: Any, block: Block) -> None:
    """Compare the lab's layout of an active block with the driver's. Raises DriverError: they
    disagree; names the first member that lies elsewhere."""
    reading, of_uniforms = read_block(program, block), block.kind == "uniform"
    layout = "std140" if of_uniforms else "std430"
    remedy = f"declare the block layout ({layout}), so that its layout is fixed"
    for name, offset in reading.placed.items():
        theirs = reading.offsets.get(name)
        # A driver may leave out members of storage blocks that have no effect.
        if theirs != offset and (of_uniforms or theirs is not None):
            where = "leaves it out" if theirs is None else f"has it at byte {theirs}"
            raise DriverError(
                f"{block.kind} block {block.name}: {'std140' if of_uniforms else 'glslang'} puts "
                f"{name} at byte {offset}, the driver {where}",
                remedy=remedy,
            )
    if of_uniforms and reading.size < reading.placed_size:
        raise DriverError(
            f"uniform block {block.name} takes {reading.placed_size} bytes, "
            f"the driver says {reading.size}",
            remedy=remedy,
        )


def _find_uniform_offset(program: Any, name: str) -> int | None:
    names = (ctypes.c_char_p * 1)(name.encode())
    pointer = ctypes.cast(names, ctypes.POINTER(ctypes.POINTER(ctypes.c_char)))
    index = (ctypes.c_uint * 1)(GL.GL_INVALID_INDEX)
    GL.glGetUniformIndices(program.glo, 1, pointer, index)
    if index[0] == GL.GL_INVALID_INDEX:
        return None
    offset = np.zeros(1, np.int32)
    GL.glGetActiveUniformsiv(program.glo, 1, index, GL.GL_UNIFORM_OFFSET, offset)
    return int(offset[0])


def _find_storage_offset(program: Any, name: str) -> int | None:
    index = _find_resource(program, GL.GL_BUFFER_VARIABLE, name)
    if index == GL.GL_INVALID_INDEX:
        return None
    return read_resource(program.glo, GL.GL_BUFFER_VARIABLE, index, GL.GL_OFFSET)


def _find_resource(program: Any, interface: int, name: str) -> int:
    return int(GL.glGetProgramResourceIndex(program.glo, interface, name.encode()))
