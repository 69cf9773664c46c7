"""Dispatches of compute shaders: their storage buffers and images, and what is left in them."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from shaderlab.compiler.interface import Block
from shaderlab.errors import DriverError
from shaderlab.model.frame import Bindings, BlockReading, Image

from ..programs import blocks, storage
from ..programs.prepare import PreparedDraw
from .bound_images import bound_images, read_images
from .linking import has_names
from .pyopengl import GL

if TYPE_CHECKING:
    from .device import Device

_NONE = 0xFFFFFFFF  # GL_INVALID_INDEX


def has_compute(device: Device) -> bool:
    """Whether a device has compute shaders and storage buffers."""
    return device.version >= 430


def dispatch(
    device: Device, program: Any, draw: PreparedDraw, bindings: Bindings
) -> Mapping[str, Image]:
    """Run a program that is linked and whose uniforms and textures are set.

    Args:
        device: where to run it.
        program: the linked program.
        draw: the dispatch.
        bindings: what its images and the members of its storage blocks hold before.

    Returns:
        What is left in each image and each member that is not `readonly`; of what has no effect
        what it held before.

    Raises:
        DriverError: the driver lays a block out differently.
    """
    known, values = storage.slots(draw.interface), bindings.buffers
    buffers: list[tuple[Any, bytearray, Mapping[str, storage.Slot]]] = []
    with ExitStack() as stack:
        for point, (name, block) in enumerate(storage.storage_blocks(draw.interface).items()):
            members = {slot.name: slot for slot in known.values() if slot.block == name}
            data = storage.packed(block, members, values)
            buffer = device.context.buffer(data)
            stack.callback(buffer.release)
            buffers.append((buffer, data, members))
            if _bind(program, block, point):
                buffer.bind_to_storage_buffer(_point(program, block, point))
        textures = bound_images(device, program, bindings.images, stack)
        GL.glUseProgram(program.glo)
        GL.glDispatchCompute(*draw.draw.groups)
        GL.glMemoryBarrier(GL.GL_BUFFER_UPDATE_BARRIER_BIT | GL.GL_TEXTURE_UPDATE_BARRIER_BIT)
        # Drivers compute when they are made to: a program that hangs, hangs here.
        device.context.finish()
        device.reading()
        changed = read_images(textures, bindings.images)
        left = {n: i for n, i in changed.items() if not draw.interface.uniforms[n].readonly}
        for buffer, data, inside in buffers:
            data[:] = buffer.read()
            left |= {
                name: storage.image_of(slot, storage.unpacked(slot, data, values[name]))
                for name, slot in inside.items()
                if not slot.member.readonly
            }
        return left


def _point(program: Any, block: Block, point: int) -> int:
    """The binding of a block: a module says its own."""
    return point if has_names(program) else block.binding or 0


def _bind(program: Any, block: Block, point: int) -> bool:
    """Give a block its binding; False for one without any effect."""
    if not has_names(program):
        return True
    index = _index(program, GL.GL_SHADER_STORAGE_BLOCK, block.name)
    if index is None:
        return False
    reading = read_storage(program, block)
    for name, placed in reading.placed.items():
        theirs = reading.offsets.get(name, placed)
        if theirs != placed:
            raise DriverError(
                f"storage block {block.name}: glslang puts {name} at byte {placed}, the driver "
                f"has it at byte {theirs}",
                remedy="declare the block layout (std430), so that its layout is fixed",
            )
    GL.glShaderStorageBlockBinding(program.glo, index, point)
    return True


def read_storage(program: Any, block: Block) -> BlockReading:
    """Where the driver has a storage block's members, and where the lab has them."""
    placed = {name: member.offset for name, member in block.members.items()}
    offsets, size = dict(placed), block.size
    if has_names(program):
        index = _index(program, GL.GL_SHADER_STORAGE_BLOCK, block.name)
        size = 0 if index is None else _read(
            program, GL.GL_SHADER_STORAGE_BLOCK, index, GL.GL_BUFFER_DATA_SIZE
        )  # fmt: skip
        offsets = {}
        for name in block.members:
            at = _index(program, GL.GL_BUFFER_VARIABLE, blocks.spelt(block, name))
            if at is not None:
                offsets[name] = _read(program, GL.GL_BUFFER_VARIABLE, at, GL.GL_OFFSET)
    return BlockReading(offsets=offsets, size=size, placed=placed, placed_size=block.size)


def _index(program: Any, interface: int, name: str) -> int | None:
    found = int(GL.glGetProgramResourceIndex(program.glo, interface, name.encode()))
    return None if found == _NONE else found


def _read(program: Any, interface: int, index: int, what: int) -> int:
    wanted, got = (ctypes.c_uint * 1)(what), (ctypes.c_int * 1)()
    GL.glGetProgramResourceiv(program.glo, interface, index, 1, wanted, 1, None, got)
    return int(got[0])
