"""The uniform buffers of one scene on the device, each made once and shared where it is given; and
where the driver itself has the members of a block."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from typing import Any

import numpy as np

from shaderlab.compiler.interface import Block
from shaderlab.errors import DriverError
from shaderlab.model.frame import Array, BlockReading
from shaderlab.model.scene import UniformBuffer

from ..programs import blocks
from ..programs.prepare import PreparedDraw
from .device import Device
from .linking import has_names
from .pyopengl import GL

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
        self._shared = blocks.SharedLayouts()
        self._made: dict[tuple[int, bytes], Any] = {}

    def bind(
        self, program: Any, draw: PreparedDraw, uniforms: Mapping[str, Array]
    ) -> Iterator[str]:
        """Bind a buffer to each uniform block of a program; yields the blocks without any effect.

        Raises:
            CaseError: two programs that share a buffer lay it out differently.
            DriverError: the driver lays a block out differently.
        """
        for point, (name, block) in enumerate(blocks.uniform_blocks(draw.interface).items()):
            # The program is kept, so that no other one gets its identity.
            known = self._active.setdefault(id(program), (program, {}))[1]
            if name not in known:
                known[name] = check_against_driver(program, block)
            if not known[name]:
                yield name
                continue
            GL.glUniformBlockBinding(program.glo, _index(program, block), point)
            buffer = self._buffer(draw.draw.blocks[name], block, blocks.packed(block, uniforms))
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
            offsets = {name: _offset(program, blocks.spelt(block, name)) for name in block.members}
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
