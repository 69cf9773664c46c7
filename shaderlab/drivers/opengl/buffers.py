"""Buffers on the device: meshes and the vertex arrays that read them, uniform blocks, storage
blocks."""

from __future__ import annotations

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
from .device import GL, Device, named
from .linking import has_names

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
        """Delete it."""
        with self._device.unchecked():
            GL.glDeleteBuffers(1, np.array([self.glo], np.uint32))


@dataclass(frozen=True)
class VertexArray:
    """A vertex array with the buffers that it reads, for one program; `count` is how many vertices
    a draw takes."""

    made: Any
    program: Any
    count: int
    buffers: tuple[DeviceBuffer, ...] = ()
    indices: Any = None

    def render(self, mode: int, *, instances: int = 1) -> None:
        """Issue the draw call."""
        GL.glUseProgram(self.program.glo)
        GL.glBindVertexArray(self.made.glo)
        if self.indices is None:
            GL.glDrawArraysInstanced(mode, 0, self.count, instances)
        else:
            kind = _INDICES[self.indices.size // self.count]
            GL.glDrawElementsInstanced(mode, self.count, kind, ctypes.c_void_p(0), instances)


def vertex_array(device: Device, program: Any, mesh: Mesh | None) -> VertexArray:
    """A vertex array of `mesh` for `program`, or one of three vertices without attributes.

    Raises:
        DriverError: a buffer can't be mapped.
    """
    context = device.context
    # moderngl makes and deletes it; a program of modules is none of moderngl's.
    owner = program if has_names(program) else device.any_program
    if mesh is None:
        return VertexArray(context.vertex_array(owner, []), program, 3)
    indices = None if mesh.indices is None else context.buffer(mesh.indices)
    size = 4 if mesh.indices is None else mesh.indices.itemsize
    made = context.vertex_array(owner, [], index_buffer=indices, index_element_size=size)
    buffers = tuple(_filled(device, parts, mesh) for parts in mesh.parts())
    for name, place in mesh.placements().items():
        member = program.get(name, None)
        if member is not None:  # else it is declared, but the driver found that it has no effect
            _point(made.glo, buffers[place.buffer].glo, member, mesh.inputs[name], place)
    count = mesh.vertices if mesh.indices is None else len(mesh.indices)
    return VertexArray(made, program, count, buffers, indices)


def read_layout(program: Any, vao: VertexArray, mesh: Mesh) -> dict[str, AttributeReading]:
    """What OpenGL itself says of each attribute's place; those without effect are left out."""
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
        found[name] = AttributeReading(
            buffer=names.index(buffer), offset=pointer.value or 0, stride=stride, divisor=divisor
        )
    GL.glBindVertexArray(0)
    return found


def _filled(device: Device, parts: list[tuple[int, bytes]], mesh: Mesh) -> DeviceBuffer:
    """One buffer with these pieces, made and written as the mesh asks for."""
    whole = b"".join(piece for _, piece in parts)
    buffer = DeviceBuffer(device)
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, buffer.glo)
    given = whole if mesh.upload == "data" and whole else None
    GL.glBufferData(GL.GL_ARRAY_BUFFER, max(len(whole), 1), given, named(mesh.usage))
    if mesh.upload == "sub_data":
        for offset, piece in parts:
            GL.glBufferSubData(GL.GL_ARRAY_BUFFER, offset, len(piece), piece)
    elif mesh.upload == "map" and whole:
        write_mapped(GL.GL_ARRAY_BUFFER, whole)
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, 0)
    return buffer


def _point(vao: int, buffer: int, member: Any, array: Array, place: Placement) -> None:
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
    """Fill the buffer that is bound to a target.

    Raises:
        DriverError: it can't be mapped, or its contents are lost.
    """
    address = GL.glMapBufferRange(target, 0, len(whole), GL.GL_MAP_WRITE_BIT)
    if not address:
        raise DriverError(f"the driver does not map a buffer of {len(whole)} bytes")
    ctypes.memmove(address, whole, len(whole))
    if not GL.glUnmapBuffer(target):
        raise DriverError("the driver lost a buffer's contents while it was mapped")


_NONE = 0xFFFFFFFF  # GL_INVALID_INDEX


