"""What draws give their shaders: a stage's program, and what its invocations got.

`sample_fragments` takes one draw of a scene; `case_stages` and `changed_stages` go through all
draws of a case.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from shaderlab.compiler.sources import Source
from shaderlab.drivers.programs.prepare import PreparedDraw, Programs
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.needs import CapturedFragments, CapturedVertices
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError, NotInterpretedError, in_file
from shaderlab.model.case import Case
from shaderlab.model.frame import Array, Bindings, Fragments, PassDraw
from shaderlab.model.options import RunOptions

from .batches import (
    InputBatch,
    asks_for_neighbours,
    fragment_batch,
    scatter,
    vertex_batch,
    whole_quads,
)
from .interpreter import Program, load

if TYPE_CHECKING:
    from shaderlab.engine.worker import Worker

    from .answer import Answer, Plan

_MOST_INPUTS = 2048
"""Invocations of a draw that `case_stages` and `changed_stages` take."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Invocations:
    """What some invocations of one stage of a draw got and gave: its inputs by name, built-in ones
    too, a row for every invocation (`each`), what they wrote, by output, as it was read back in the
    attachments' `formats` and their units ("rgba32f" of vertices), and the `pixels`, (count, 2),
    column and row; None of vertices."""

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

    @property
    def batch(self) -> InputBatch:
        """What they got."""
        return InputBatch(self.each, self.bindings, self.count)


@lru_cache(maxsize=64)
def program_of(source: Source) -> Program:
    """A stage's program; see `interpreter.load`."""
    return load(source)


def compare_in_case(
    file: Path,
    files: Mapping[str, Path],
    reverse: bool,
    plan: Plan,
    options: RunOptions,
    worker: Worker,
) -> list[Answer]:
    """An answer on each stage of a case's draws that other files for some of its shaders change, on
    the inputs that the case gives it. `reverse` if those files are the old shaders."""
    from .comparison import compare_programs

    worker.note("drawing the case")
    (found,) = changed_stages(worker.lab(options), worker.case(str(file)), [files])
    answers = []
    for one in found:
        worker.note("interpreting")
        old, new = (one.new, one.old) if reverse else (one.old, one.new)
        with in_file(new.path):
            program = load(new)
        with in_file(old.path):
            answers.append(compare_programs(load(old), program, plan, one.given))
    return answers


def sample_fragments(
    evaluation: Evaluation,
    key: PassDraw,
    most: int | None = None,
    *,
    among: Array | None = None,
    program: Program | None = None,
) -> Invocations:
    """The fragments of a draw that are seen: all, or about `most` of them from all over, with those
    where an input is least and greatest; or those of quads that have a pixel `among` some (count,
    2). Whole quads where the shader depends on its neighbours. `program` is the fragment stage, if
    it is known already. Raises ShaderError, NotInterpretedError: that can't be interpreted;
    DriverError, CaseError: its inputs can't be captured."""
    program = program or program_of(stage_of(evaluation, key, "fragment"))
    captured = evaluation.answer(CapturedFragments(key))
    bindings = evaluation.drawn.bindings[key]
    places = np.flatnonzero(captured.covered)
    if among is not None:
        places = places[_in_quads(captured, among)]
    elif most is not None and len(places) > most:
        places = places[_sample(captured, most, asks_for_neighbours(program, bindings))]
    y, x = np.divmod(places, captured.covered.shape[1])
    inputs = {**captured.inputs, "gl_FragCoord": captured.frag_coord}
    images = {n: i for (name, n), i in evaluation.drawn.images.items() if name == key[0]}
    return Invocations(
        program=program,
        bindings=bindings,
        pixels=np.stack([x, y], axis=-1),
        each={name: values[y, x] for name, values in inputs.items()},
        measured={name: image.values[y, x] for name, image in images.items()},
        formats={name: image.format for name, image in images.items()},
    )


def _sample(captured: Fragments, most: int, whole: bool) -> Array:
    """About `most` of the covered pixels, by their numbers; `whole` quads."""
    places = np.flatnonzero(captured.covered)
    ends: list[int] = []  # the rows in which a component of an input is least or greatest
    for values in captured.inputs.values():
        flat = _at(places, values).reshape(len(places), -1)
        ends += [*flat.argmin(axis=0), *flat.argmax(axis=0)]
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


