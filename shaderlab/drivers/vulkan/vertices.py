"""Meshes on the device: their buffers, and where a pipeline reads each attribute."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Variable
from shaderlab.model.frame import Array, AttributeReading
from shaderlab.model.mesh import PRIMITIVES, Mesh

from ..programs.textures import numpy_type
from .api import Structs, constant, lib
from .device import Buffer, Commands, Resources

_FORMATS = {"f": "SFLOAT", "i": "SINT", "u": "UINT"}
_INDEX_32 = 1


@dataclass(frozen=True)
class VertexLayout:
    """Where a pipeline reads vertices from.

    Attributes:
        streams: for each attribute, the number of its buffer, where it begins there and its stride,
            in bytes, and 1 if it goes on once an instance. Each is a binding of its own, since
            attributes that follow one another in a buffer have strides of their own.
        attributes: of each vector that is read, its location, its stream, its VkFormat and its
            offset from the stream's beginning.
        topology: the VkPrimitiveTopology.
    """

    streams: tuple[tuple[int, int, int, int], ...] = ()
    attributes: tuple[tuple[int, int, int, int], ...] = ()
    topology: int = PRIMITIVES.index("triangles")

    def input_state(self, structs: Structs) -> Any:
        """The structure that tells a pipeline."""
        return structs(
            "PipelineVertexInputStateCreateInfo",
            vertexBindingDescriptionCount=len(self.streams),
            pVertexBindingDescriptions=[
                (number, stride, divisor)
                for number, (_, _, stride, divisor) in enumerate(self.streams)
            ],
            vertexAttributeDescriptionCount=len(self.attributes),
            pVertexAttributeDescriptions=list(self.attributes),
        )


def layout_of(mesh: Mesh | None, declared: Mapping[str, Variable]) -> VertexLayout:
    """The layout of a mesh, made for a vertex stage that declares these inputs."""
    if mesh is None:
        return VertexLayout()
    streams: list[tuple[int, int, int, int]] = []
    attributes: list[tuple[int, int, int, int]] = []
    # Vulkan's first number for a topology is that of points, and so on in the order of PRIMITIVES.
    topology = PRIMITIVES.index(mesh.primitive)
    arrays = _converted(mesh, declared).inputs
    for name, place in mesh.placements().items():
        variable = declared.get(name)
        if variable is None or variable.location is None:
            continue
        array = arrays[name]
        columns = array.shape[2] if array.ndim == 3 else 1
        size = array.shape[1]
        letter = "u" if numpy_type(variable.type) is np.uint32 else array.dtype.kind
        channels = "".join(f"{channel}32" for channel in "RGBA"[:size])
        format = constant(f"FORMAT_{channels}_{_FORMATS[letter]}")
        for column in range(columns):
            offset = column * size * array.itemsize
            attributes.append((variable.location + column, len(streams), format, offset))
        streams.append((place.buffer, place.offset, place.stride, place.divisor))
    return VertexLayout(tuple(streams), tuple(attributes), topology)


@dataclass(frozen=True)
class VertexBuffers:
    """A mesh's buffers on the device; `count` is how many vertices a draw takes."""

    buffers: tuple[Buffer, ...]
    indices: Buffer | None
    count: int

    def draw(self, commands: Commands, layout: VertexLayout, instances: int) -> None:
        """Record the draw call, for a pipeline of this layout."""
        streams = layout.streams
        if streams:
            handles = [self.buffers[buffer].handle for buffer, *_ in streams]
            own = commands.structs.array("VkBuffer", handles)
            starts = commands.structs.array("VkDeviceSize", [offset for _, offset, *_ in streams])
            lib.vkCmdBindVertexBuffers(commands.handle, 0, len(handles), own, starts)
        if self.indices is None:
            lib.vkCmdDraw(commands.handle, self.count, instances, 0, 0)
            return
        lib.vkCmdBindIndexBuffer(commands.handle, self.indices.handle, 0, _INDEX_32)
        lib.vkCmdDrawIndexed(commands.handle, self.count, instances, 0, 0, 0)


def upload(
    resources: Resources, mesh: Mesh | None, declared: Mapping[str, Variable]
) -> VertexBuffers:
    """The buffers of a mesh, or three vertices without attributes."""
    if mesh is None:
        return VertexBuffers((), None, 3)
    parts = _converted(mesh, declared).parts()
    buffers = tuple(
        resources.buffer("vertex_buffer", b"".join(piece for _, piece in own)) for own in parts
    )
    if mesh.indices is None:
        return VertexBuffers(buffers, None, mesh.vertices)
    indices = resources.buffer("index_buffer", mesh.indices.astype(np.uint32))
    return VertexBuffers(buffers, indices, len(mesh.indices))


def readings(layout: VertexLayout, declared: Mapping[str, Variable]) -> dict[str, AttributeReading]:
    """Where a pipeline of this layout reads each attribute."""
    streams = {location: layout.streams[number] for location, number, _, _ in layout.attributes}
    found = {}
    for name, variable in declared.items():
        if variable.location in streams:
            buffer, offset, stride, divisor = streams[variable.location]
            found[name] = AttributeReading(
                buffer=buffer, offset=offset, stride=stride, divisor=divisor
            )
    return found


def _converted(mesh: Mesh, declared: Mapping[str, Variable]) -> Mesh:
    """The mesh with integers made floats where the shader reads floats, as OpenGL converts them."""

    def fitting(given: Mapping[str, Array]) -> dict[str, Array]:
        return {
            name: array.astype(np.float32) if _converts(array, declared.get(name)) else array
            for name, array in given.items()
        }

    kinds = {name: _converts(array, declared.get(name)) for name, array in mesh.inputs.items()}
    if not any(kinds.values()):
        return mesh
    return replace(
        mesh,
        attributes=fitting(mesh.attributes),
        instance_attributes=fitting(mesh.instance_attributes),
    )


def _converts(array: Array, variable: Variable | None) -> bool:
    return (
        variable is not None
        and array.dtype.kind in "iu"
        and numpy_type(variable.type) is np.float32
    )
