"""What a fragment shader got, by drawing its pass once more: shaders that write their inputs, and
what they wrote put together. No device: the caller draws."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from shaderlab.frame import Array, Fragments
from shaderlab.programs import formats, stages
from shaderlab.programs.prepare import PreparedDraw
from shaderlab.programs.varyings import Piece, assembled

Redraw = Callable[[str, Mapping[str, str]], Mapping[str, Array]]
"""Draws a pass once more, one of its draws with another fragment text, into attachments of these
formats by name; gives what they hold. Its other draws have the texts of `blank`."""


def fragments(draw: PreparedDraw, redraw: Redraw) -> Fragments:
    """What a draw's fragment shader got, at each pixel that it was the last to write.

    The pass's other draws run as well and wipe out what they cover, so `covered` is what is seen
    of the draw in the end. A shader that may keep fragments out is captured a second time keeping
    them all.

    Raises:
        UnsupportedError: the fragment shader has so many outputs that none can be added, and they
            are declared in a way that leaves none out.
    """
    text = draw.text("fragment") or ""
    found = _captured(draw, redraw, keep_all=False)
    if not (stages.may_discard(text) or stages.writes_depth(text)):
        return found
    return replace(found, undiscarded=_captured(draw, redraw, keep_all=True))


def written(text: str, outputs: Mapping[str, str], redraw: Redraw) -> Mapping[str, Array]:
    """See `shaderlab.backends.Session.written`."""
    ending, _ = stages.capture_fragment(text, ())
    images = redraw(ending, {**outputs, stages.COORD: "rgba32f"})
    seen = images[stages.COORD][..., 3:] > 0.0
    return {name: np.where(seen, images[name], 0) for name in outputs}


def blank(draw: PreparedDraw) -> str:
    """The draw's fragment shader, 1/w written as −1: another draw is seen."""
    crowded = len(draw.interface.outputs) + 1 > stages.MOST_OUTPUTS
    unwanted = draw.interface.outputs if crowded else None
    text, _ = stages.capture_fragment(draw.text("fragment") or "", (), unwanted)
    return text.replace(
        f"{stages.COORD} = gl_FragCoord;", f"{stages.COORD} = vec4(0.0, 0.0, 0.0, -1.0);"
    )


def _captured(draw: PreparedDraw, redraw: Redraw, *, keep_all: bool) -> Fragments:
    parts = stages.input_pieces(draw.text("fragment") or "", draw.interface.varyings.values())
    crowded = stages.crowded(draw.interface.outputs)
    room = stages.MOST_OUTPUTS - 1 - (0 if crowded else len(draw.interface.outputs))
    values: dict[Piece, Array] = {}
    for start in range(0, max(len(parts), 1), room):
        group = parts[start : start + room]
        coord, got = _capture_group(draw, redraw, group, crowded, keep_all)
        values.update(got)
    return Fragments(covered=coord[..., 3] > 0.0, frag_coord=coord, inputs=assembled(values))


def _capture_group(
    draw: PreparedDraw, redraw: Redraw, group: Sequence[Piece], crowded: bool, keep_all: bool
) -> tuple[Array, dict[Piece, Array]]:
    """`gl_FragCoord` and some of the inputs."""
    outputs = draw.interface.outputs
    text, captured = stages.capture_fragment(
        draw.text("fragment") or "", group, outputs if crowded else None, keep_all=keep_all
    )
    colors = {n: formats.for_output(v.type) for n, v in outputs.items() if not crowded}
    colors[stages.COORD] = "rgba32f"
    for piece, name in captured.items():
        colors[name] = formats.for_output(stages.padded_type(piece))
    images = redraw(text, colors)
    got = {
        piece: images[name][..., : formats.components_of(piece.type)]
        for piece, name in captured.items()
    }
    return images[stages.COORD], got
