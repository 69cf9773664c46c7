"""A draw that is ready: its program, its pipeline and all that it reads are on the device."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from shaderlab.model.state import State

from .. import Size
from . import state as fixed
from .api import NULL, lib
from .commands import Commands
from .program import Layout, Program
from .vertices import VertexBuffers

_GRAPHICS = 0


@dataclass(frozen=True)
class Ready:
    """A draw whose program, pipeline and data are on the device."""

    program: Program
    layout: Layout
    locations: Mapping[int, str]
    state: State
    vertices: VertexBuffers
    instances: int
    descriptors: Any

    def record(self, commands: Commands, size: Size) -> None:
        """Record the draw, between a target's `begin` and its `end`."""
        structs, handle = commands.structs, commands.handle
        box, scissor = fixed.viewport(self.state, size)
        near, far = self.state.depth_range
        lib.vkCmdBindPipeline(handle, _GRAPHICS, self.program.pipeline(self.layout))
        lib.vkCmdSetViewport(handle, 0, 1, structs(
            "Viewport", x=box[0], y=box[1], width=box[2], height=box[3], minDepth=near, maxDepth=far
        ))  # fmt: skip
        lib.vkCmdSetScissor(handle, 0, 1, structs(
            "Rect2D", offset=scissor[:2], extent=scissor[2:]
        ))  # fmt: skip
        if self.descriptors != NULL:
            own = structs.array("VkDescriptorSet", [self.descriptors])
            lib.vkCmdBindDescriptorSets(handle, _GRAPHICS, self.program.layout, 0, 1, own, 0, NULL)
        if min(box[2:]) > 0:
            self.vertices.draw(commands, self.layout.vertices, self.instances)