class UniformBuffers:
    """Makes each buffer when it is first bound.

    Args:
        device: where to make them.
        stack: releases them in the end.
    """

    def __init__(self, device: Device, stack: ExitStack) -> None:
        self._device = device
        self._stack = stack
        self._active: dict[int, tuple[Any, dict[str, bool]]] = {}
        self._shared = bind.SharedLayouts()
        self._made: dict[tuple[int, bytes], Any] = {}

    def bind(
        self, program: Any, draw: PreparedDraw, uniforms: Mapping[str, Array]
    ) -> Iterator[str]:
        """Bind a buffer to each uniform block of a program; yields the blocks without any effect.

        Raises:
            CaseError: two programs that share a buffer lay it out differently.
            DriverError: the driver lays a block out differently.
        """
        for point, (name, block) in enumerate(bind.uniform_blocks(draw.interface).items()):
            # The program is kept, so that no other one gets its identity.
            known = self._active.setdefault(id(program), (program, {}))[1]
            if name not in known:
                known[name] = check_against_driver(program, block)
            if not known[name]:
                yield name
                continue
            GL.glUniformBlockBinding(program.glo, _index(program, block), point)
            buffer = self._buffer(draw.draw.blocks[name], block, bind.pack_block(block, uniforms))
            buffer.bind_to_uniform_block(point)

    def _buffer(self, source: UniformBuffer, block: Block, data: bytes) -> Any:
        """The one buffer of a UniformBuffer; a probe with other values gets one of its own."""
        self._shared.check(source, block)
        key = (id(source), data)
        if key not in self._made:
            self._made[key] = self._device.context.buffer(data)
            self._stack.callback(self._made[key].release)
        return self._made[key]


def read_block(program: Any, block: Block) -> BlockReading:
    """Where the driver has a block's members, and where the lab has them."""
    size = np.zeros(1, np.int32)
    offsets: dict[str, int | None] = {}
    index = _index(program, block)
    if index != _NONE:
        GL.glGetActiveUniformBlockiv(program.glo, index, GL.GL_UNIFORM_BLOCK_DATA_SIZE, size)
        if not has_names(program):  # the module itself says where members lie
            offsets = {name: member.offset for name, member in block.members.items()}
        else:
            offsets = {
                name: _offset(program, bind.member_name(block, name)) for name in block.members
            }
    return BlockReading(
        offsets={name: at for name, at in offsets.items() if at is not None},
        size=int(size[0]),
        placed={name: member.offset for name, member in block.members.items()},
        placed_size=block.size,
    )


def _index(program: Any, block: Block) -> int:
    """The block's index in a program, _NONE where it has no effect."""
    if not has_names(program):
        found: int | None = program.block(block.name)
        return _NONE if found is None else found
    return int(GL.glGetUniformBlockIndex(program.glo, block.name.encode()))


def check_against_driver(program: Any, block: Block) -> bool:
    """Compare the lab's layout of a block with the driver's; False if the block has no effect.

    Raises:
        DriverError: they disagree; names the first member that lies elsewhere.
    """
    reading = read_block(program, block)
    if not reading.size:
        return False
    remedy = "declare the block layout (std140), so that its layout is fixed"
    for name, offset in reading.placed.items():
        theirs = reading.offsets.get(name)
        if theirs != offset:
            where = "leaves it out" if theirs is None else f"has it at byte {theirs}"
            raise DriverError(
                f"uniform block {block.name}: std140 puts {name} at byte {offset}, "
                f"the driver {where}",
                remedy=remedy,
            )
    if reading.size < reading.placed_size:
        raise DriverError(
            f"uniform block {block.name} takes {reading.placed_size} bytes, "
            f"the driver says {reading.size}",
            remedy=remedy,
        )
    return True


def _offset(program: Any, name: str) -> int | None:
    names = (ctypes.c_char_p * 1)(name.encode())
    pointer = ctypes.cast(names, ctypes.POINTER(ctypes.POINTER(ctypes.c_char)))
    index = (ctypes.c_uint * 1)(_NONE)
    GL.glGetUniformIndices(program.glo, 1, pointer, index)
    if index[0] == _NONE:
        return None
    found = np.zeros(1, np.int32)
    GL.glGetActiveUniformsiv(program.glo, 1, index, GL.GL_UNIFORM_OFFSET, found)
    return int(found[0])


def read_storage(program: Any, block: Block) -> BlockReading:
    """Where the driver has a storage block's members, and where the lab has them."""
    placed = {name: member.offset for name, member in block.members.items()}
    offsets, size = dict(placed), block.size
    if has_names(program):
        index = resource_index(program, GL.GL_SHADER_STORAGE_BLOCK, block.name)
        size = 0 if index is None else _read(
            program, GL.GL_SHADER_STORAGE_BLOCK, index, GL.GL_BUFFER_DATA_SIZE
        )  # fmt: skip
        offsets = {}
        for name in block.members:
            at = resource_index(program, GL.GL_BUFFER_VARIABLE, bind.member_name(block, name))
            if at is not None:
                offsets[name] = _read(program, GL.GL_BUFFER_VARIABLE, at, GL.GL_OFFSET)
    return BlockReading(offsets=offsets, size=size, placed=placed, placed_size=block.size)


def resource_index(program: Any, interface: int, name: str) -> int | None:
    found = int(GL.glGetProgramResourceIndex(program.glo, interface, name.encode()))
    return None if found == _NONE else found


def _read(program: Any, interface: int, index: int, what: int) -> int:
    wanted, got = (ctypes.c_uint * 1)(what), (ctypes.c_int * 1)()
    GL.glGetProgramResourceiv(program.glo, interface, index, 1, wanted, 1, None, got)
    return int(got[0])