def _at(places: Array, values: Array) -> Array:
    """A picture's values at the pixels of these numbers, which ascend."""
    flat = values.reshape(-1, *values.shape[2:])
    # Most draws cover everything; then nothing need be copied.
    return flat if len(places) == len(flat) else flat[places]


def stage_of(evaluation: Evaluation, key: PassDraw, stage: str) -> Source:
    """One stage of a draw's program. Raises NotInterpretedError: it is a dispatch."""
    sources = evaluation.programs[key[0]][key[1]].sources
    if sources[0].stage == "compute":
        raise NotInterpretedError("not interpreted: compute stage")
    return next(source for source in sources if source.stage == stage)


@dataclass(frozen=True, eq=False)
class ChangedStage:
    """A stage that other texts make another one, and the inputs that a case's draws give it."""

    old: Source
    new: Source
    given: list[InputBatch] = field(default_factory=list)


def case_stages(lab: SceneRunner, case: Case) -> list[tuple[Source, list[InputBatch]]]:
    """Each stage of a case's draws, once, and the inputs that those give it: those of fragment and
    vertex stages that ran; nothing for other stages, whose inputs can't be captured. Raises
    ShaderlabError: the case can't be drawn, or what a draw gives can't be captured."""
    found: dict[str, tuple[Source, list[InputBatch]]] = {}
    for scene in case.scenes():
        programs = lab.prepare_for_opengl(scene)
        with lab.evaluation(scene, programs) as evaluation:
            for name, draws in programs.items():
                for i, draw in enumerate(draws):
                    for source in draw.sources:
                        if not _is_written_by_lab(source, draw):
                            one = found.setdefault(source.text, (source, []))
                            given = _capture_batch(evaluation, (name, i), source.stage)
                            one[1].extend(g for g in given if g.count)
    return [
        (source, given)
        for source, given in found.values()
        if given or source.stage not in ("vertex", "fragment")
    ]


def changed_stages(
    lab: SceneRunner, case: Case, changes: Sequence[Mapping[str, str | Path]]
) -> list[list[ChangedStage]]:
    """For each change, the stages of the case's draws that it makes other ones, each once;
    `changes` are other texts or files for some shaders, by their names. The case is drawn once for
    all. Raises ShaderError: a shader does not compile, as it is or changed; CaseError: no draw of
    the case uses any of a change's shaders."""
    found: list[dict[tuple[str, str], ChangedStage]] = [{} for _ in changes]
    for scene in case.scenes():
        programs = lab.prepare_for_opengl(scene)
        with lab.evaluation(scene, programs) as evaluation:
            for change, known in zip(changes, found, strict=True):
                others = lab.prepare_for_opengl(scene, change)
                for key, old, new in _differing_sources(programs, others):
                    one = known.setdefault((old.text, new.text), ChangedStage(old, new))
                    given = _capture_batch(evaluation, key, old.stage)
                    one.given.extend(g for g in given if g.count)
    for change, known in zip(changes, found, strict=True):
        if not known:
            raise CaseError(f"no draw uses {', '.join(change)}", file=case.file)
    return [list(known.values()) for known in found]


def _differing_sources(
    programs: Programs, others: Programs
) -> Iterator[tuple[PassDraw, Source, Source]]:
    for name, draws in programs.items():
        for i, draw in enumerate(draws):
            for old, new in zip(draw.sources, others[name][i].sources, strict=True):
                if old.text != new.text and not _is_written_by_lab(old, draw):
                    yield (name, i), old, new


def _is_written_by_lab(source: Source, draw: PreparedDraw) -> bool:
    """Whether a stage is of no interest: the lab has written it."""
    return source.stage == "vertex" and draw.draw.mesh is None


def _capture_batch(evaluation: Evaluation, key: PassDraw, stage: str) -> Iterator[InputBatch]:
    """What a draw gives a stage, if that can be captured."""
    bindings = evaluation.drawn.bindings[key]
    if stage == "vertex":
        vertices = CapturedVertices(key)
        yield vertex_batch(evaluation.answer(vertices), bindings, _MOST_INPUTS)
        del evaluation.answers[vertices]  # of many draws, all are more than fits into memory
    elif stage == "fragment":
        fragments = CapturedFragments(key)
        yield fragment_batch(evaluation.answer(fragments), bindings, _MOST_INPUTS)
        del evaluation.answers[fragments]
