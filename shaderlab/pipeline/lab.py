"""The lab: one open device and its program cache, running scenes one after the other."""

from __future__ import annotations

import os
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import Self, TypeVar

from shaderlab import packages
from shaderlab.activity import Activity, doing
from shaderlab.backends import Backend, Drawn, Session, open_backend
from shaderlab.checks import Judgement, judge
from shaderlab.checks.refusals import Answer, Complaint
from shaderlab.errors import (
    AssetError,
    DriverError,
    ShaderlabError,
    UnsupportedError,
)
from shaderlab.frame import Frame, PassDraw, Reply
from shaderlab.glsl.compile_cache import cached_compiler
from shaderlab.glsl.sources import Source
from shaderlab.model import GlCall, GlError, Scene, Sweep, Value
from shaderlab.options import RunOptions
from shaderlab.pipeline import plan, refusals, stored_images
from shaderlab.pipeline.picture_writer import PictureFiles, PictureWriter
from shaderlab.pipeline.record_builder import RecordBuilder
from shaderlab.pipeline.roots import shaders_beside
from shaderlab.programs.prepare import Preparer, Programs, step
from shaderlab.records import Outcome, Record, Verdict

Got = TypeVar("Got")


class Lab:
    """Runs scenes and gives their records. A context manager; the device is opened on first use."""

    def __init__(
        self, options: RunOptions | None = None, notice: Callable[[str], None] | None = None
    ) -> None:
        self.options = options or RunOptions()
        self._notice = notice
        self.exhausted = False  # whether memory ran out in it
        self._backend: Backend | None = None
        self._opinions: dict[tuple[Source, ...], Verdict] = {}
        self._preparer = lru_cache(maxsize=64)(self._preparer_beside)

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
        if options.shaders != self.options.shaders:
            self._preparer.cache_clear()
        self.options = options

    def close(self) -> None:
        """Give the device back; the lab opens it again if it is used once more."""
        if self._backend is not None:
            self._backend.close()
            self._backend = None

    @property
    def backend(self) -> Backend:
        """The device, opened now if it is not open yet. Raises DriverError."""
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
        return builder.build(time.perf_counter() - started, activity.ordered())

    def _run(self, scene: Scene, builder: RecordBuilder) -> None:
        preparer = self._preparer(str(Path(scene.case.file).parent))
        with doing("compile", "compiling"):
            prepared = {p.name: tuple(preparer.prepare(d) for d in p.draws) for p in scene.passes}
        writer = PictureWriter(self.options.picture_folder, scene.case.id, scene.variant)

        def assembly(modules: Mapping[str, bytes]) -> str:
            file = ""
            with _unless_unwritable(builder):
                file = writer.write_assembly(modules)
            return file

        builder.add_programs(prepared, assembly)
        for draws in prepared.values():
            for draw in draws:
                _ = draw.interface  # raises the compiler's first error where there is one
        plans = plan.plan(scene, prepared)
        with doing("link"):
            builder.add_driver_verdicts(self._opinion)
            said = refusals.gathered(scene, preparer, self._opinion)
        size = (self.options.size,) * 2
        picture_size = 0 if self.options.picture_folder is None else self.options.picture_size
        builder.set_device(self.driver, self.options.size, picture_size)
        with doing("draw"), self.backend.session(scene, prepared, size) as session:
            drawn = session.draw()
            frame = _frame(session, drawn, plans)
        if self.options.frames is not None:
            stored_images.save(self.options.frames, scene.case.id, scene.variant, drawn.images)
        builder.add_inactive_uniforms(drawn.inactive)
        _expect_no_errors(scene, drawn)
        self._judge(scene, frame, said, builder, writer)
        if self.options.picture_folder is not None:
            with doing("picture", "drawing the picture"):
                self._write_pictures(scene, self._enlarged(scene, prepared, drawn), builder, writer)

    def _opinion(self, sources: tuple[Source, ...]) -> Verdict:
        """The driver's own verdict on a program, asked for once."""
        if sources not in self._opinions:
            self._opinions[sources] = self.backend.driver_verdict(sources)
        return self._opinions[sources]

    def _judge(
        self,
        scene: Scene,
        frame: Frame,
        said: Mapping[int, Answer | Complaint],
        builder: RecordBuilder,
        writer: PictureWriter,
    ) -> None:
        for index, expectation in enumerate(scene.expect):
            seen = PictureFiles()
            try:
                with doing("judge", f"judging {expectation.name!r}"):
                    found = judge(index, scene, frame, said)
                worst = found.outcome.worst
                with doing("picture"), _unless_unwritable(builder):
                    seen = writer.write_comparison(
                        f"{index}-{expectation.name}",
                        found.pictures,
                        worst.pixel if worst else None,
                    )
            except ShaderlabError as error:  # in a picture: of values that nothing else looked at
                kind = type(expectation).__name__.lower()
                outcome = Outcome(
                    name=expectation.name, kind=kind, status="error", message=str(error)
                )
                found = Judgement(outcome=outcome)
            outcome = replace(
                found.outcome, images=seen.files, captions=seen.captions, values=seen.values
            )
            builder.add_outcome(outcome, found, expectation)

    def _enlarged(self, scene: Scene, prepared: Programs, drawn: Drawn) -> Drawn:
        """The scene in the size for people: drawn once more, but where it has one size only."""
        if self.options.picture_size == self.options.size or all(
            description.target.size for description in scene.passes
        ):
            return drawn
        with self.backend.session(scene, prepared, (self.options.picture_size,) * 2) as session:
            return session.draw()

    def _write_pictures(
        self, scene: Scene, drawn: Drawn, builder: RecordBuilder, writer: PictureWriter
    ) -> None:
        wanted = plan.picture_of(scene, drawn.images)
        with _unless_unwritable(builder):
            builder.set_pictures(
                writer.write_picture(drawn.images[wanted]),
                writer.write_passes(scene, drawn.images),
            )

    def _preparer_beside(self, folder: str) -> Preparer:
        return Preparer(shaders_beside(Path(folder), self.options.shaders), cached_compiler())


