"""Runs scenes on one open device: prepare → draw → capture → judge → record."""

import os
import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from functools import lru_cache
from operator import attrgetter
from pathlib import Path

from shaderlab import errors
from shaderlab.compiler.compile import Compiled, find_below_highp
from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.glslang import TARGETS
from shaderlab.compiler.sources import Source
from shaderlab.drivers import Backend, open_backend, record_calls
from shaderlab.drivers.programs.prepare import Preparer, Programs
from shaderlab.engine.settings import load_settings
from shaderlab.errors import Verdict
from shaderlab.model.calls import CallEdit
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation, Judgement
from shaderlab.model.frame import Image
from shaderlab.model.options import RunOptions
from shaderlab.model.phases import PhaseTimer, phase
from shaderlab.model.records import Explanation, Outcome, Record

from .catalogue import shaders_of
from .evaluation import FEATURES, Evaluation, SceneCheck
from .expectations.base import unread_outputs
from .expectations.formula import Formula
from .expectations.gl_call import CallTrace
from .pictures import PictureFiles, PictureWriter, enlarge, save_frames, with_read_passes
from .record import RecordBuilder, format_error

_LOOP = re.compile(r"\b(?:for|while)\s*\(")
_NO_TEXTS: Mapping[str, str | Path] = {}


