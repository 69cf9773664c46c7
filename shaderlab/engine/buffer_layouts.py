"""Describes how a scene's buffers are laid out, for the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from shaderlab.drivers.programs import blocks
from shaderlab.drivers.programs.prepare import PreparedDraw
from shaderlab.model.mesh import Mesh
from shaderlab.model.records import BufferPart, BufferRecord
from shaderlab.model.scene import UniformBuffer

_MOST = 24


def buffer_records(prepared: Mapping[str, tuple[PreparedDraw, ...]]) -> tuple[BufferRecord, ...]:
    """A scene's uniform buffers, and the vertex buffers of meshes that ask for a layout.

    Each appears once; 24 are described at most.
    """
    return tuple([*_uniform_buffers(prepared), *_vertex_buffers(prepared)][:_MOST])


def _uniform_buffers(prepared: Mapping[str, tuple[PreparedDraw, ...]]) -> Iterator[BufferRecord]:
    users: dict[int, list[tuple[str, UniformBuffer, PreparedDraw]]] = {}
    for draws in prepared.values():
        for draw in draws:
            for name, buffer in draw.draw.blocks.items():
                users.setdefault(id(buffer), []).append((name, buffer, draw))
    for uses in users.values():
        name, _, draw = uses[0]
        interface = draw.compiled.interface
        block = None if interface is None else blocks.uniform_blocks(interface).get(name)
        if block is not None:
            parts = tuple(
                BufferPart(name=member.name, offset=member.offset, stride=member.array_stride)
                for member in block.members.values()
            )
            yield BufferRecord(
                name=name, kind="uniform", size=block.size, used=len(uses), parts=parts
            )


def _vertex_buffers(prepared: Mapping[str, tuple[PreparedDraw, ...]]) -> Iterator[BufferRecord]:
    meshes: dict[int, tuple[str, Mesh, int]] = {}
    for name, draws in prepared.items():
        for draw in draws:
            mesh = draw.draw.mesh
            if mesh is not None and _has_own_layout(mesh):
                first, _, count = meshes.get(id(mesh), (name, mesh, 0))
                meshes[id(mesh)] = (first, mesh, count + 1)
    for name, mesh, count in meshes.values():
        places = mesh.placements()
        for number, pieces in enumerate(mesh.parts()):
            yield BufferRecord(
                name=f"{name}, buffer {number}",
                kind="vertex",
                size=sum(len(piece) for _, piece in pieces),
                used=count,
                parts=tuple(
                    BufferPart(name=attribute, offset=p.offset, stride=p.stride, divisor=p.divisor)
                    for attribute, p in places.items()
                    if p.buffer == number
                ),
                usage=mesh.usage,
                upload=mesh.upload,
            )


def _has_own_layout(mesh: Mesh) -> bool:
    """Whether the mesh asks for another layout than the default, or for instances."""
    default = ("separate", "static_draw", "data")
    return bool(mesh.instance_attributes) or (mesh.layout, mesh.usage, mesh.upload) != default
