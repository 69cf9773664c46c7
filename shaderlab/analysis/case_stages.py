"""What a case's draws give its shaders; and with other texts, the programs that become others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from shaderlab.compiler.sources import Source
from shaderlab.drivers.programs.prepare import PreparedDraw, Programs
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.needs import CapturedFragments, CapturedVertices
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError
from shaderlab.model.case import Case
from shaderlab.model.frame import PassDraw

from .batches import InputBatch, fragment_batch, vertex_batch

_MOST = 2048  # invocations of a draw


@dataclass(frozen=True, eq=False)
class Rewritten:
    """A stage that other texts make another one, and the inputs that a case's draws give it."""

    old: Source
    new: Source
    given: list[InputBatch] = field(default_factory=list)


def stages(lab: SceneRunner, case: Case) -> list[tuple[Source, list[InputBatch]]]:
    """Each stage of a case's draws, once, and the inputs that those give it: those of fragment and
    vertex stages that ran; nothing for other stages, whose inputs can't be captured.

    Raises:
        ShaderlabError: the case can't be drawn, or what a draw gives can't be captured.
    """
    found: dict[str, tuple[Source, list[InputBatch]]] = {}
    for scene in case.scenes():
        programs = lab.prepare_for_opengl(scene)
        with lab.evaluation(scene, programs) as evaluation:
            for name, draws in programs.items():
                for i, draw in enumerate(draws):
                    for source in draw.sources:
                        if not _is_own(source, draw):
                            one = found.setdefault(source.text, (source, []))
                            given = _given(evaluation, (name, i), source.stage)
                            one[1].extend(g for g in given if g.count)
    return [
        (source, given)
        for source, given in found.values()
        if given or source.stage not in ("vertex", "fragment")
    ]


def rewritten(
    lab: SceneRunner, case: Case, changes: Sequence[Mapping[str, str | Path]]
) -> list[list[Rewritten]]:
    """For each change, the stages of the case's draws that it makes other ones, each once.

    Args:
        lab: draws the case, once for all changes.
        case: whose draws give the inputs.
        changes: other texts or files for some shaders, by their names.

    Raises:
        ShaderError: a shader does not compile, as it is or changed.
        CaseError: no draw of the case uses any of a change's shaders.
    """
    found: list[dict[tuple[str, str], Rewritten]] = [{} for _ in changes]
    for scene in case.scenes():
        programs = lab.prepare_for_opengl(scene)
        with lab.evaluation(scene, programs) as evaluation:
            for change, known in zip(changes, found, strict=True):
                for key, old, new in _changed(programs, lab.prepare_for_opengl(scene, change)):
                    one = known.setdefault((old.text, new.text), Rewritten(old, new))
                    one.given.extend(g for g in _given(evaluation, key, old.stage) if g.count)
    for change, known in zip(changes, found, strict=True):
        if not known:
            raise CaseError(f"no draw uses {', '.join(change)}", file=case.file)
    return [list(known.values()) for known in found]


def _changed(programs: Programs, others: Programs) -> Iterator[tuple[PassDraw, Source, Source]]:
    for name, draws in programs.items():
        for i, draw in enumerate(draws):
            for old, new in zip(draw.sources, others[name][i].sources, strict=True):
                if old.text != new.text and not _is_own(old, draw):
                    yield (name, i), old, new


def _is_own(source: Source, draw: PreparedDraw) -> bool:
    """Whether a stage is the lab's, of no interest."""
    return source.stage == "vertex" and draw.draw.mesh is None


def _given(evaluation: Evaluation, key: PassDraw, stage: str) -> Iterator[InputBatch]:
    """What a draw gives a stage, if that can be captured."""
    bindings = evaluation.drawn.bindings[key]
    if stage == "vertex":
        vertices = CapturedVertices(key)
        yield vertex_batch(evaluation.answer(vertices), bindings, _MOST)
        del evaluation.answers[vertices]  # of many draws, all are more than fits into memory
    elif stage == "fragment":
        fragments = CapturedFragments(key)
        yield fragment_batch(evaluation.answer(fragments), bindings, _MOST)
        del evaluation.answers[fragments]