@contextmanager
def _unless_unwritable(builder: RecordBuilder) -> Iterator[None]:
    """A file for people that can't be written, on a full disk say, changes no verdict: it is a
    notice."""
    try:
        yield
    except AssetError as error:
        builder.add_notice(error.message)
    except OSError as error:
        builder.add_notice(f"can't write a picture ({error.strerror or error})")


def _defect(error: Exception) -> ShaderlabError:
    """An error that nobody foresaw, with the place in the code where it happened."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return ShaderlabError(
        f"unforeseen {type(error).__name__}: {error}",
        file=place.filename,
        line=place.lineno,
        remedy="this is a defect of shaderlab; SHADERLAB_DEBUG=1 shows the whole traceback",
    )


def _frame(session: Session, drawn: Drawn, plans: plan.Plan) -> Frame:
    """The pictures just drawn, with everything else that the checks need."""
    probes = {}
    for index in plans.probes:
        expectation = session.scene.expect[index]
        assert isinstance(expectation, Sweep | Value)
        with doing("draw", f"sampling for {expectation.name!r}"):
            probes[index] = plan.probe(session, drawn.bindings, expectation)
    return Frame(
        images=drawn.images,
        order=tuple(p.name for p in session.scene.passes),
        bindings=drawn.bindings,
        fragments={
            key: _captured(session.fragments, session, key) for key in sorted(plans.fragments)
        },
        vertices={key: _captured(session.vertices, session, key) for key in sorted(plans.vertices)},
        probes=probes,
        gl_errors=drawn.gl_errors,
        replies={index: _replied(session, index) for index in plans.calls},
        sample_positions=drawn.sample_positions,
        attributes={key: session.attributes(key) for key in sorted(plans.attributes)},
        blocks={key: session.blocks(key) for key in sorted(plans.blocks)},
        queries={
            (name, index, counter): session.count((name, index), counter)
            for name, index, counter in sorted(plans.queries)
        },
        timings={name: session.time(name, repeats) for name, repeats in plans.timings.items()},
        locations={key: session.locations(key) for key in sorted(plans.located)},
    )


def _replied(session: Session, index: int) -> Reply:
    expectation = session.scene.expect[index]
    assert isinstance(expectation, GlCall)
    with doing("draw", f"calling {expectation.call}"):
        return session.call(expectation)


def _captured(capturing: Callable[[PassDraw], Got], session: Session, key: PassDraw) -> Got:
    with doing("draw", f"capturing the inputs of {step(key, session.programs[key[0]][key[1]])}"):
        return capturing(key)


def _expect_no_errors(scene: Scene, drawn: Drawn) -> None:
    """Raise for a GL error that no expectation is about."""
    from shaderlab.checks import draw_key
    from shaderlab.checks.plain import error_name

    expected = {
        draw_key(scene, e.pass_name, e.draw) for e in scene.expect if isinstance(e, GlError)
    }
    for (pass_name, index), errors in drawn.gl_errors.items():
        if (pass_name, index) not in expected:
            names = ", ".join(error_name(code) for code in errors)
            raise DriverError(f"draw {index} of pass {pass_name!r} raises {names}")
