"""The lab: one open device, on which scenes are compiled, drawn and judged."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from dataclasses import replace

from shaderlab.compiler.dialects import below_highp
from shaderlab.drivers.programs.prepare import Programs
from shaderlab.drivers.programs.textures import forget_made
from shaderlab.errors import (
    CaseError,
    DeviceLostError,
    OtherApiError,
    ShaderlabError,
    UnsupportedError,
    nearest,
)
from shaderlab.model.activity import Activity, doing
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement
from shaderlab.model.frame import Image
from shaderlab.model.records import Explanation, Outcome, Record

from . import stored_images
from .drawing import SceneDrawer, require_compiled
from .enlarging import enlarged
from .evaluation import Evaluation
from .expectations.base import unread_outputs
from .expectations.formula import Formula
from .expectations.gl_call import Traced
from .failures import failure_of, unless_unwritable
from .features import FEATURES, SceneCheck
from .file_thread import FileThread
from .picture_writer import PictureFiles, PictureWriter
from .record_builder import RecordBuilder, told


class Lab(SceneDrawer):
    """Evaluates scenes. A context manager; the device is opened on first use."""

    exhausted = False
    """Whether memory ran out in it."""

    def run(self, scene: Scene) -> Record:
        """Compile, draw and judge one scene.

        Whatever is wrong with the case, its shaders or the driver ends up in the record: status
        "error", or "unsupported" for a feature that the driver lacks, with the message.
        """
        started = time.perf_counter()
        builder = RecordBuilder(scene)
        activity = Activity(self._notice)
        try:
            with activity.watch(), FileThread(builder, self.options.file_thread) as files:
                self._run(scene, builder, files)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            # A defect of the lab itself costs this scene only; what else was asked for goes on.
            known = isinstance(error, ShaderlabError | MemoryError)
            if isinstance(error, Exception) and not known and os.environ.get("SHADERLAB_DEBUG"):
                raise
            self.exhausted |= isinstance(error, MemoryError)
            builder.set_failure(*failure_of(error, self.options.driver))
            if isinstance(error, DeviceLostError):
                self.close()  # the next scene opens another one
        return builder.build(time.perf_counter() - started, activity.ordered())

    def release_caches(self) -> None:
        """Free what is kept for scenes that are run again: the textures that functions made."""
        forget_made()
        if self._backend is not None:
            self._backend.release_caches()

    def _run(self, scene: Scene, builder: RecordBuilder, files: FileThread) -> None:
        with doing("compile", "compiling"):
            programs = self.prepare(scene)
        folder = self.options.picture_folder
        writer = PictureWriter(folder, scene.case.id, scene.variant, files.submit)

        def assembly(spirv: Mapping[str, Mapping[str, bytes]]) -> str:
            file = ""
            with unless_unwritable(builder):
                file = writer.write_assembly(spirv)
            return file

        builder.add_programs(programs, assembly)
        require_compiled(programs)
        self.require_compute(scene)
        for expectation in scene.expect:
            tuple(expectation.needs(scene, programs))  # raises for a name that is not there
        builder.set_unread(unread_outputs(scene, programs))
        with doing("link"):
            builder.add_driver_verdicts(self.driver_verdict)
        picture_size = 0 if folder is None else self.options.picture_size
        builder.set_device(self.driver, self.options.size, picture_size)
        of_modules = None
        with self.evaluation(scene, programs) as evaluation:
            drawn = evaluation.drawn
            if self.options.frames is not None:
                with unless_unwritable(builder, "the values that drivers are compared by"):
                    stored_images.save(
                        self.options.frames, scene.case.id, scene.variant, drawn.images
                    )
                builder.set_drawn(drawn.images)
            builder.add_inactive_uniforms(drawn.inactive)
            evaluation.require_no_other_errors()
            if self.options.gl_calls:
                builder.set_gl_calls(evaluation.answer(Traced()))
            draws = None
            if self.options.modules is not False and FEATURES.self_check is not None:
                draws = FEATURES.self_check(evaluation, bool(self.options.modules))
            wrong_picture = None
            if folder is not None:  # it is packed while the scene is judged
                try:
                    self._write_picture(scene, programs, drawn.images, builder, writer)
                except MemoryError:
                    raise
                except Exception as error:
                    wrong_picture = error  # which changes no outcome
            unanswered = self.judge_all(evaluation, builder, writer, draws)
            if draws is not None:
                found, of_modules = draws.judgement()
                builder.set_self_check(found, draws.outside)
        if unanswered:
            names = {index: scene.expect[index].name for index in unanswered}
            lacking = {i: e for i, e in unanswered.items() if not isinstance(e, OtherApiError)}
            builder.set_not_asked(tuple(n for i, n in names.items() if i not in lacking))
            if lacking:
                listed = ", ".join(repr(names[index]) for index in lacking)
                builder.add_notice(f"not judged on this driver: {listed}")
            if lacking or len(unanswered) == len(scene.expect):
                builder.set_unanswered(next(iter((lacking or unanswered).values())))
        if of_modules is not None and (self.options.modules or of_modules.outcome.message):
            builder.add_outcome(of_modules.outcome, of_modules)
        if wrong_picture is not None:
            raise wrong_picture

    def _write_picture(
        self,
        scene: Scene,
        programs: Programs,
        images: Mapping[tuple[str, str], Image],
        builder: RecordBuilder,
        writer: PictureWriter,
    ) -> None:
        """Write the case's picture and those of its passes, in the size for people."""
        with doing("picture", "drawing the picture"):
            if (side := self.options.picture_size) != self.options.size:
                images = enlarged(self.backend, scene, programs, images, side)
            picture = images[_picture_of(scene, images)]
            with unless_unwritable(builder):
                builder.set_pictures(
                    writer.write_picture(picture), writer.write_passes(scene, images)
                )

    def judge_all(
        self,
        evaluation: Evaluation,
        builder: RecordBuilder,
        writer: PictureWriter,
        draws: SceneCheck | None = None,
    ) -> dict[int, UnsupportedError]:
        """Judge all expectations of a scene that was drawn, one after the other, and write the
        pictures of each; and its `draws`, those that expectations capture.

        Returns the numbers of the expectations that the driver has no answer for, and why.
        """
        explained = False
        unanswered = {}
        before_release = None if draws is None else draws.judge_captured
        for index, expectation in evaluation.by_turns(before_release):
            try:
                evaluation.gather(expectation)
            except UnsupportedError as error:
                unanswered[index] = error
                continue
            # The first failure is explained: others mostly fail for the same reason.
            explained |= self._judge(evaluation, builder, writer, index, explain=not explained)
        return unanswered

    def _judge(
        self,
        evaluation: Evaluation,
        builder: RecordBuilder,
        writer: PictureWriter,
        index: int,
        *,
        explain: bool,
    ) -> bool:
        """Judge one expectation and write its pictures. Returns whether it is a formula that fails,
        which gets an explanation if asked for one."""
        files, explanation = PictureFiles(), None
        expectation = evaluation.scene.expect[index]
        try:
            judgement = evaluation.judge(expectation)
            worst = judgement.outcome.worst
            with doing("picture"), unless_unwritable(builder):
                files = writer.write_comparison(
                    f"{index}-{expectation.name}",
                    judgement.pictures,
                    worst.pixel if worst else None,
                    passed=judgement.outcome.status == "pass",
                )
        except ShaderlabError as error:  # in a picture: of values that nothing else looked at
            judgement = Judgement(
                outcome=Outcome(
                    name=expectation.name,
                    kind=expectation.kind,
                    status="error",
                    message=told(error),
                )
            )
        failed = judgement.outcome.status == "fail" and isinstance(expectation, Formula)
        if failed and explain:
            assert isinstance(expectation, Formula)
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
        return failed

    def _explanation(
        self, evaluation: Evaluation, expectation: Formula, outcome: Outcome
    ) -> Explanation | None:
        """Where a failing formula goes wrong. Whatever hinders that changes no verdict."""
        if FEATURES.explain is None:
            return None
        scene, programs = evaluation.scene, evaluation.programs
        try:
            with (
                doing("judge", "explaining the failure"),
                self.evaluation(scene, programs, like=evaluation) as again,
            ):
                found = FEATURES.explain(again, expectation, outcome)
        except Exception as error:
            if os.environ.get("SHADERLAB_DEBUG") and not isinstance(error, ShaderlabError):
                raise
            pixel = (outcome.worst.pixel if outcome.worst else None) or (0, 0)
            said = error.message if isinstance(error, ShaderlabError) else repr(error)
            found = Explanation(pixel=pixel, steps=(), refused=said)
        pass_name, draw = expectation.key(scene)
        lower = list(filter(None, map(below_highp, programs[pass_name][draw].authored)))
        if found is None or not lower:
            return found
        return replace(found, verdict="; ".join(filter(None, (found.verdict, lower[0]))))


def _picture_of(scene: Scene, images: Mapping[tuple[str, str], Image]) -> tuple[str, str]:
    """The (pass, output) that is the case's picture: the one it names, or the last pass's first.

    Raises:
        CaseError: the case names an output that is not there.
    """
    named = scene.picture
    if named is None:
        last = scene.passes[-1].name
        return next(key for key in images if key[0] == last)
    if (named.pass_name, named.name) not in images:
        known = [".".join(key) for key in images]
        raise CaseError(
            f"there is no output {scene.case.picture!r} to be the picture",
            remedy=nearest(scene.case.picture, known),
        )
    return named.pass_name, named.name
