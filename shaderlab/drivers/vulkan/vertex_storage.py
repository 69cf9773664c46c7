"""What vertices come out of the last stage before rasterisation, by a storage buffer that the stage
writes to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shaderlab.compiler.module import parse
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Bindings
from shaderlab.model.scene import Target

from ..programs import storing
from ..programs.module_texts import sources_of
from ..programs.prepare import PreparedDraw
from ..programs.varyings import Piece
from ..programs.vertices import corners
from .commands import recording
from .drawing import Drawing
from .memory import Resources
from .modules import modules_of
from .target import RenderTarget

_OUTPUT_VERTICES = 26  # SPIR-V's execution mode for max_vertices
_FEATURE = "vertexPipelineStoresAndAtomics"


def vertex_outputs(
    drawing: Drawing,
    draw: PreparedDraw,
    texts: Mapping[str, str],
    parts: Sequence[Piece],
    bindings: Bindings,
    count: int | None,
) -> Mapping[Piece, Array]:
    """As `PassSession.vertex_outputs`, by a storage buffer.

    Raises:
        UnsupportedError: the device's vertex stages can't write to buffers.
    """
    if _FEATURE not in drawing.device.features:
        raise UnsupportedError(f"capturing vertices: this device has no {_FEATURE}")
    mesh = draw.draw.mesh
    assert mesh is not None
    most, each = 1, mesh.vertices
    if "geometry" in texts:
        module = parse(modules_of(sources_of(draw.texts, draw.sources))["geometry"])
        most = module.modes[_OUTPUT_VERTICES][0]
        each = most * len(corners(mesh))
    program = storing.storing(texts, parts, most)
    words = storing.words_of(parts) * each * draw.draw.instances
    own = {storing.PER_INSTANCE: np.array([each], np.int32)}
    given = replace(bindings, uniforms={**bindings.uniforms, **own})
    with (
        Resources(drawing.device) as resources,
        RenderTarget(drawing.device, Target(), {}, (1, 1)) as target,
    ):
        buffer = resources.buffer("storage_buffer", size=4 * words)
        ready = drawing.ready(
            resources, draw, given, target, texts=program, stored={storing.BLOCK: buffer}
        )
        with recording(drawing.device) as commands:
            target.begin(commands, {})
            ready.record(commands, target.size)
            target.end(commands)
        return storing.restored(parts, buffer.bytes[: 4 * words].copy().view(np.uint32))
