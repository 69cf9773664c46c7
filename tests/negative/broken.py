"""Shipped cases with a mistake made in them on purpose, judged as far as it takes to notice."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from functools import cache
from itertools import groupby
from typing import TYPE_CHECKING

from shaderlab.engine.catalogue import data_folder
from shaderlab.engine.run import SceneRunner
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Outcome
from shaderlab.mutation.mutants import with_inputs, with_readers

if TYPE_CHECKING:
    from shaderlab.drivers.programs.prepare import Programs
    from shaderlab.model.case import Case, Scene
    from shaderlab.model.scene import Draw, Pass


def mistaken(shader: str, right: str, wrong: str) -> dict[str, str]:
    """The text of a shipped shader with a mistake in it, by its name."""
    text = (data_folder("shaders") / shader).read_text(encoding="utf-8")
    assert right in text, f"{shader} does not read {right!r} any more"
    return {shader: text.replace(right, wrong)}


def failures(
    scene: Scene, texts: Mapping[str, str] | None = None, *, only: Collection[str] = ()
) -> Iterator[Outcome]:
    """The expectations of a scene that fail, in its order; each is judged when it is asked for.

    Drawn is what the next one needs. Expectations that read nothing of what a text changes are
    left out: they were judged when the case itself was.

    Args:
        scene: a variant of a case.
        texts: shaders that are replaced.
        only: names of the only expectations to judge.

    Raises:
        ShaderlabError: the scene can't be drawn, or an expectation can't be judged.
    """
    lab = _lab()
    lab.configure(RunOptions(texts=texts or {}))  # for expectations that compile files themselves
    programs = lab.prepare_for_opengl(scene, texts or {})
    about = list(range(len(scene.expect)))
    if texts:
        touched = with_readers(scene, _changed(scene, programs))
        about = [i for i in about if scene.expect[i].passes(scene) & touched or not touched]
    if only:
        about = [i for i in about if scene.expect[i].name in only]
        assert about, f"nothing that {scene.case.id} judges there is called {' or '.join(only)}"
    for needed, group in groupby(about, lambda i: _passes(scene, i)):
        part = replace(
            scene,
            passes=tuple(p for p in scene.passes if p.name in needed),
            expect=tuple(e for e in scene.expect if e.passes(scene) <= needed),
        )
        with lab.evaluation(part, {name: programs[name] for name in needed}) as evaluation:
            for i in group:
                outcome = evaluation.judge(scene.expect[i]).outcome
                if outcome.status == "fail":
                    yield outcome
            evaluation.require_no_other_errors()


def _changed(scene: Scene, programs: Programs) -> set[str]:
    """The passes with a program that is not as the scene's own shaders have it."""
    with SceneRunner() as lab:
        right = lab.prepare_for_opengl(scene)
    return {
        name
        for name, draws in programs.items()
        if [draw.sources for draw in draws] != [draw.sources for draw in right[name]]
    }


def _passes(scene: Scene, index: int) -> frozenset[str]:
    """What has to be drawn for one of a scene's expectations: all of it if none is named."""
    read = scene.expect[index].passes(scene) or {one.name for one in scene.passes}
    return frozenset(with_inputs(scene, read))


def failing(scene: Scene, texts: Mapping[str, str] | None = None) -> set[str]:
    """The names of all expectations of a scene that fail."""
    return {outcome.name for outcome in failures(scene, texts)}


def first_failure(
    case: Case, texts: Mapping[str, str] | None = None, *, placed: bool = False
) -> Outcome | None:
    """What fails first of a case's variants; with `placed`, what names a pixel, or counts them."""
    for scene in case.scenes():
        for outcome in failures(scene, texts):
            if not placed or outcome.worst is not None or outcome.kind == "coverage":
                return outcome
    return None


def with_draws(case: Case, change: Callable[[Pass, Draw], Draw]) -> Case:
    """The case with each of its draws changed."""
    passes = tuple(replace(p, draws=tuple(change(p, d) for d in p.draws)) for p in case.passes)
    return replace(case, passes=passes)


@cache
def _lab() -> SceneRunner:
    """One device for all tests of a process."""
    return SceneRunner(RunOptions())
