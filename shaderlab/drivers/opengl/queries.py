"""What the driver counts while it draws, how long drawing takes, and where it reads from."""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import AttributeReading, BlockReading, PassDraw, Timing

from ..programs.stages import PREFIX
from . import state
from .bindings import read_block
from .device import GL, named
from .drawing import Drawing, drain_errors, read_storage, submit
from .linking import output_locations, uniform_location
from .vertices import read_layout

# Source: OpenGL 4.6 core profile specification, tables 4.1 and 4.2; ARB_pipeline_statistics_query.
_SPELT = {"geometry_primitives_emitted": "geometry_shader_primitives_emitted"}
_ALWAYS = ("samples_passed", "primitives_generated")
_STATISTICS = "GL_ARB_pipeline_statistics_query"


def counted(drawing: Drawing, key: PassDraw, counter: str) -> int:
    """What one draw makes the driver count, its pass drawn once more.

    Raises:
        UnsupportedError: the driver does not count this.
    """
    device = drawing.device
    if counter not in _ALWAYS and _STATISTICS not in device.context.extensions:
        raise UnsupportedError(f"counting {counter}: the driver has no {_STATISTICS}")
    made, what = np.atleast_1d(GL.glGenQueries(1)), named(_SPELT.get(counter, counter))
    try:
        with drawing.fresh_target(key[0]) as target:
            for index, draw in enumerate(drawing.programs[key[0]][: key[1] + 1]):
                program, vao = drawing.ready(draw, drawing.bindings[key[0], index], target)
                if index == key[1]:
                    GL.glBeginQuery(what, made[0])
                submit(vao, program, draw)
            GL.glEndQuery(what)
            result = int(GL.glGetQueryObjectuiv(made[0], GL.GL_QUERY_RESULT))
    finally:
        GL.glDeleteQueries(1, made)
        drain_errors()
    return result


def timed(drawing: Drawing, pass_name: str, repeats: int) -> Timing:
    """How long a pass takes to draw, from its first call until the driver has finished.

    Programs, buffers and targets are made beforehand. The first time through, when drivers compile,
    does not count.
    """
    prepared = drawing.programs[pass_name]
    context = drawing.device.context
    seconds = []
    with drawing.fresh_target(pass_name) as target:
        ready = [
            (draw, *drawing.ready(draw, drawing.bindings[pass_name, index], target))
            for index, draw in enumerate(prepared)
        ]
        locations = [output_locations(program, target.colors) for _, program, _ in ready]
        vertices = sum(vao.count * draw.draw.instances for draw, _, vao in ready)
        for turn in range(repeats + 1):
            target.clear()
            context.finish()
            start = time.perf_counter()
            for index, (draw, program, vao) in enumerate(ready):
                target.bind(locations[index])
                state.apply(draw.draw.state, target.size, drawing.device.version)
                drawing.use(program, draw, drawing.bindings[pass_name, index])
                submit(vao, program, draw)
            context.finish()
            if turn:
                seconds.append(time.perf_counter() - start)
    drain_errors()
    return Timing(draw_calls=len(prepared), vertices=vertices, seconds=tuple(seconds))


def attributes(drawing: Drawing, key: PassDraw) -> Mapping[str, AttributeReading]:
    """Where OpenGL reads each attribute of a draw of a mesh."""
    draw = drawing.programs[key[0]][key[1]]
    if draw.draw.mesh is None:
        return {}
    with drawing.fresh_target(key[0]) as target:
        program, vao = drawing.ready(draw, drawing.bindings[key], target)
        return read_layout(program, vao, draw.draw.mesh)


def block_readings(drawing: Drawing, key: PassDraw) -> dict[str, BlockReading]:
    """Where the driver has the members of each uniform or storage block of a draw's program."""
    draw = drawing.programs[key[0]][key[1]]
    program = drawing.linker.link(draw.texts)
    return {
        name: (read_storage if block.kind == "storage" else read_block)(program, block)
        for name, block in draw.interface.blocks.items()
    }


def locations(drawing: Drawing, key: PassDraw) -> dict[str, int]:
    """Where the driver put each uniform that a draw's program declares, samplers too; −1 for one
    that it left out."""
    draw = drawing.programs[key[0]][key[1]]
    program = drawing.linker.link(draw.texts)
    return {
        name: uniform_location(program, name)
        for name in draw.interface.uniforms
        if not name.startswith(PREFIX)
    }
