"""Shipped cases with a mistake made in them on purpose, judged as far as it takes to notice."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from functools import cache
from itertools import groupby
from typing import TYPE_CHECKING

from shaderlab.engine.catalogue import data_folder
from shaderlab.engine.pictures import with_read_passes
from shaderlab.engine.run import SceneRunner
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Outcome
from shaderlab.mutation.mutants import with_readers

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
    scene: Scene,
    texts: Mapping[str, str] | None = None,
    *,
    changed: Collection[str] = (),
    only: Collection[str] = (),
) -> Iterator[Outcome]:
    """The expectations of a scene that fail; each is judged when it is asked for.

    Those that need the least drawn come first, and it is drawn once for all that need the same.
    Expectations that read nothing of what is changed are left out: they were judged when the
    case itself was.

    Args:
        scene: a variant of a case.
        texts: shaders that are replaced.
        changed: passes that are not the case's own, besides those of `texts`; where neither is
            said, all may be.
        only: names of the only expectations to judge.

    Raises:
        ShaderlabError: the scene can't be drawn, or an expectation can't be judged.
    """
    lab = _lab()
    lab.configure(RunOptions(texts=texts or {}))  # for expectations that compile files themselves
    programs = lab.prepare_for_opengl(scene, texts or {})
    about = list(range(len(scene.expect)))
    if texts or changed:
        touched = with_readers(scene, {*changed, *(_rewritten(scene, programs) if texts else ())})
        about = [i for i in about if scene.expect[i].passes(scene) & touched or not touched]
    if only:
        about = [i for i in about if scene.expect[i].name in only]
        assert about, f"nothing that {scene.case.id} judges there is called {' or '.join(only)}"
    needs = {i: _passes(scene, i) for i in about}
    work = {needed: _work(scene, needed) for needed in needs.values()}
    about.sort(key=lambda i: (work[needs[i]], sorted(needs[i])))
    for needed, group in groupby(about, needs.__getitem__):
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


def _rewritten(scene: Scene, programs: Programs) -> set[str]:
    """The passes with a program that is not as the scene's own shaders have it."""
    right = _lab().prepare_for_opengl(scene)
    return {
        name
        for name, draws in programs.items()
        if [draw.sources for draw in draws] != [draw.sources for draw in right[name]]
    }


def _passes(scene: Scene, index: int) -> frozenset[str]:
    """What has to be drawn for one of a scene's expectations: all of it if none is named."""
    read = scene.expect[index].passes(scene) or {one.name for one in scene.passes}
    return frozenset(with_read_passes(scene, read))


def _work(scene: Scene, passes: Collection[str]) -> int:
    """About how long drawing passes takes: their pixels, and what each draw costs besides."""
    found = 0
    for one in (one for one in scene.passes if one.name in passes):
        width, height = one.target.size or (64, 64)
        found += width * height * max(one.target.samples, 1) + 5000 * len(one.draws)
    return found


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