class SceneRunner(AbstractContextManager["SceneRunner"]):
    """Compiles, draws and judges scenes. A context manager; the device is opened on first use.

    Args:
        notice: called with each step as it begins, in words.

    Attributes:
        exhausted: whether memory ran out.
    """

    def __init__(
        self, options: RunOptions | None = None, notice: Callable[[str], None] | None = None
    ) -> None:
        self.options = options or RunOptions()
        self.exhausted = False
        self._notice = notice
        self._backend: Backend | None = None
        self._verdicts: dict[tuple[Source, ...], Verdict] = {}
        self._preparer = lru_cache(maxsize=64)(self._new_preparer)

    def __exit__(self, *_: object) -> None:
        self.close()

    # A scene, from its case to its record.

    def run(self, scene: Scene) -> Record:
        """Compile, draw and judge one scene.

        Whatever is wrong with the case, its shaders or the driver ends up in the record: status
        "error", or "unsupported" for a feature that the driver lacks, with the message.
        """
        started = time.perf_counter()
        pictures = PictureWriter(self.options.picture_folder, scene.case.id, scene.variant)
        record = RecordBuilder(scene)
        timer = PhaseTimer(self._notice)
        try:
            with timer:
                self._run(scene, record, pictures)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            # A defect of the lab itself costs this scene only; the other scenes go on.
            known = isinstance(error, errors.ShaderlabError | MemoryError)
            if isinstance(error, Exception) and not known and _is_debugging():
                raise
            self.exhausted |= isinstance(error, MemoryError)
            record.set_error(error, self.options.driver)
            if isinstance(error, errors.DeviceLostError):
                self.close()  # the next scene opens another one
        return record.build(time.perf_counter() - started, timer.timings())

    def _run(self, scene: Scene, record: RecordBuilder, pictures: PictureWriter) -> None:
        programs = self._compile(scene, record, pictures)
        with self.evaluation(scene, programs) as evaluation:  # which draws it
            check = self._record_drawn(evaluation, record)
            picture_error = self._draw_pictures(evaluation, record, pictures)
            unanswered = self.judge_all(evaluation, record, pictures, check)
            checked = None if check is None else check.judgement()
        self._require_loops_to_end(scene, programs)
        record.set_unanswered(unanswered)
        if check is not None and checked is not None:
            record.set_self_check(*checked, check.outside, always=bool(self.options.modules))
        if picture_error is not None:
            raise picture_error  # it changes no outcome

    def _compile(self, scene: Scene, record: RecordBuilder, pictures: PictureWriter) -> Programs:
        """Compile a scene's programs and record their verdicts. Raises ShaderError, CaseError,
        UnsupportedError: a program does not compile, an expectation names what is not there, or the
        driver lacks compute passes."""
        with phase("compile", "compiling"):
            programs = self.prepare(scene)
        record.add_programs(programs, pictures)
        _require_compiled(programs)
        self._require_compute(scene)
        for expectation in scene.expect:
            tuple(expectation.needs(scene, programs))  # raises for a name that is not there
        record.set(unread=unread_outputs(scene, programs))
        with phase("link"):
            record.add_driver_verdicts(self.driver_verdict)
        picture_size = 0 if self.options.picture_folder is None else self.options.picture_size
        driver, size = self.driver, self.options.size
        described = f"{driver['renderer']}; {driver['version']}"
        record.set(driver=described, size=size, picture_size=picture_size)
        return programs

    def _require_loops_to_end(self, scene: Scene, programs: Programs) -> None:
        """Raise ShaderError for a loop that goes on until llvmpipe cuts it."""
        if self.cuts_loops(s for draws in programs.values() for d in draws for s in d.authored):
            from .loops import require_loops_to_end  # few scenes have loops

            require_loops_to_end(self, scene, programs)

    def cuts_loops(self, sources: Iterable[Source]) -> bool:
        """Whether some have loops, and the driver is one that cuts them."""
        return "llvmpipe" in self.driver["renderer"] and any(_LOOP.search(s.code) for s in sources)

    def _record_drawn(self, evaluation: Evaluation, record: RecordBuilder) -> SceneCheck | None:
        """Record what drawing gave besides the pictures; returns the self-check to be made. Raises
        DriverError: a draw raised an error of OpenGL that no expectation is about; CaseError: there
        is no such output as the case names for its picture."""
        scene, drawn, options = evaluation.scene, evaluation.drawn, self.options
        if scene.picture is not None:
            picture_of(scene, drawn.images)
        if options.frames is not None:
            with record.notice_if_unwritable("the values that drivers are compared by"):
                save_frames(options.frames, scene.case.id, scene.variant, drawn.images)
            record.drawn = drawn.images
        for name in sorted(drawn.inactive):
            record.add_notice(f"uniform {name} is declared but inactive: it changes no output")
        evaluation.require_no_other_errors()
        if options.gl_calls:
            record.set_gl_calls(evaluation.answer(CallTrace()))
        if options.modules is False or FEATURES.self_check is None:
            return None
        return FEATURES.self_check(evaluation, bool(options.modules))

    def _draw_pictures(
        self, evaluation: Evaluation, record: RecordBuilder, pictures: PictureWriter
    ) -> Exception | None:
        """Write the pictures of the case and its passes, in people's size; returns an error."""
        if self.options.picture_folder is None:
            return None
        scene, images = evaluation.scene, evaluation.drawn.images
        try:
            with phase("picture", "drawing the picture"):
                if (side := self.options.picture_size) != self.options.size:
                    images = enlarge(self.backend, scene, evaluation.programs, images, side)
                shown = picture_of(scene, images)
                with record.notice_if_unwritable():
                    files = pictures.write_picture(images[shown])
                    record.set(images=files.files, captions=files.captions)
                    record.set(passes=pictures.write_passes(scene, images))
                    only = with_read_passes(scene, [shown[0]])
                    drawn = evaluation.session, evaluation.drawn
                    calls, why = record_calls(*drawn, only, shown, side)
                    record.set(live=pictures.write_live(calls) if calls else "", not_live=why)
        except MemoryError:
            raise
        except Exception as error:
            return error
        return None

    def judge_all(
        self,
        evaluation: Evaluation,
        record: RecordBuilder,
        pictures: PictureWriter,
        check: SceneCheck | None = None,
    ) -> dict[int, errors.UnsupportedError]:
        """Capture for each expectation and judge it, one after the other, and write its pictures;
        with the self-check of what they capture.

        Returns:
            the numbers of the expectations that the driver has no answer for, or that need a
            package, and why.
        """
        unanswered = {}
        explained = False
        before_release = None if check is None else check.judge_captured
        for index, expectation in evaluation.iter_with_release(before_release):
            try:
                evaluation.gather(expectation)
                # The first failure is explained: others mostly fail for the same reason.
                explained |= self._judge(evaluation, record, pictures, index, explain=not explained)
            except errors.UnsupportedError as error:
                unanswered[index] = error
        return unanswered

    def _judge(
        self,
        evaluation: Evaluation,
        record: RecordBuilder,
        pictures: PictureWriter,
        index: int,
        *,
        explain: bool,
    ) -> bool:
        """Judge one expectation and write its pictures.

        Returns:
            whether it is a formula that fails, which is explained if `explain` is set.
        """
        files, explanation = PictureFiles(), None
        expectation = evaluation.scene.expect[index]
        try:
            judgement = evaluation.judge(expectation)
            outcome = judgement.outcome
            if judgement.pictures is not None and self.options.picture_folder is not None:
                with phase("picture"), record.notice_if_unwritable():
                    files = pictures.write_comparison(
                        f"{index}-{expectation.name}",
                        judgement.pictures(),
                        outcome.worst.pixel if outcome.worst else None,
                        passed=outcome.status == "pass",
                    )
        except (errors.MissingPackageError, errors.UnsupportedError):
            raise
        except errors.ShaderlabError as error:  # of values that only a picture looks at
            judgement = _make_failed_judgement(expectation, error)
            outcome = judgement.outcome
        formula = expectation if isinstance(expectation, Formula) else None
        failed = formula is not None and outcome.status == "fail"
        if explain and failed and formula is not None:
            explanation = self._explain(evaluation, formula, outcome)
        outcome = replace(
            outcome,
            explanation=explanation,
            images=files.files,
            captions=files.captions,
            values=files.values,
            line=expectation.line_in(evaluation.scene.case.file),
        )
        record.add_outcome(outcome, judgement)
        return failed

    def _explain(
        self, evaluation: Evaluation, formula: Formula, outcome: Outcome
    ) -> Explanation | None:
        """Where a failing formula goes wrong. Whatever hinders that changes no verdict."""
        if FEATURES.explain is None:
            return None
        scene, programs = evaluation.scene, evaluation.programs
        try:
            with (
                phase("judge", "explaining the failure"),
                self.evaluation(scene, programs, like=evaluation) as copy,
            ):
                explanation = FEATURES.explain(copy, formula, outcome)
        except Exception as error:
            if not isinstance(error, errors.ShaderlabError) and _is_debugging():
                raise
            pixel = (outcome.worst.pixel if outcome.worst else None) or (0, 0)
            message = error.message if isinstance(error, errors.ShaderlabError) else repr(error)
            explanation = Explanation(pixel=pixel, steps=(), refused=message)
        pass_name, draw = formula.key(scene)
        lower = list(filter(None, map(find_below_highp, programs[pass_name][draw].authored)))
        if explanation is None or not lower:
            return explanation
        verdict = "; ".join(filter(None, (explanation.verdict, lower[0])))
        return replace(explanation, verdict=verdict)

    # Its parts, as other packages take them.

    def prepare(self, scene: Scene) -> Programs:
        """Compile a scene's programs for all of its targets; also those that do not compile."""
        folder = Path(scene.case.file).parent
        preparer = self._preparer(str(folder))
        asked = self.options.targets or tuple(scene.case.targets)
        targets = asked or load_settings(folder).targets or TARGETS
        return {p.name: tuple(preparer.prepare(d, targets) for d in p.draws) for p in scene.passes}

    def prepare_for_opengl(
        self, scene: Scene, texts: Mapping[str, str | Path] = _NO_TEXTS
    ) -> Programs:
        """Compile a scene's programs for OpenGL alone, with some shaders replaced. Raises
        ShaderError, CaseError: a program does not compile, or does not fit the scene's data."""
        folder = str(Path(scene.case.file).parent)
        preparer = self._preparer(folder, opengl=True)
        if texts:
            preparer = self._new_preparer(folder, opengl=True, texts=texts)
        programs = {p.name: tuple(preparer.prepare(d) for d in p.draws) for p in scene.passes}
        _require_compiled(programs)
        self._require_compute(scene)
        return programs

    @contextmanager
    def evaluation(
        self, scene: Scene, programs: Programs, *, like: Evaluation | None = None
    ) -> Iterator[Evaluation]:
        """Draw a scene, and keep it on the device for judging; for `like` see `Evaluation`. Raises
        ShaderError, UnsupportedError, CaseError: it can't be drawn."""
        preparer = self._preparer(str(Path(scene.case.file).parent))
        size = (self.options.size, self.options.size)
        with self.backend.session(scene, programs, size) as session:
            yield Evaluation(session, self.backend, preparer, like)

    @contextmanager
    def edited_evaluation(
        self, scene: Scene, programs: Programs, edit: CallEdit | None
    ) -> Iterator[Evaluation]:
        """As `evaluation`, with one call of the drawing changed; see `Backend.edited_session`."""
        preparer = self._preparer(str(Path(scene.case.file).parent))
        size = (self.options.size, self.options.size)
        with self.backend.edited_session(scene, programs, size, edit) as session:
            yield Evaluation(session, self.backend, preparer)

    def driver_verdict(self, sources: tuple[Source, ...]) -> Verdict:
        """The driver's own verdict on a program that compiles, asked for once."""
        if sources not in self._verdicts:
            self._verdicts[sources] = self.backend.driver_verdict(sources)
        return self._verdicts[sources]

    # The device, and what is kept from one scene to the next.

    @property
    def backend(self) -> Backend:
        """The device, opened now if it is not open. Raises DriverError."""
        if self._backend is None:
            self._backend = open_backend(self.options.driver)
        return self._backend

    @property
    def driver(self) -> Mapping[str, str]:
        """What the driver says of itself; "renderer" is "none" while no device could be opened."""
        try:
            return self.backend.info
        except errors.DriverError as error:
            return {"renderer": "none", "vendor": "", "version": error.message, "glsl": ""}

    def configure(self, options: RunOptions) -> None:
        """Take other options for the scenes to come. The device stays, and with it the driver."""
        before, self.options = self.options, options
        shaders = attrgetter("replacements", "renames", "include")
        if shaders(options) != shaders(before):
            self.forget_shaders()

    def forget_shaders(self) -> None:
        """Read shaders anew from now on: their files may have changed."""
        self._preparer.cache_clear()

    def close(self) -> None:
        """Give the device back; it is opened again if it is used once more."""
        if self._backend is not None:
            self._backend.close()
            self._backend = None

    def _require_compute(self, scene: Scene) -> None:
        """Raise UnsupportedError where a scene computes and the driver can't."""
        if any(description.computes for description in scene.passes):
            self.backend.require_compute()

    def _new_preparer(
        self, folder: str, *, opengl: bool = False, texts: Mapping[str, str | Path] = _NO_TEXTS
    ) -> Preparer:
        options = self.options
        replaced = texts if opengl else options.replacements
        shaders = shaders_of(Path(folder), replaced, options.include, options.renames)
        return Preparer(shaders, _compile_for_opengl if opengl else cached_compiler())


