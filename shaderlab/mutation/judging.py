"""Judges the mutants of one case: does an expectation fail, and if not, does an output differ?"""

import functools
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.dialects import raise_version
from shaderlab.compiler.glslang import SPIRV_TOOLS_WHEEL, find
from shaderlab.compiler.sources import Source
from shaderlab.drivers.programs.prepare import PreparedDraw, Programs
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.base import Named, judged_outputs
from shaderlab.engine.expectations.gl_call import CallTrace
from shaderlab.engine.expectations.needs import CapturedFragments, CapturedVertices
from shaderlab.engine.judging.bands import BandCache
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError, ShaderError, UnsupportedError
from shaderlab.model.case import Case, Scene
from shaderlab.model.frame import TracedCall, differ
from shaderlab.model.scene import Draw, Pixel
from shaderlab.mutation.call_mutants import judge_unseen_call
from shaderlab.mutation.mutants import (
    Effect,
    Mutant,
    MutantResult,
    Trial,
    select_scenes,
    with_readers,
)
from shaderlab.mutation.other_inputs import WiderInputs

Pair = tuple[Evaluation, Evaluation]
"""The evaluation of a mutant's scene, and that of the same scene unmutated."""
Judged = Mapping[Named, "frozenset[Pixel] | None"]
"""What expectations read of each output: some pixels, or all of it (None)."""
_OPTIMISE = ("--strip-debug", "-O", "--compact-ids")


class PartError(CaseError):
    """A part of a case that mutants are judged by does not run unmutated."""


