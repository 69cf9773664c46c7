"""Scenes compiled, and drawn on one open device."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import Self

from shaderlab.compiler.compile import Compiled
from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.engines import TARGETS
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.drivers import Backend, open_backend
from shaderlab.drivers.programs.prepare import Preparer, Programs
from shaderlab.errors import DriverError
from shaderlab.model.calls import CallEdit
from shaderlab.model.case import Case, Scene
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Verdict
from shaderlab.settings import settings_of

from . import packages
from .evaluation import Evaluation
from .search_path import shaders_of

_NO_TEXTS: Mapping[str, str | Path] = {}


class SceneDrawer:
    """Compiles scenes and draws them. A context manager; the device is opened on first use."""

    def __init__(
        self, options: RunOptions | None = None, notice: Callable[[str], None] | None = None
    ) -> None:
        self.options = options or RunOptions()
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
        require_compiled(programs)
        self.require_compute(scene)
        return programs

    def require_compute(self, scene: Scene) -> None:
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
            like: see `Evaluation`.

        Raises:
            ShaderError, UnsupportedError, CaseError: it can't be drawn.
        """
        preparer = self._preparer(_folder(scene))
        size = (self.options.size,) * 2
        with self.backend.session(scene, programs, size) as session:
            yield Evaluation(session, self.backend, preparer, like)

    @contextmanager
    def edited_evaluation(
        self, scene: Scene, programs: Programs, edit: CallEdit | None
    ) -> Iterator[Evaluation]:
        """As `evaluation`, with one call of the drawing made otherwise; see
        `Backend.edited_session`."""
        preparer = self._preparer(_folder(scene))
        size = (self.options.size,) * 2
        with self.backend.edited_session(scene, programs, size, edit) as session:
            yield Evaluation(session, self.backend, preparer)

    def prepare(self, scene: Scene) -> Programs:
        """The scene's programs, compiled for all of its targets; those that do not compile, too."""
        preparer, targets = self._preparer(_folder(scene)), self._targets(scene.case)
        return {p.name: tuple(preparer.prepare(d, targets) for d in p.draws) for p in scene.passes}

    def driver_verdict(self, sources: tuple[Source, ...]) -> Verdict:
        """The driver's own verdict on a program that compiles, asked for once."""
        if sources not in self._verdicts:
            self._verdicts[sources] = self.backend.driver_verdict(sources)
        return self._verdicts[sources]

    def _new_preparer(self, folder: str) -> Preparer:
        return Preparer(self._shaders(folder, self.options.replacements), cached_compiler())

    def _targets(self, case: Case) -> tuple[str, ...]:
        """What a case's programs are compiled for: what the run says, the case, or its project."""
        own = settings_of(Path(case.file).parent).targets
        return self.options.targets or tuple(case.targets) or own or TARGETS

    def _shaders(self, folder: str | Path, overrides: Mapping[str, str | Path]) -> Shaders:
        options = self.options
        return shaders_of(Path(folder), overrides, options.include, options.renames)


def require_compiled(programs: Programs) -> None:
    """Raise the compiler's first error where a program does not compile."""
    for draws in programs.values():
        for draw in draws:
            _ = draw.interface


def _folder(scene: Scene) -> str:
    return os.path.dirname(scene.case.file) or os.curdir


def _of_shaders(options: RunOptions) -> tuple[object, ...]:
    """What shaders are read by."""
    return options.replacements, options.renames, options.include


def _compile_for_opengl(sources: Sequence[Source], _: Sequence[str]) -> Compiled:
    """Compile for plain GLSL, which has the verdict, and OpenGL, which says what is declared."""
    return cached_compiler()(sources, ("glsl", "opengl")).only(["glsl"])