def _is_debugging() -> bool:
    return bool(os.environ.get("SHADERLAB_DEBUG"))


def _require_compiled(programs: Programs) -> None:
    """Raise the compiler's first error where a program does not compile."""
    for draws in programs.values():
        for draw in draws:
            _ = draw.interface


def _compile_for_opengl(sources: Sequence[Source], _: Sequence[str]) -> Compiled:
    """Compile for plain GLSL, which has the verdict, and OpenGL, which says what is declared."""
    return cached_compiler()(sources, ("glsl", "opengl")).only(["glsl"])


def _make_failed_judgement(expectation: Expectation, error: errors.ShaderlabError) -> Judgement:
    name, kind, message = expectation.name, expectation.kind, format_error(error)
    return Judgement(outcome=Outcome(name=name, kind=kind, status="error", message=message))


def picture_of(scene: Scene, images: Mapping[tuple[str, str], Image]) -> tuple[str, str]:
    """The (pass, output) that is the case's picture: the one it names, or the last pass's first.
    Raises CaseError: the case names an output that is not there."""
    named = scene.picture
    if named is None:
        last = scene.passes[-1].name
        return next(key for key in images if key[0] == last)
    if (named.pass_name, named.name) not in images:
        known = [".".join(key) for key in images]
        raise errors.CaseError(
            f"there is no output {scene.case.picture!r} to be the picture",
            remedy=errors.suggest(scene.case.picture, known),
        )
    return named.pass_name, named.name