class Judge:
    """Judges mutants of one case, which it evaluates once unmutated. Raises CaseError: an
    expectation fails with the case's own shaders: there is nothing to measure."""

    def __init__(self, lab: SceneRunner, case: Case, variants: tuple[str, ...] = ()) -> None:
        self._lab = lab
        self._bands = BandCache()
        self._scenes = select_scenes(case, variants)
        self._judged: Judged = judged_outputs(self._scenes)
        self._originals = {s.variant: self._evaluate_original(s) for s in self._scenes}
        self._wider = WiderInputs(lab, self._originals)
        self._call_traces: dict[str, Sequence[TracedCall]] = {}

    def judge(self, mutant: Mutant) -> MutantResult:
        """Return what came of one mutant. Raises PartError: it ended in an error, and so does the
        same part of the case without it."""
        trials: list[Trial] = []
        try:
            trials = self.trials(mutant)
            with self._bands.in_use():
                return self._judge_trials(trials)
        except ShaderError as error:
            return MutantResult("invalid", error.message)
        except (MemoryError, OSError) as error:  # this machine is at its limits
            return MutantResult("invalid", f"can't be judged here: {error or 'out of memory'}")
        except Exception as error:
            for trial in trials:
                self._require_sound(trial)
            # Running the case would end in an error, which does not pass.
            return MutantResult("killed", f"{type(error).__name__}: {error}")

    def trials(self, mutant: Mutant) -> list[Trial]:
        """Return the scenes that a mutant changes, and the expectations that may fail there."""
        trials = []
        for scene in self._scenes:
            effect = mutant.effect(scene)
            if effect is None:
                continue
            touched = with_readers(scene, effect.passes)
            programs = self._originals[scene.variant].programs
            expect = []
            for index, expectation in enumerate(scene.expect):
                vertices = expectation.judges_vertices(scene, programs)
                if expectation.passes(scene) & (effect.vertex_passes if vertices else touched):
                    expect.append(index)
            trials.append(Trial(scene, effect, touched, expect))
        return trials

    @contextmanager
    def evaluation(self, trial: Trial, *, everything: bool = False) -> Iterator[Pair]:
        """Draw a trial's scene; gives its evaluation and that of the same scene unmutated. Raises
        ShaderError: the mutant does not compile."""
        part = trial.part(everything)
        original = self._originals[part.variant]
        programs = self._prepare(trial, part)
        edit = trial.effect.edit
        if edit is None:
            run = self._lab.evaluation(part, programs, like=original)
        else:
            run = self._lab.edited_evaluation(part, programs, edit)
        with run as mutant:
            yield mutant, original

    def _trace_calls(self, scene: Scene) -> Sequence[TracedCall]:
        if scene.variant not in self._call_traces:
            programs = self._originals[scene.variant].programs
            with self._lab.edited_evaluation(scene, programs, None) as evaluation:
                self._call_traces[scene.variant] = evaluation.answer(CallTrace())
        return self._call_traces[scene.variant]

    def _judge_trials(self, trials: list[Trial]) -> MutantResult:
        """Killed in the first scene where an expectation fails; else survived where anything
        changes, be it on other inputs."""
        change: MutantResult | None = None
        for trial in trials:
            edits_call = trial.effect.edit is not None
            if not trial.expect and not edits_call:
                continue
            trace: Sequence[TracedCall] = ()
            with self.evaluation(trial, everything=edits_call) as (mutant, original):
                killed = self._find_killer(mutant, original)
                if killed is not None:
                    return killed
                seen = self._find_change(mutant, original)
                if edits_call and seen is None:
                    trace = mutant.answer(CallTrace())
            if edits_call:
                return seen or judge_unseen_call(trial.scene, trace, self._trace_calls(trial.scene))
            if change is None or (seen is not None and change.unread):
                change = seen
        if change is None and trials:
            with self.evaluation(trials[0], everything=True) as (mutant, original):
                if _has_same_program(mutant, original, trials[0].effect.program):
                    return MutantResult("equivalent", "its optimised SPIR-V is the original's")
                change = self._find_change(mutant, original)
        if change is not None:
            return change
        output, tried = self._wider.find_difference(trials, self._prepare)
        if output is None:
            return MutantResult("no difference", f"no difference found in {tried} inputs")
        return _survived("only on other inputs", output, unread=output not in self._judged)

    def _find_killer(self, mutant: Evaluation, original: Evaluation) -> MutantResult | None:
        """Killed by another GL error, or by the first expectation that fails."""
        part = mutant.scene
        drawn = {p.name for p in part.passes}
        errors = {k: v for k, v in original.drawn.gl_errors.items() if k[0] in drawn}
        if mutant.drawn.gl_errors != errors:
            return MutantResult("killed", f"{part.variant} · another GL error")
        for expectation in part.expect:
            if mutant.judge(expectation).outcome.status != "pass":
                return MutantResult("killed", f"{part.variant} · {expectation.name}")
        return None

    def _find_change(self, mutant: Evaluation, original: Evaluation) -> MutantResult | None:
        """Survived if any bit differs of what a mutant drew and captured, what is judged first."""
        changed = sorted(find_changed_outputs(mutant, original))
        read = [each for each in changed if _is_read(each, mutant, original, self._judged)]
        where = f"seen in {mutant.scene.variant}"
        return _survived(where, (read or changed)[0], unread=not read) if changed else None

    def _require_sound(self, trial: Trial) -> None:
        """Run the parts of the scene that a trial may need as they are. Raises PartError."""
        unmutated = replace(trial, effect=Effect(trial.scene, trial.effect.passes))
        for everything in (False, True):
            part = unmutated.part(everything)
            try:
                with self.evaluation(unmutated, everything=everything) as (evaluation, _):
                    for expectation in part.expect:
                        evaluation.judge(expectation)
            except UnsupportedError:
                raise
            except Exception as error:
                raise PartError(
                    f"{part.case.id}[{part.variant}]: the passes "
                    f"{', '.join(p.name for p in part.passes)} do not run by themselves "
                    f"({type(error).__name__}: {error}), so their mutants can't be judged",
                    file=part.case.file or None,
                    remedy="this is a fault of shaderlab, not of the case: please report it",
                ) from error

    def _evaluate_original(self, scene: Scene) -> Evaluation:
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
        return evaluation

    def _prepare(self, trial: Trial, part: Scene) -> Programs:
        """Prepare the draws of a part that the mutant changes; take all others as they are."""
        known = self._originals[part.variant].programs

        def is_changed(draw: Draw, before: PreparedDraw) -> bool:
            return draw.shaders == trial.effect.program or draw.state != before.draw.state

        pairs = {p.name: list(zip(p.draws, known[p.name], strict=True)) for p in part.passes}
        changed = {
            name: tuple(replace(b.draw, state=d.state) for d, b in both if is_changed(d, b))
            for name, both in pairs.items()
        }
        passes = (replace(p, draws=changed[p.name]) for p in part.passes if changed[p.name])
        programs = self._lab.prepare_for_opengl(
            replace(part, passes=tuple(passes)), trial.effect.texts
        )
        prepared = {name: iter(draws) for name, draws in programs.items()}
        return {
            name: tuple(next(prepared[name]) if is_changed(d, b) else b for d, b in both)
            for name, both in pairs.items()
        }


