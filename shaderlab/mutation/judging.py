"""Judges the mutants of one case: does an expectation fail, and if not, does an output differ?"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import replace

from shaderlab.errors import CaseError, ShaderError, UnsupportedError
from shaderlab.evaluation import Evaluation, Lab
from shaderlab.expectations.reads import Named, judged_outputs
from shaderlab.frame import Array, PassDraw
from shaderlab.model import Case, Scene
from shaderlab.mutation import compare, wider
from shaderlab.mutation.mutants import Mutant
from shaderlab.mutation.results import Fate
from shaderlab.mutation.subjects import (
    downstream,
    sources_of,
    with_what_they_read,
)
from shaderlab.mutation.tasks import Seen, Task, part_of
from shaderlab.programs.prepare import Programs


class PartError(CaseError):
    """A part of a case that mutants are judged by does not run unmutated."""


Pair = tuple[Evaluation, Evaluation]
"""The evaluation of a mutant's scene, and that of the same scene unmutated."""

Wide = tuple[list[wider.Round], dict[tuple[str, int], Array]]
"""Wider inputs of a draw, and what the case's own shaders make of them."""


class Judge:
    """Judges mutants of one case, which it evaluates once unmutated.

    Args:
        lab: the open device.
        case: the case.
        variants: names of the only variants to judge by; all of them if empty.

    Raises:
        CaseError: an expectation fails with the case's own shaders: there is nothing to measure.
    """

    def __init__(self, lab: Lab, case: Case, variants: tuple[str, ...] = ()) -> None:
        self._lab = lab
        self._case = case
        scenes = list(case.scenes())
        self._scenes = [s for s in scenes if not variants or s.variant in variants]
        self._sources = sources_of(case)
        self._judged = judged_outputs(self._scenes)
        self._originals = {s.variant: self._original(s) for s in self._scenes}
        self._wide: dict[tuple[str, PassDraw], Wide] = {}
        self._sound: set[tuple[str, tuple[str, ...], tuple[int, ...]]] = set()

    def fate(self, mutant: Mutant) -> Fate:
        """The fate of one mutant.

        Raises:
            PartError: it ended in an error, and so does the same part of the case without it.
        """
        tasks: list[Task] = []
        try:
            tasks = self.tasks(mutant)
            return self._fate_of(tasks)
        except PartError:
            raise
        except ShaderError as error:
            return Fate(status="invalid", by=error.message)
        except Exception as error:
            for task in tasks:
                self._require_sound(task)
            # Running the case would end in an error, which does not pass.
            return Fate(status="killed", by=f"{type(error).__name__}: {error}")

    def tasks(self, mutant: Mutant) -> list[Task]:
        """The scenes that a mutant changes, and the expectations that may fail there."""
        tasks = []
        for scene in self._scenes:
            effect = mutant.effect(scene, self._sources)
            if effect is not None:
                touched = downstream(scene, effect.passes)
                about = self._concerned(scene, touched, effect.vertex_passes)
                tasks.append(Task(scene, effect.scene, effect.texts, touched, about))
        return tasks

    @contextmanager
    def evaluation(self, task: Task, *, everything: bool = False) -> Iterator[Pair]:
        """Draw a task's scene; gives its evaluation and that of the same scene unmutated.

        Raises:
            ShaderError: the mutant does not compile.
        """
        part = task.part(everything)
        original = self._originals[part.variant]
        programs = self._prepared(task, part)
        with self._lab.evaluation(part, programs, like=original) as mutant:
            yield mutant, original

    def _fate_of(self, tasks: list[Task]) -> Fate:
        if not any(task.about for task in tasks):
            for task in tasks[:1]:
                self._prepared(task, task.changed)  # it has to compile all the same
            return Fate(status="unjudged", by="no expectation reads what it draws")
        seen = Seen()
        for task in tasks:
            if task.about:
                by = self._noticed(task, seen)
                if by:
                    return Fate(status="killed", by=by)
        if not seen.read:
            self._look_wider(tasks[0], seen)
        if seen.read:
            return Fate(status="survived", by=seen.read)
        if seen.elsewhere:
            return Fate(status="unjudged", by=seen.elsewhere)
        return Fate(status="equivalent")

    def _concerned(self, scene: Scene, touched: set[str], vertex: Collection[str]) -> list[int]:
        """The expectations that may fail when the `touched` passes draw something else; those of
        vertex outputs only where the change is in one of the passes `vertex`."""
        programs = self._originals[scene.variant].programs
        return [
            index
            for index, expectation in enumerate(scene.expect)
            if expectation.passes(scene)
            & set(vertex if expectation.judges_vertices(scene, programs) else touched)
        ]

    def _noticed(self, task: Task, seen: Seen) -> str:
        """The first expectation that fails, or ""; then `seen` has what changed all the same."""
        with self.evaluation(task) as (mutant, original):
            part = mutant.scene
            drawn = {p.name for p in part.passes}
            errors = {k: v for k, v in original.drawn.gl_errors.items() if k[0] in drawn}
            if mutant.drawn.gl_errors != errors:
                return f"{part.variant} · another GL error"
            for expectation in part.expect:
                if mutant.judge(expectation).outcome.status != "pass":
                    return f"{part.variant} · {expectation.name}"
            self._look(mutant, original, seen)
        return ""

    def _look(self, mutant: Evaluation, original: Evaluation, seen: Seen) -> None:
        """Compare everything that a mutant drew and captured with the original, bit for bit."""
        for output in sorted(compare.changed(mutant, original)):
            read = compare.is_read(output, mutant, original, self._judged)
            seen.note(f"seen in {mutant.scene.variant}: {'.'.join(output)}", read)

    def _look_wider(self, task: Task, seen: Seen) -> None:
        """Look at the passes that no expectation needs as well; and, if shaders were changed, run
        them on inputs that the case does not have."""
        with self.evaluation(task, everything=True) as (mutant, original):
            self._look(mutant, original, seen)
            if task.texts:
                for output in self._changed_wide(mutant, task.touched):
                    read = self._judged.get(output, frozenset()) is None
                    seen.note(f"only on wider inputs: {'.'.join(output)}", read)

    def _changed_wide(self, mutant: Evaluation, touched: set[str]) -> Iterator[Named]:
        """Outputs that differ somewhere on inputs that the case does not have."""
        done: set[tuple[str | None, ...]] = set()
        for name in touched:
            for index, draw in enumerate(mutant.programs[name]):
                key = (name, index)
                program = tuple(draw.text(stage) for stage in ("vertex", "fragment"))
                if program in done:
                    continue
                done.add(program)
                try:
                    some, expected = self._wide_of(mutant.scene.variant, key)
                except UnsupportedError:
                    continue  # stages that can't be run on given inputs
                for (output, number), got in wider.outputs(mutant, key, some):
                    if compare.differ(got, expected[output, number]):
                        yield name, output

    def _wide_of(self, variant: str, key: PassDraw) -> Wide:
        """Wider inputs of a draw, and what the case's own shaders make of them."""
        if (variant, key) not in self._wide:
            original = self._originals[variant]
            part = part_of(original.scene, with_what_they_read(original.scene, {key[0]}), [])
            programs = {p.name: original.programs[p.name] for p in part.passes}
            some = wider.rounds(original, key, seed=key[1])
            with _sound_part(part), self._lab.evaluation(part, programs) as unmutated:
                self._wide[variant, key] = (some, dict(wider.outputs(unmutated, key, some)))
        return self._wide[variant, key]

    def _require_sound(self, task: Task) -> None:
        """Run the parts of the scene that a task may need as they are, once each."""
        unmutated = replace(task, changed=task.scene, texts={})
        for everything in (False, True):
            part = unmutated.part(everything)
            key = (part.variant, tuple(p.name for p in part.passes), tuple(task.about))
            if key in self._sound:
                continue
            run = self.evaluation(unmutated, everything=everything)
            with _sound_part(part), run as (evaluation, _):
                for expectation in part.expect:
                    evaluation.judge(expectation)
            self._sound.add(key)

    def _original(self, scene: Scene) -> Evaluation:
        programs = self._lab.prepare_for_opengl(scene)
        with self._lab.evaluation(scene, programs) as evaluation:
            for expectation in scene.expect:
                if not expectation.passes(scene):
                    continue  # no shader has a part in it
                outcome = evaluation.judge(expectation).outcome
                if outcome.status != "pass":
                    raise CaseError(
                        f"{scene.case.id}[{scene.variant}]: {expectation.name!r} fails with the "
                        f"case's own shaders ({outcome.message})",
                        file=scene.case.file or None,
                        remedy="mend the case first; then its power can be measured",
                    )
        return evaluation

    def _prepared(self, task: Task, part: Scene) -> Programs:
        """Programs of the touched passes made anew, the others' as they are."""
        mine = replace(part, passes=tuple(p for p in part.passes if p.name in task.touched))
        original = self._originals[part.variant].programs
        anew = self._lab.prepare_for_opengl(mine, task.texts)
        return {p.name: anew.get(p.name) or original[p.name] for p in part.passes}


@contextmanager
def _sound_part(part: Scene) -> Iterator[None]:
    """What goes wrong here goes wrong without any mutant."""
    try:
        yield
    except UnsupportedError:
        raise
    except Exception as error:
        raise PartError(
            f"{part.case.id}[{part.variant}]: the passes "
            f"{', '.join(p.name for p in part.passes)} do not run by themselves "
            f"({type(error).__name__}: {error}), so that mutants of them can't be judged",
            file=part.case.file or None,
            remedy="this is a fault of shaderlab, not of the case: please report it",
        ) from error
