"""Judges the mutants of one case: does an expectation fail, and if not, does an output differ?"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from shaderlab.drivers.programs.prepare import PreparedDraw, Programs
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.gl_calls import Traced
from shaderlab.engine.expectations.reads import Named, judged_outputs
from shaderlab.engine.judging.reference_bands import RememberedBands
from shaderlab.engine.lab import Lab
from shaderlab.errors import CaseError, ShaderError
from shaderlab.model.case import Case, Scene
from shaderlab.model.frame import TracedCall
from shaderlab.model.scene import Draw
from shaderlab.mutation import compare, proof
from shaderlab.mutation.api_judging import fate_of_unseen
from shaderlab.mutation.mutants import Mutant
from shaderlab.mutation.results import Fate
from shaderlab.mutation.subjects import downstream, scenes_of
from shaderlab.mutation.tasks import PartError, Task, part_of, sound_part
from shaderlab.mutation.wider import WiderInputs

if TYPE_CHECKING:
    from shaderlab.mutation.locating import Traces

Pair = tuple[Evaluation, Evaluation]
"""The evaluation of a mutant's scene, and that of the same scene unmutated."""


class Judge:
    """Judges mutants of one case, which it evaluates once unmutated.

    Args:
        lab: the open device.
        case: the case.
        variants: names of the only variants to judge by; all of them if empty.
        locate: whether it is asked which statement a killed mutant is traced to.

    Raises:
        CaseError: an expectation fails with the case's own shaders: there is nothing to measure.
    """

    def __init__(
        self, lab: Lab, case: Case, variants: tuple[str, ...] = (), *, locate: bool = False
    ) -> None:
        self._lab = lab
        self._located: dict[str, Traces] | None = {} if locate else None
        self._bands = RememberedBands()
        self._scenes = scenes_of(case, variants)
        self._judged = judged_outputs(self._scenes)
        self._originals = {s.variant: self._original(s) for s in self._scenes}
        self._wider = WiderInputs(lab, self._originals)
        self._traces: dict[str, Sequence[TracedCall]] = {}
        self._sound: set[tuple[str, tuple[str, ...], tuple[int, ...]]] = set()

    def fate(self, mutant: Mutant) -> Fate:
        """The fate of one mutant.

        Raises:
            PartError: it ended in an error, and so does the same part of the case without it.
        """
        tasks: list[Task] = []
        try:
            tasks = self.tasks(mutant)
            with self._bands.in_use():
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
            effect = mutant.effect(scene)
            if effect is not None:
                touched = downstream(scene, effect.passes)
                about = self._concerned(scene, touched, effect.vertex_passes)
                tasks.append(Task(scene, effect, touched, about))
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
        edit = task.effect.edit
        if edit is None:
            run = self._lab.evaluation(part, programs, like=original)
        else:
            run = self._lab.edited_evaluation(part, programs, edit)
        with run as mutant:
            yield mutant, original

    def _fate_of_call(self, task: Task) -> Fate:
        with self.evaluation(task, everything=True) as (mutant, original):
            seen = self._killed(mutant, original) or self._seen(mutant, original)
            if seen is not None:
                return seen
            trace = mutant.answer(Traced())
        return fate_of_unseen(task.scene, trace, self._trace(task.scene))

    def _trace(self, scene: Scene) -> Sequence[TracedCall]:
        """The calls that drawing a scene takes unmutated."""
        if scene.variant not in self._traces:
            programs = self._originals[scene.variant].programs
            with self._lab.edited_evaluation(scene, programs, None) as evaluation:
                self._traces[scene.variant] = evaluation.answer(Traced())
        return self._traces[scene.variant]

    def _fate_of(self, tasks: list[Task]) -> Fate:
        if tasks and tasks[0].effect.edit is not None:
            return self._fate_of_call(tasks[0])
        seen: Fate | None = None
        for task in tasks:
            if task.about:
                fate = self._noticed(task)
                if fate is not None and fate.status == "killed":
                    return fate
                seen = fate if seen is None or (fate is not None and seen.unread) else seen
        if seen is None and tasks:
            if self._is_proved_same(tasks[0]):
                return Fate(status="equivalent", by="its optimised SPIR-V is the original's")
            with self.evaluation(tasks[0], everything=True) as (mutant, original):
                seen = self._seen(mutant, original)
        if seen is not None:
            return seen
        output, tried = self._wider.difference(tasks, self._prepared)
        if output is None:
            return Fate(status="no difference", by=f"no difference found in {tried} inputs")
        return _survived("only on other inputs", output, unread=output not in self._judged)

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

    def _noticed(self, task: Task) -> Fate | None:
        """Killed by the first expectation that fails, else survived if anything has changed."""
        with self.evaluation(task) as (mutant, original):
            return self._killed(mutant, original) or self._seen(mutant, original)

    def _killed(self, mutant: Evaluation, original: Evaluation) -> Fate | None:
        """Killed by another GL error, or by the first expectation that fails."""
        part = mutant.scene
        drawn = {p.name for p in part.passes}
        errors = {k: v for k, v in original.drawn.gl_errors.items() if k[0] in drawn}
        if mutant.drawn.gl_errors != errors:
            return Fate(status="killed", by=f"{part.variant} · another GL error")
        for expectation in part.expect:
            if mutant.judge(expectation).outcome.status != "pass":
                return Fate(
                    status="killed",
                    by=f"{part.variant} · {expectation.name}",
                    traced=self._traced(mutant, original),
                )
        return None

    def _traced(self, mutant: Evaluation, original: Evaluation) -> str:
        """The statement that a killed mutant is traced to, if that is asked for."""
        if self._located is None:
            return ""
        from shaderlab.mutation.locating import traced_to

        return traced_to(mutant, original, self._located[mutant.scene.variant])

    def _seen(self, mutant: Evaluation, original: Evaluation) -> Fate | None:
        """Survived if any bit differs of all that a mutant drew and captured; what expectations
        read comes first."""
        found = sorted(compare.changed(mutant, original))
        read = [each for each in found if compare.is_read(each, mutant, original, self._judged)]
        where = f"seen in {mutant.scene.variant}"
        return _survived(where, (read or found)[0], unread=not read) if found else None

    def _is_proved_same(self, task: Task) -> bool:
        """Whether the compiler makes the same modules of a mutant and the original."""
        effect = task.effect
        if not effect.program:
            return False
        part = part_of(effect.scene, set(effect.passes), [])
        programs, original = self._prepared(task, part), self._originals[part.variant].programs
        name, index = next(
            (name, index)
            for name, draws in programs.items()
            for index, draw in enumerate(draws)
            if draw.draw.shaders == effect.program
        )
        return proof.same_program(programs[name][index].sources, original[name][index].sources)

    def _require_sound(self, task: Task) -> None:
        """Run the parts of the scene that a task may need as they are, once each."""
        for everything in (False, True):
            part = task.unmutated.part(everything)
            key = (part.variant, tuple(p.name for p in part.passes), tuple(task.about))
            if key in self._sound:
                continue
            run = self.evaluation(task.unmutated, everything=everything)
            with sound_part(part), run as (evaluation, _):
                for expectation in part.expect:
                    evaluation.judge(expectation)
            self._sound.add(key)

    def _original(self, scene: Scene) -> Evaluation:
        programs = self._lab.prepare_for_opengl(scene)
        with self._lab.evaluation(scene, programs) as evaluation, self._bands.in_use():
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
            if self._located is not None:
                from shaderlab.mutation.locating import traces_of

                self._located[scene.variant] = traces_of(evaluation)
        return evaluation

    def _prepared(self, task: Task, part: Scene) -> Programs:
        """The draws of a part that the mutant changes, made anew; all others as they are."""
        known = self._originals[part.variant].programs

        def is_changed(draw: Draw, before: PreparedDraw) -> bool:
            return draw.shaders == task.effect.program or draw.state != before.draw.state

        pairs = {p.name: list(zip(p.draws, known[p.name], strict=True)) for p in part.passes}
        anew = {
            name: tuple(replace(b.draw, state=d.state) for d, b in both if is_changed(d, b))
            for name, both in pairs.items()
        }
        scene = replace(
            part, passes=tuple(replace(p, draws=anew[p.name]) for p in part.passes if anew[p.name])
        )
        programs = self._lab.prepare_for_opengl(scene, task.effect.texts)
        made = {name: iter(draws) for name, draws in programs.items()}
        return {
            name: tuple(next(made[name]) if is_changed(d, b) else b for d, b in both)
            for name, both in pairs.items()
        }


def _survived(where: str, output: Named, *, unread: bool) -> Fate:
    note = f"{where}: {'.'.join(output)}" + (", which no expectation reads" if unread else "")
    return Fate(status="survived", by=note, unread=unread)