def _survived(where: str, output: Named, *, unread: bool) -> MutantResult:
    note = f"{where}: {'.'.join(output)}" + (", which no expectation reads" if unread else "")
    return MutantResult("survived", note, unread)


def _is_read(output: Named, mutant: Evaluation, original: Evaluation, judged: Judged) -> bool:
    """Whether a change of this output lies where an expectation looks."""
    pixels = judged.get(output, frozenset())
    images = mutant.drawn.images
    if pixels is None or output not in images:
        return pixels is None
    values, before = images[output].values, original.drawn.images[output].values
    return any(differ(values[p.y, p.x], before[p.y, p.x]) for p in pixels)


def find_changed_outputs(mutant: Evaluation, original: Evaluation) -> set[Named]:
    """Return the outputs that differ in any bit: of the passes drawn, and of what was captured."""
    images = original.drawn.images
    drawn = mutant.drawn.images
    found = {key for key, image in drawn.items() if differ(image.values, images[key].values)}
    for need, answer in mutant.answers.items():
        other = original.answers.get(need)
        if other is None:
            continue
        if isinstance(need, CapturedVertices):
            found |= {
                (need.key[0], name)
                for now, before in ((answer, other), (answer.entering, other.entering))
                if now is not None
                for name, values in now.outputs.items()
                if differ(values, before.outputs[name])
            }
        elif isinstance(need, CapturedFragments) and differ(answer.covered, other.covered):
            found.add((need.key[0], "coverage"))
    return found


def _has_same_program(mutant: Evaluation, original: Evaluation, program: tuple[str, ...]) -> bool:
    """Whether the program that a mutant changes is the same to the optimiser."""
    for name, draws in mutant.programs.items():
        for draw, before in zip(draws, original.programs[name], strict=True):
            if program and draw.draw.shaders == program:
                return is_same_program(draw.sources, before.sources)
    return False


def is_same_program(mutant: Sequence[Source], original: Sequence[Source]) -> bool:
    """Whether the optimiser makes the same modules of both programs' stages. False where there is
    no optimiser and the modules differ."""
    modules, before = _compile_modules(mutant), _compile_modules(original)
    return modules.keys() == before.keys() and all(
        modules[stage] == before[stage]
        or optimise(modules[stage]) == optimise(before[stage]) != b""
        for stage in modules
    )


def _compile_modules(stages: Sequence[Source]) -> Mapping[str, bytes]:
    newer = [raise_version(stage) for stage in stages]
    return compile_program(newer, ("glsl", "opengl")).spirv["opengl"]


@functools.lru_cache(maxsize=64)
def optimise(module: bytes) -> bytes:
    """The module after spirv-opt; nothing if that can't be run or refuses it."""
    optimiser = find_optimiser()
    if optimiser is None:
        return b""
    command = [optimiser, *_OPTIMISE, "-", "-o", "-"]
    run = subprocess.run(command, input=module, capture_output=True, timeout=20.0)
    return run.stdout if run.returncode == 0 else b""


@functools.cache
def find_optimiser() -> str | None:
    """Return the path of spirv-opt: the wheel's, or the one on the PATH; None without one."""
    try:
        return str(find(SPIRV_TOOLS_WHEEL, "spirv-opt", "bin"))
    except ShaderError:
        return shutil.which("spirv-opt")
