"""Where the device reads attributes and the members of blocks from, as it says itself; and how long
drawing takes."""

from __future__ import annotations

import time
from collections.abc import Mapping

from shaderlab.model.frame import AttributeReading, BlockReading, PassDraw, Timing

from ..programs.blocks import uniform_blocks
from ..programs.module_texts import as_drawn
from .device import Objects
from .drawing import Drawing, vertex_array


def attributes(drawing: Drawing, key: PassDraw) -> Mapping[str, AttributeReading]:
    """As `Session.attributes`."""
    draw = drawing.programs[key[0]][key[1]]
    if draw.draw.mesh is None:
        return {}
    program = drawing.linker.link(as_drawn(draw.draw, draw.texts), draw.sources)
    gl = drawing.device.gl
    with Objects(gl) as own:
        found = vertex_array(own, draw.draw.mesh, program.interface.attributes).readings(gl)
        gl.bindVertexArray(None)
    return found


def block_readings(drawing: Drawing, key: PassDraw) -> Mapping[str, BlockReading]:
    """As `Session.blocks`."""
    draw = drawing.programs[key[0]][key[1]]
    program = drawing.linker.link(as_drawn(draw.draw, draw.texts), draw.sources)
    gl, found = drawing.device.gl, {}
    for name, block in uniform_blocks(draw.interface).items():
        offsets: dict[str, int] = {}
        size = 0
        if name in program.blocks:
            index = program.blocks[name]
            size, offsets = gl.ask_all([
                ("getActiveUniformBlockParameter", program.handle, index,
                 gl.UNIFORM_BLOCK_DATA_SIZE),
                ("offsets", program.handle, index),
            ])  # fmt: skip
        placed = {member.name: member.offset for member in block.members.values()}
        own = {}
        for member in placed:
            # SPIRV-Cross gives each block an instance, so that its members have its name in front.
            for said in (f"{name}.{member}", f"{name}.{member}[0]"):
                if said in offsets:
                    own[member] = offsets[said]
        found[name] = BlockReading(offsets=own, size=size, placed=placed, placed_size=block.size)
    return found


def timed(drawing: Drawing, pass_name: str, repeats: int) -> Timing:
    """How long a pass takes to draw, with all that this takes in Python and on the way to the
    browser. The first time through, when the browser compiles, does not count."""
    prepared = drawing.programs[pass_name]
    seconds, vertices = [], 0
    for draw in prepared:
        mesh = draw.draw.mesh
        count = 3 if mesh is None else mesh.vertices if mesh.indices is None else len(mesh.indices)
        vertices += count * draw.draw.instances
    with drawing.fresh_target(pass_name) as target:
        for turn in range(repeats + 1):
            target.clear()
            start = time.perf_counter()
            for index, draw in enumerate(prepared):
                drawing.render(draw, drawing.bindings[pass_name, index], target)
            drawing.finish()
            if turn:
                seconds.append(time.perf_counter() - start)
    return Timing(draw_calls=len(prepared), vertices=vertices, seconds=tuple(seconds))
