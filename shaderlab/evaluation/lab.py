"""The lab: one open device, on which scenes are compiled, drawn and judged."""

from __future__ import annotations

import os
import time
import traceback
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import Self

from shaderlab import packages
from shaderlab.activity import Activity, doing
from shaderlab.backends import Backend, Drawn, open_backend
from shaderlab.compiler.compile import Compiled
from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.compiler.targets import TARGETS
from shaderlab.errors import (
    AssetError,
    CaseError,
    DeviceLostError,
    DriverError,
    ShaderlabError,
    UnsupportedError,
    nearest,
)
from shaderlab.evaluation import modules, stored_images
from shaderlab.evaluation.evaluation import Evaluation
from shaderlab.evaluation.picture_writer import PictureFiles, PictureWriter
from shaderlab.evaluation.record_builder import RecordBuilder
from shaderlab.evaluation.search_path import shaders_of
from shaderlab.expectations.formula import Formula
from shaderlab.expectations.gl_calls import Traced
from shaderlab.expectations.reads import unread_outputs
from shaderlab.model import Case, Judgement, Scene
from shaderlab.model.call_edits import CallEdit
from shaderlab.observations import Look, Observation
from shaderlab.options import RunOptions
from shaderlab.programs.prepare import Preparer, Programs
from shaderlab.records import Explanation, Outcome, Record, Verdict
from shaderlab.settings import settings_of

_NO_TEXTS: Mapping[str, str | Path] = {}


