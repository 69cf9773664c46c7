"""A scene's draw as something to interpret: its stage's program, and what that stage got."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from weakref import WeakKeyDictionary

import numpy as np

from shaderlab.compiler.sources import Source
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.needs import CapturedFragments, CapturedVertices
from shaderlab.errors import NotInterpretedError
from shaderlab.model.frame import Array, Bindings, Fragments, PassDraw

from .batches import asks_for_neighbours, scatter, whole_quads
from .interpreter import Program, load


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
    if most is not None and among is None:
        known = _SAMPLES.setdefault(captured, {})
        how = most, asks_for_neighbours(program, bindings)
        seen = known[how] = known.get(how) or _Seen.of(captured, _sample(captured, *how))
    else:
        seen = _Seen.of(captured, None if among is None else _in_quads(captured, among))
    x, y = seen.pixels.T
    images = {n: i for (name, n), i in evaluation.drawn.images.items() if name == key[0]}
    return Invocations(
        program=program,
        each=seen.each,
        bindings=bindings,
        measured={name: image.values[y, x] for name, image in images.items()},
        formats={name: image.format for name, image in images.items()},
        pixels=seen.pixels,
    )


@dataclass(frozen=True, eq=False)
class _Seen:
    """Pixels (count, 2), and what the fragment shader got there."""

    pixels: Array
    each: Mapping[str, Array]

    @classmethod
    def of(cls, captured: Fragments, rows: Array | None) -> _Seen:
        """Those of the covered pixels with these numbers, all by default; to be read only."""
        places = np.flatnonzero(captured.covered)
        at = y, x = np.divmod(places if rows is None else places[rows], captured.covered.shape[1])
        inputs = {**captured.inputs, "gl_FragCoord": captured.frag_coord}
        found = cls(np.stack([x, y], axis=-1), {name: v[at] for name, v in inputs.items()})
        for array in (found.pixels, *found.each.values()):
            array.flags.writeable = False
        return found


# Draws that must get the same share what was captured, and what is taken of it.
_SAMPLES: WeakKeyDictionary[Fragments, dict[tuple[int, bool], _Seen]] = WeakKeyDictionary()


def _sample(captured: Fragments, most: int, whole: bool) -> Array | None:
    """About `most` of the covered pixels, by their numbers; `whole` quads; None for all."""
    places = np.flatnonzero(captured.covered)
    if len(places) <= most:
        return None
    ends = _extremes([_at(places, values) for values in captured.inputs.values()])
    if whole:
        y, x = np.nonzero(captured.covered)
        return whole_quads(x, y, most, ends)
    chosen = np.zeros(len(places), np.bool_)
    chosen[scatter(len(places), most)] = chosen[ends] = True
    return np.flatnonzero(chosen)


def _in_quads(captured: Fragments, among: Array) -> Array:
    """The covered pixels of the quads that have some pixels (count, 2), by their numbers."""
    quads, side = among >> 1, captured.covered.shape[1]
    y, x = np.nonzero(captured.covered)
    cells = (y >> 1) * side + (x >> 1)
    return np.flatnonzero(np.isin(cells, quads[:, 1] * side + quads[:, 0]))


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
