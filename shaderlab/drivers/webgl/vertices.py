"""Meshes on the device: their buffers, and the vertex arrays that read them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from shaderlab.compiler.interface import Variable
from shaderlab.model.frame import AttributeReading
from shaderlab.model.mesh import Mesh

from ..programs.formats import numpy_type
from .calls import Calls, Object, Objects

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
        """Issue the draw call."""
        gl.bindVertexArray(self.handle)
        mode = getattr(gl, self.primitive.upper())
        if self.indexed:
            gl.drawElementsInstanced(mode, self.count, gl.UNSIGNED_INT, 0, instances)
        else:
            gl.drawArraysInstanced(mode, 0, self.count, instances)

    def readings(self, gl: Calls) -> dict[str, AttributeReading]:
        """What WebGL2 itself says of each attribute's place."""
        gl.bindVertexArray(self.handle)
        found = {}
        for name, (at, buffer) in self.locations.items():
            offset, stride, divisor = gl.ask_all([
                ("getVertexAttribOffset", at, gl.VERTEX_ATTRIB_ARRAY_POINTER),
                ("getVertexAttrib", at, gl.VERTEX_ATTRIB_ARRAY_STRIDE),
                ("getVertexAttrib", at, gl.VERTEX_ATTRIB_ARRAY_DIVISOR),
            ])  # fmt: skip
            found[name] = AttributeReading(
                buffer=buffer, offset=offset, stride=stride, divisor=divisor
            )
        return found


def vertex_array(own: Objects, mesh: Mesh | None, declared: Mapping[str, Variable]) -> VertexArray:
    """A vertex array of a mesh for a vertex stage that declares these inputs, or one of three
    vertices without attributes."""
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
