"""What the device counts while it draws, how long drawing takes, and where it reads from."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import AttributeReading, BlockReading, PassDraw, Timing

from ..programs.blocks import uniform_blocks
from .api import Structs, check, constant, ffi, lib
from .device import Commands, Resources, recording
from .drawing import Drawing
from .vertices import layout_of, readings

# Source: Vulkan 1.3 Specification, chapter Queries.
_STATISTICS = {
    "vertices_submitted": "INPUT_ASSEMBLY_VERTICES",
    "primitives_submitted": "INPUT_ASSEMBLY_PRIMITIVES",
    "vertex_shader_invocations": "VERTEX_SHADER_INVOCATIONS",
    "geometry_shader_invocations": "GEOMETRY_SHADER_INVOCATIONS",
    "geometry_primitives_emitted": "GEOMETRY_SHADER_PRIMITIVES",
    "clipping_input_primitives": "CLIPPING_INVOCATIONS",
    "clipping_output_primitives": "CLIPPING_PRIMITIVES",
    "fragment_shader_invocations": "FRAGMENT_SHADER_INVOCATIONS",
}
_OCCLUSION, _PIPELINE, _GENERATED = 0, 1, 1000382000
_PRECISE = 1
_WHOLE_AND_WAITING = 1 | 2


def counted(drawing: Drawing, key: PassDraw, counter: str) -> int:
    """What one draw makes the device count, its pass drawn once more.

    Raises:
        UnsupportedError: the device does not count this.
    """
    kind, feature, bits = _OCCLUSION, "occlusionQueryPrecise", 0
    if counter == "primitives_generated":
        kind, feature = _GENERATED, "primitivesGeneratedQuery"
    elif counter in _STATISTICS:
        kind, feature = _PIPELINE, "pipelineStatisticsQuery"
        bits = constant(f"QUERY_PIPELINE_STATISTIC_{_STATISTICS[counter]}_BIT")
    if feature not in drawing.device.features:
        raise UnsupportedError(f"counting {counter}: this device has no {feature}")
    precise = _PRECISE if kind == _OCCLUSION else 0
    with Resources(drawing.device) as own, drawing.fresh_target(key[0]) as target:
        pool = own.create("QueryPool", Structs()(
            "QueryPoolCreateInfo", queryType=kind, queryCount=1, pipelineStatistics=bits
        ))  # fmt: skip

        def around(commands: Commands, draw: Callable[[], None]) -> None:
            lib.vkCmdResetQueryPool(commands.handle, pool, 0, 1)
            lib.vkCmdBeginQuery(commands.handle, pool, 0, precise)
            draw()
            lib.vkCmdEndQuery(commands.handle, pool, 0)

        for index, draw in enumerate(drawing.programs[key[0]][: key[1] + 1]):
            drawing.render(
                draw, drawing.bindings[key[0], index], target,
                around=around if index == key[1] else None,
            )  # fmt: skip
        found = ffi.new("uint64_t *")
        check(lib.vkGetQueryPoolResults(
            drawing.device.handle, pool, 0, 1, 8, found, 8, _WHOLE_AND_WAITING
        ), f"counting {counter}")  # fmt: skip
        return int(found[0])


def timed(drawing: Drawing, pass_name: str, repeats: int) -> Timing:
    """How long a pass takes to draw, from its first command until the device has finished.

    Pipelines, buffers and targets are made beforehand. The first time through, when drivers
    compile, does not count.
    """
    prepared = drawing.programs[pass_name]
    seconds = []
    with Resources(drawing.device) as own, drawing.fresh_target(pass_name) as target:
        ready = [
            drawing.ready(own, draw, drawing.bindings[pass_name, index], target)
            for index, draw in enumerate(prepared)
        ]
        vertices = sum(each.vertices.count * each.instances for each in ready)
        for turn in range(repeats + 1):
            target.clear()
            start = time.perf_counter()
            with recording(drawing.device) as commands:
                for each in ready:
                    target.begin(commands, each.locations, srgb=each.state.srgb)
                    each.record(commands, target.size)
                    target.end(commands)
            if turn:
                seconds.append(time.perf_counter() - start)
    return Timing(draw_calls=len(prepared), vertices=vertices, seconds=tuple(seconds))


def attributes(drawing: Drawing, key: PassDraw) -> Mapping[str, AttributeReading]:
    """Where the pipeline of a draw of a mesh reads each attribute: Vulkan has no query for it, but
    takes it as one structure, which this reads."""
    draw = drawing.programs[key[0]][key[1]]
    if draw.draw.mesh is None:
        return {}
    declared = drawing.program(draw, draw.texts).attributes
    return readings(layout_of(draw.draw.mesh, declared), declared)


def block_readings(drawing: Drawing, key: PassDraw) -> Mapping[str, BlockReading]:
    """Where the draw's modules have the members of each uniform block: a driver reads them where
    the module says."""
    draw = drawing.programs[key[0]][key[1]]
    bindings = drawing.program(draw, draw.texts).bindings
    found = {}
    for name, placed in uniform_blocks(draw.interface).items():
        block = bindings[name].block if name in bindings else None
        found[name] = BlockReading(
            offsets={m.name: m.offset for m in block.members.values()} if block else {},
            size=block.size if block else 0,
            placed={m.name: m.offset for m in placed.members.values()},
            placed_size=placed.size,
        )
    return found