class Lab:
    """Evaluates scenes. A context manager; the device is opened on first use."""

    def __init__(
        self, options: RunOptions | None = None, notice: Callable[[str], None] | None = None
    ) -> None:
        self.options = options or RunOptions()
        self.exhausted = False  # whether memory ran out in it
        self._notice = notice
        self._backend: Backend | None = None
        self._verdicts: dict[tuple[Source, ...], Verdict] = {}
        self._preparer = lru_cache(maxsize=64)(self._new_preparer)
        self._opengl_preparer = lru_cache(maxsize=64)(
            lambda folder: Preparer(self._shaders(folder, {}), _compile_for_opengl)
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def configure(self, options: RunOptions) -> None:
        """Take other options for the scenes to come. The device stays, and with it the driver."""
        if _of_shaders(options) != _of_shaders(self.options):
            self.forget_shaders()
        self.options = options

    def forget_shaders(self) -> None:
        """Read shaders anew from now on: their files may have changed."""
        self._preparer.cache_clear()
        self._opengl_preparer.cache_clear()

    def close(self) -> None:
        """Give the device back; the lab opens it again if it is used once more."""
        if self._backend is not None:
            self._backend.close()
            self._backend = None

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
        except DriverError as error:
            return {"renderer": "none", "vendor": "", "version": error.message, "glsl": ""}

    @property
    def versions(self) -> Mapping[str, str]:
        """Versions of the packages that results depend on."""
        return packages.versions()

    def prepare_for_opengl(
        self, scene: Scene, texts: Mapping[str, str | Path] = _NO_TEXTS
    ) -> Programs:
        """The scene's programs, compiled for OpenGL alone, with some shaders replaced.

        Raises:
            ShaderError, CaseError: a program does not compile, or does not fit the scene's data.
        """
        folder = Path(scene.case.file).parent
        if texts:
            preparer = Preparer(self._shaders(folder, texts), _compile_for_opengl)
        else:
            preparer = self._opengl_preparer(str(folder))
        programs = {p.name: tuple(preparer.prepare(d) for d in p.draws) for p in scene.passes}
        _require_compiled(programs)
        self._require_compute(scene)
        return programs

    def _require_compute(self, scene: Scene) -> None:
        """Raise UnsupportedError where a scene computes and the driver can't."""
        if any(description.computes for description in scene.passes):
            self.backend.require_compute()

    @contextmanager
    def evaluation(
        self, scene: Scene, programs: Programs, *, like: Evaluation | None = None
    ) -> Iterator[Evaluation]:
        """Draw a scene, and keep it on the device for judging.

        Args:
            scene: what to draw.
            programs: its compiled draws.
            like: see `Evaluation`. Programs that are linked for a scene like another one are not
                kept.

        Raises:
            ShaderError, UnsupportedError, CaseError: it can't be drawn.
        """
        preparer = self._preparer(str(Path(scene.case.file).parent))
        size = (self.options.size,) * 2
        with self.backend.session(
            scene, programs, size, temporary_programs=like is not None
        ) as session:
            yield Evaluation(session, self.backend, preparer, like)

    @contextmanager
    def edited_evaluation(
        self, scene: Scene, programs: Programs, edit: CallEdit | None
    ) -> Iterator[Evaluation]:
        """As `evaluation`, with one call of the drawing made otherwise; see
        `Backend.edited_session`."""
        preparer = self._preparer(str(Path(scene.case.file).parent))
        size = (self.options.size,) * 2
        with self.backend.edited_session(scene, programs, size, edit) as session:
            yield Evaluation(session, self.backend, preparer)

    def run(self, scene: Scene) -> Record:
        """Compile, draw and judge one scene.

        Whatever is wrong with the case, its shaders or the driver ends up in the record: status
        "error", or "unsupported" for a feature that the driver lacks, with the message.
        """
        started = time.perf_counter()
        builder = RecordBuilder(scene)
        activity = Activity(self._notice)
        try:
            with activity.watch():
                self._run(scene, builder)
        except UnsupportedError as error:
            builder.set_failure("unsupported", error)
        except DeviceLostError as error:
            builder.set_failure("crash", DriverError(f"{self.options.driver}: {error.message}"))
            self.close()  # the next scene opens another one
        except MemoryError as error:
            self.exhausted = True
            builder.set_failure("error", ShaderlabError(f"out of memory: {error}".rstrip(": ")))
        except ShaderlabError as error:
            builder.set_failure("error", error)
        except Exception as error:
            # A defect of the lab itself costs this scene only; what else was asked for goes on.
            if os.environ.get("SHADERLAB_DEBUG"):
                raise
            builder.set_failure("error", _defect(error))
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # SystemExit, say, which only a case's own code raises
            builder.set_failure("error", _raised(error))
        return builder.build(time.perf_counter() - started, activity.ordered())

    def observe(self, scene: Scene, looks: Sequence[Look]) -> tuple[Observation, ...]:
        """What the driver does at some pixels of a scene, drawn once more.

        Raises:
            ShaderlabError: it can't be drawn.
        """
        from shaderlab.evaluation.observing import observe  # few runs look at anything

        with Activity(self._notice).watch():
            preparer = self._preparer(str(Path(scene.case.file).parent))
            programs = {
                p.name: tuple(preparer.prepare(d, self._targets(scene.case)) for d in p.draws)
                for p in scene.passes
            }
            with self.evaluation(scene, programs) as evaluation:
                return observe(evaluation, looks)

    def _run(self, scene: Scene, builder: RecordBuilder) -> None:
        preparer = self._preparer(str(Path(scene.case.file).parent))
        targets = self._targets(scene.case)
        with doing("compile", "compiling"):
            programs = {
                p.name: tuple(preparer.prepare(d, targets) for d in p.draws) for p in scene.passes
            }
        folder = self.options.picture_folder
        writer = PictureWriter(folder, scene.case.id, scene.variant)

        def assembly(modules: Mapping[str, bytes]) -> str:
            file = ""
            with _unless_unwritable(builder):
                file = writer.write_assembly(modules)
            return file

        builder.add_programs(programs, assembly)
        _require_compiled(programs)
        self._require_compute(scene)
        for expectation in scene.expect:
            tuple(expectation.needs(scene, programs))  # raises for a name that is not there
        builder.set_unread(unread_outputs(scene, programs))
        with doing("link"):
            builder.add_driver_verdicts(self._driver_verdict)
        picture_size = 0 if folder is None else self.options.picture_size
        builder.set_device(self.driver, self.options.size, picture_size)
        with self.evaluation(scene, programs) as evaluation:
            unanswered = _gathered(evaluation)
            if self.options.gl_calls:
                builder.set_gl_calls(evaluation.answer(Traced()))
            of_modules = None
            if self.options.modules:
                with doing("judge", "judging each draw by its shader"):
                    of_modules = modules.judge_modules(evaluation)
        drawn = evaluation.drawn
        if self.options.frames is not None:
            with _unless_unwritable(builder, "the values that drivers are compared by"):
                stored_images.save(self.options.frames, scene.case.id, scene.variant, drawn.images)
            builder.set_drawn(drawn.images)
        builder.add_inactive_uniforms(drawn.inactive)
        evaluation.require_no_other_errors()
        self.judge_all(evaluation, builder, writer, unanswered)
        if unanswered:
            names = ", ".join(repr(scene.expect[index].name) for index in unanswered)
            builder.add_notice(f"not judged on this driver: {names}")
            builder.set_unanswered(next(iter(unanswered.values())))
        if of_modules is not None:
            builder.add_outcome(of_modules.outcome, of_modules)
        if folder is not None:
            with doing("picture", "drawing the picture"):
                enlarged = self._enlarged(scene, programs, drawn)
                self._write_pictures(scene, enlarged, builder, writer)

    def _driver_verdict(self, sources: tuple[Source, ...]) -> Verdict:
        """The driver's own verdict on a program, asked for once."""
        if sources not in self._verdicts:
            self._verdicts[sources] = self.backend.driver_verdict(sources)
        return self._verdicts[sources]

    def judge_all(
        self,
        evaluation: Evaluation,
        builder: RecordBuilder,
        writer: PictureWriter,
        unanswered: Container[int] = (),
    ) -> None:
        """Judge all expectations of a scene that was drawn, but for those with these numbers, and
        write the pictures of each."""
        explained = False
        for index, expectation in enumerate(evaluation.scene.expect):
            if index in unanswered:
                continue
            files = PictureFiles()
            try:
                judgement = evaluation.judge(expectation)
                worst = judgement.outcome.worst
                with doing("picture"), _unless_unwritable(builder):
                    files = writer.write_comparison(
                        f"{index}-{expectation.name}",
                        judgement.pictures,
                        worst.pixel if worst else None,
                    )
            except ShaderlabError as error:  # in a picture: of values that nothing else looked at
                judgement = Judgement(
                    outcome=Outcome(
                        name=expectation.name,
                        kind=expectation.kind,
                        status="error",
                        message=str(error),
                    )
                )
            explanation = None
            failed = judgement.outcome.status == "fail"
            if failed and isinstance(expectation, Formula) and not explained:
                # The first one: others mostly fail for the same reason.
                explained = True
                explanation = self._explanation(evaluation, expectation, judgement.outcome)
            outcome = replace(
                judgement.outcome,
                explanation=explanation,
                images=files.files,
                captions=files.captions,
                values=files.values,
                line=expectation.line_in(evaluation.scene.case.file),
            )
            builder.add_outcome(outcome, judgement)

    def _explanation(
        self, evaluation: Evaluation, expectation: Formula, outcome: Outcome
    ) -> Explanation | None:
        """Where a failing formula goes wrong. Whatever hinders that changes no verdict."""
        from shaderlab.evaluation.locating import located  # it parses GLSL, which few runs need

        scene, programs = evaluation.scene, evaluation.programs
        try:
            with (
                doing("judge", "explaining the failure"),
                self.evaluation(scene, programs, like=evaluation) as again,
            ):
                return located(again, expectation, outcome)
        except Exception as error:
            if os.environ.get("SHADERLAB_DEBUG") and not isinstance(error, ShaderlabError):
                raise
            pixel = (outcome.worst.pixel if outcome.worst else None) or (0, 0)
            said = error.message if isinstance(error, ShaderlabError) else repr(error)
            return Explanation(pixel=pixel, steps=(), refused=said)

    def _enlarged(self, scene: Scene, programs: Programs, drawn: Drawn) -> Drawn:
        """The scene in the size for people: drawn once more, but where it has one size only."""
        side = self.options.picture_size
        if side == self.options.size or all(p.target.size or p.computes for p in scene.passes):
            return drawn
        with self.backend.session(scene, programs, (side, side)) as session:
            return session.draw()

    def _write_pictures(
        self, scene: Scene, drawn: Drawn, builder: RecordBuilder, writer: PictureWriter
    ) -> None:
        wanted = _picture_of(scene, drawn)
        with _unless_unwritable(builder):
            builder.set_pictures(
                writer.write_picture(drawn.images[wanted]),
                writer.write_passes(scene, drawn.images),
            )

    def _new_preparer(self, folder: str) -> Preparer:
        return Preparer(self._shaders(folder, self.options.replacements), cached_compiler())

    def _targets(self, case: Case) -> tuple[str, ...]:
        """What a case's programs are compiled for: what the run says, the case, or its project."""
        own = settings_of(Path(case.file).parent).targets
        return self.options.targets or tuple(case.targets) or own or TARGETS

    def _shaders(self, folder: str | Path, overrides: Mapping[str, str | Path]) -> Shaders:
        options = self.options
        return shaders_of(Path(folder), overrides, options.include, options.renames)


def _of_shaders(options: RunOptions) -> tuple[object, ...]:
    """What shaders are read by."""
    return options.replacements, options.renames, options.include


def _compile_for_opengl(sources: Sequence[Source], _: Sequence[str]) -> Compiled:
    """Compile for plain GLSL, which has the verdict, and OpenGL, which says what is declared."""
    return cached_compiler()(sources, ("glsl", "opengl")).only(["glsl"])


def _require_compiled(programs: Programs) -> None:
    """Raise the compiler's first error where a program does not compile."""
    for draws in programs.values():
        for draw in draws:
            _ = draw.interface


def _gathered(evaluation: Evaluation) -> dict[int, UnsupportedError]:
    """Ask for all that a scene's expectations need. Returns the numbers of those that the driver
    has no answer for, and why; the others are judged all the same."""
    unanswered = {}
    for index, expectation in enumerate(evaluation.scene.expect):
        try:
            evaluation.gather(expectation)
        except UnsupportedError as error:
            unanswered[index] = error
    return unanswered


def _picture_of(scene: Scene, drawn: Drawn) -> tuple[str, str]:
    """The (pass, output) that is the case's picture: the one it names, or the last pass's first.

    Raises:
        CaseError: the case names an output that is not there.
    """
    named = scene.picture
    if named is None:
        last = scene.passes[-1].name
        return next(key for key in drawn.images if key[0] == last)
    if (named.pass_name, named.name) not in drawn.images:
        known = [".".join(key) for key in drawn.images]
        raise CaseError(
            f"there is no output {scene.case.picture!r} to be the picture",
            remedy=nearest(scene.case.picture, known),
        )
    return named.pass_name, named.name


@contextmanager
def _unless_unwritable(builder: RecordBuilder, what: str = "a picture") -> Iterator[None]:
    """A file for people that can't be written, on a full disk say, changes no verdict: it is a
    notice."""
    try:
        yield
    except AssetError as error:
        builder.add_notice(error.message)
    except OSError as error:
        builder.add_notice(f"can't write {what} ({error.strerror or error})")


def _raised(error: BaseException) -> ShaderlabError:
    """What a case raised, with the place where it did."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    message = f"raised {type(error).__name__}: {error}".rstrip(": ")
    return CaseError(message, file=place.filename, line=place.lineno)


def _defect(error: Exception) -> ShaderlabError:
    """An unforeseen error, with the place in the code where it happened."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return ShaderlabError(
        f"unforeseen {type(error).__name__}: {error}",
        file=place.filename,
        line=place.lineno,
        remedy="this is a defect of shaderlab; SHADERLAB_DEBUG=1 shows the whole traceback",
    )
