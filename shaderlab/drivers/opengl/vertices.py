"""Meshes on the device: their buffers, and the vertex arrays that read them."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.errors import DriverError
from shaderlab.model.frame import Array, AttributeReading
from shaderlab.model.mesh import Mesh, Placement

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
