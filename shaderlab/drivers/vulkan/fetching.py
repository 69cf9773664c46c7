"""Reading texels by a shader, where an image can't be copied as it is: single samples, and blocks
that the device decodes."""

from __future__ import annotations

from typing import Any

from shaderlab.model.frame import Array
from shaderlab.model.scene import Target
from shaderlab.model.state import State

from ..attachments import COVERING
from .api import Structs
from .commands import recording
from .descriptors import DEFAULT_BLOCK, BoundImage, new_set
from .linking import Linker
from .memory import Resources
from .program import Layout
from .ready import Ready
from .target import RenderTarget
from .vertices import VertexBuffers, VertexLayout

_FETCH = """#version 330 core
uniform sampler{kind} texels;
uniform int number;
out vec4 color;
void main() {{ color = texelFetch(texels, ivec2(gl_FragCoord.xy), number); }}
"""


def fetched(
    linker: Linker, view: Any, kind: str, number: int, size: tuple[int, int], word: str
) -> Array:
    """One sample ("2DMS"), or one level ("2D"), of a float or normalised texture.

    Args:
        linker: makes the program.
        view: of the texture.
        kind: as in `Texels.kind`.
        number: of the sample or of the level.
        size: (width, height) in texels.
        word: the format to read them in.

    Returns:
        (height, width, channels)
    """
    texts = {"vertex": COVERING, "fragment": _FETCH.format(kind=kind)}
    program = linker.link(texts)
    colors = {"color": word}
    with Resources(linker.device) as own, RenderTarget(linker.device, Target(), colors, size) as to:
        sampler = own.create("Sampler", Structs()("SamplerCreateInfo", maxLod=1000.0))
        buffer = own.buffer("uniform_buffer", number.to_bytes(16, "little"))
        bound = new_set(
            own, program.set_layout, program.bindings, {DEFAULT_BLOCK: buffer.handle},
            {"texels": BoundImage(view, sampler)},
        )  # fmt: skip
        layout = Layout(VertexLayout(), ((0, word),), "", 1, State())
        ready = Ready(program, layout, {0: "color"}, State(), VertexBuffers((), None, 3), 1, bound)
        with recording(linker.device) as commands:
            to.begin(commands, ready.locations)
            ready.record(commands, size)
            to.end(commands)
        return to.read("color").values
