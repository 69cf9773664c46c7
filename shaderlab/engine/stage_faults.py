"""Where a draw leaves what its own stages allow, or the clearing before it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from shaderlab.analysis.interpreter import Bands, interpret
from shaderlab.errors import ShaderlabError
from shaderlab.files import display_path
from shaderlab.model.frame import Array, Fragments, PassDraw
from shaderlab.model.observations import Fault

from . import interpreting
from .evaluation import Evaluation
from .explaining import explain
from .judging.formats import FLOAT_FORMATS, stored

_VERTICES = 64  # that are interpreted of a draw
_BLOCKS = 10_000


def of_vertices(evaluation: Evaluation, key: PassDraw) -> Iterator[Fault]:
    """The first vertex whose outputs are not in the vertex stage's bands.

    Raises:
        ShaderlabError: the stage can't be captured or interpreted.
    """
    given = interpreting.vertices(evaluation, key, _VERTICES)
    for name, band in _bands(given).items():
        if name not in given.measured or not hasattr(band, "contains"):
            continue
        measured = given.measured[name]
        count = min(measured.shape[-1], band.shape[-1])
        inside = np.asarray(band[..., :count].contains(measured[..., :count]))
        if not inside.all():
            row = int(np.argwhere(~inside)[0][0])
            file = display_path(evaluation.programs[key[0]][key[1]].sources[0].path)
            text = f"{name} of vertex {row} is ({_listed(measured[row])}), which {file} rules out"
            yield Fault(kind="vertex stage", text=text, file=file)
            return


def of_fragments(
    evaluation: Evaluation, key: PassDraw, output: str, pixels: Array, refused: list[str]
) -> Iterator[Fault]:
    """The pixels, among these (n, 2), at which a draw's output is not in its fragment stage's band.

    Adds to `refused` why a fault's statement was not found.

    Raises:
        ShaderlabError: the stage can't be captured or interpreted.
    """
    state = evaluation.programs[key[0]][key[1]].draw.state
    if state.blend or state.srgb:
        return
    given = interpreting.fragments(evaluation, key, among=pixels)
    band, measured = _bands(given).get(output), given.measured.get(output)
    if band is None or measured is None or isinstance(band, tuple):
        return
    count = min(measured.shape[-1], band.shape[-1])
    allowed = stored(band[..., :count], given.formats[output], count)
    inside = np.asarray(allowed.contains(measured[..., :count])).all(axis=-1)
    assert given.pixels is not None
    wanted = {tuple(map(int, pixel)) for pixel in pixels}
    for row in np.flatnonzero(~inside):
        x, y = map(int, given.pixels[row])
        if (x, y) in wanted:
            yield _located(evaluation, key, output, (x, y), measured[row], refused)


def of_clearing(
    evaluation: Evaluation,
    pass_name: str,
    output: str,
    captures: Collection[Fragments],
    pixels: Sequence[tuple[int, int]],
) -> Iterator[Fault]:
    """Pixels that no draw touches, and that have another value than they were cleared to."""
    image = evaluation.drawn.images[pass_name, output]
    description = evaluation.scene.find_pass(pass_name)
    target = description.target
    if image.format not in FLOAT_FORMATS or description.onto or not captures or target.samples:
        return
    if target.colors is not None and output not in target.colors:
        return
    wanted = np.array(target.clear, np.float32)
    for x, y in pixels:
        # Another draw, or one that was blended or discarded, may have been here.
        if any(captured.frag_coord[y, x, 3] != 0.0 for captured in captures):
            continue
        got = image.values[y, x]
        if not np.array_equal(got, wanted[: len(got)]):
            text = f"pixel ({x}, {y}) is ({_listed(got)}), and nothing was drawn there"
            yield Fault(kind="clear", text=text, pixel=(x, y))


def _bands(given: interpreting.Invocations) -> Mapping[str, Any]:
    return interpret(
        given.program, given.each, given.bindings, Bands(), count=given.count, blocks=_BLOCKS
    ).outputs


def _located(
    evaluation: Evaluation,
    key: PassDraw,
    output: str,
    pixel: tuple[int, int],
    measured: Array,
    refused: list[str],
) -> Fault:
    """The first statement at which the driver leaves the band, if it tells."""
    source = evaluation.programs[key[0]][key[1]].draw.fragment
    text = f"{output} is ({_listed(measured)}) at pixel {pixel}, which {source} rules out"
    try:
        steps = explain(evaluation, key, pixel).steps
    except ShaderlabError as error:
        refused.append(error.message)
        steps = ()
    for step in steps:
        if step.by_driver and not step.inside:
            file = display_path(step.file)
            text = f"{text}; first at {display_path(step.file, step.line)}: {step.name}"
            return Fault(kind="fragment stage", text=text, pixel=pixel, file=file, line=step.line)
    return Fault(kind="fragment stage", text=text, pixel=pixel)


def _listed(values: Array) -> str:
    return ", ".join(f"{float(v):.6g}" for v in values)
