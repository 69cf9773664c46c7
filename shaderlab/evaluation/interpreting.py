"""A scene's draw as something to interpret: its stage's program, and what that stage got."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np

from shaderlab.compiler.sources import Source
from shaderlab.equivalence.given import asks_for_neighbours, scattered, whole_quads
from shaderlab.errors import NotInterpretedError
from shaderlab.evaluation.evaluation import Evaluation
from shaderlab.expectations.needs import CapturedFragments, CapturedVertices
from shaderlab.frame import Array, Bindings, PassDraw
from shaderlab.interpreter import Program, load
from shaderlab.lazy_dataclass import dataclass


@dataclass(frozen=True, kw_only=True, eq=False)
class Invocations:
    """What some invocations of one stage of a draw got and gave.

    Attributes:
        program: the stage.
        each: its inputs by name, built-in ones too, a row for every invocation.
        bindings: its uniforms and textures.
        measured: what they wrote, by output, as it was read back; those of other passes' formats
            in the formats' own units.
        formats: the attachments' formats by output; "rgba32f" of vertices.
        pixels: (count, 2), column and row; None of vertices.
    """

    program: Program
    each: Mapping[str, Array]
    bindings: Bindings
    measured: Mapping[str, Array]
    formats: Mapping[str, str]
    pixels: Array | None = None

    @property
    def count(self) -> int:
        """How many invocations there are."""
        return max((len(values) for values in self.each.values()), default=0)


@lru_cache(maxsize=64)
def program_of(source: Source) -> Program:
    """A stage's program; see `interpreter.load`."""
    return load(source)


def fragments(
    evaluation: Evaluation,
    key: PassDraw,
    most: int | None = None,
    *,
    among: Array | None = None,
    program: Program | None = None,
) -> Invocations:
    """The fragments of a draw that are seen: all, or about `most` of them from all over, with those
    where an input is least and greatest; or those of quads that have a pixel `among` some
    (count, 2). Whole quads where the shader depends on its neighbours.

    Args:
        program: the fragment stage, if it is known already.

    Raises:
        ShaderError, NotInterpretedError: the fragment stage can't be interpreted.
        DriverError, CaseError: its inputs can't be captured.
    """
    program = program or program_of(stage_of(evaluation, key, "fragment"))
    captured = evaluation.answer(CapturedFragments(key))
    bindings = evaluation.drawn.bindings[key]
    places = np.flatnonzero(captured.covered)
    rows = np.arange(len(places))
    if most is not None and len(places) > most:
        ends = _extremes([_at(places, values) for values in captured.inputs.values()])
        if asks_for_neighbours(program, bindings):
            y, x = np.nonzero(captured.covered)
            rows = whole_quads(x, y, most, ends)
        else:
            chosen = np.zeros(len(places), np.bool_)
            chosen[scattered(len(places), most)] = chosen[ends] = True
            rows = np.flatnonzero(chosen)
    side = captured.covered.shape[1]
    if among is not None:
        quads = among >> 1
        y, x = np.nonzero(captured.covered)
        rows = np.flatnonzero(np.isin((y >> 1) * side + (x >> 1), quads[:, 1] * side + quads[:, 0]))
    y, x = at = np.divmod(places[rows], side)
    images = {n: i for (name, n), i in evaluation.drawn.images.items() if name == key[0]}
    return Invocations(
        program=program,
        each={
            **{name: values[at] for name, values in captured.inputs.items()},
            "gl_FragCoord": captured.frag_coord[at],
        },
        bindings=bindings,
        measured={name: image.values[at] for name, image in images.items()},
        formats={name: image.format for name, image in images.items()},
        pixels=np.stack([x, y], axis=-1),
    )


def vertices(evaluation: Evaluation, key: PassDraw, most: int | None = None) -> Invocations:
    """The vertices of a draw without a geometry stage, the first `most` of them.

    Raises:
        ShaderError, NotInterpretedError: the vertex stage can't be interpreted.
        DriverError, CaseError: its inputs can't be captured.
    """
    source = stage_of(evaluation, key, "vertex")
    captured = evaluation.answer(CapturedVertices(key))
    return Invocations(
        program=program_of(source),
        each={name: values[:most] for name, values in captured.inputs.items()},
        bindings=evaluation.drawn.bindings[key],
        measured={name: values[:most] for name, values in captured.outputs.items()},
        formats=dict.fromkeys(captured.outputs, "rgba32f"),
    )


def _at(places: Array, values: Array) -> Array:
    """A picture's values at the pixels of these numbers, which ascend."""
    flat = values.reshape(-1, *values.shape[2:])
    # Most draws cover everything; then nothing need be copied.
    return flat if len(places) == len(flat) else flat[places]


def _extremes(inputs: Sequence[Array]) -> list[int]:
    """The rows in which a component of an input is least or greatest."""
    found: list[int] = []
    for values in inputs:
        flat = values.reshape(len(values), -1)
        found += [*flat.argmin(axis=0), *flat.argmax(axis=0)]
    return found


def stage_of(evaluation: Evaluation, key: PassDraw, stage: str) -> Source:
    """One stage of a draw's program.

    Raises:
        NotInterpretedError: it is a dispatch.
    """
    sources = evaluation.programs[key[0]][key[1]].sources
    if sources[0].stage == "compute":
        raise NotInterpretedError("not interpreted: compute stage")
    return next(source for source in sources if source.stage == stage)
