"""The uniform buffers of one scene on the device: each made once, and shared where it is given."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from typing import Any

from shaderlab.errors import CaseError
from shaderlab.frame import Array
from shaderlab.gl import blocks
from shaderlab.gl.device import Device
from shaderlab.gl.prepare import PreparedDraw
from shaderlab.glsl.interface import Block
from shaderlab.glsl.layout import Slot
from shaderlab.model import UniformBuffer


class UniformBuffers:
    """Makes buffers for UniformBuffers as they are asked for, and binds them.

    Args:
        device: where to make them.
        stack: gives them back in the end.
    """

    def __init__(self, device: Device, stack: ExitStack) -> None:
        self._device = device
        self._stack = stack
        self._active: dict[int, tuple[Any, dict[str, bool]]] = {}
        self._shared: dict[int, tuple[UniformBuffer, Block, Mapping[str, Slot]]] = {}
        self._made: dict[tuple[int, bytes], Any] = {}

    def bind(
        self, program: Any, draw: PreparedDraw, uniforms: Mapping[str, Array]
    ) -> Iterator[str]:
        """Bind a buffer to each uniform block of a program; gives the blocks without any effect.

        Raises:
            CaseError: two programs that share a buffer lay it out differently.
            DriverError: the driver lays a block out differently.
        """
        for point, (name, block) in enumerate(blocks.uniform_blocks(draw.interface).items()):
            # The program is kept, so that no other one gets its identity.
            known = self._active.setdefault(id(program), (program, {}))[1]
            if name not in known:
                known[name] = blocks.check_against_driver(program, block)
            if not known[name]:
                yield name
                continue
            program[name].binding = point
            buffer = self._buffer(draw.draw.blocks[name], block, blocks.packed(block, uniforms))
            buffer.bind_to_uniform_block(point)

    def _buffer(self, source: UniformBuffer, block: Block, data: bytes) -> Any:
        """The one buffer of a UniformBuffer; a probe with other values gets one of its own."""
        places = blocks.layout_of(block).slots
        _, first, known = self._shared.setdefault(id(source), (source, block, places))
        for name in (*places, *known):
            if places.get(name) != known.get(name):
                raise CaseError(
                    f"one UniformBuffer serves the blocks {first.name} and {block.name}, "
                    f"but {name} does not lie at the same place in both",
                    remedy="declare both blocks alike, or give each a UniformBuffer of its own",
                )
        key = (id(source), data)
        if key not in self._made:
            self._made[key] = self._device.context.buffer(data)
            self._stack.callback(self._made[key].release)
        return self._made[key]
