"""Judging scenes one expectation at a time: nothing is drawn, captured or probed before it is
asked for, no pictures are made, and shaders can be replaced from one trial to the next.

This is for whoever judges many versions of one shader; `Lab` judges one version in full.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from shaderlab.backends import Drawn, Session, open_backend
from shaderlab.checks import draw_key, judge, outputs_read, split_output
from shaderlab.frame import Array, Bindings, Fragments, Frame, Image, PassDraw, Reply, Samples
from shaderlab.glsl.compile import Compiled
from shaderlab.glsl.compile_cache import cached_compiler
from shaderlab.glsl.sources import Source
from shaderlab.model import (
    AttributeLayout,
    BlockLayout,
    CompileFails,
    Computed,
    Cost,
    Coverage,
    Exact,
    Expectation,
    GlCall,
    GlError,
    InactiveUniforms,
    Measure,
    Output,
    Query,
    Refused,
    Scene,
    programs_of,
)
from shaderlab.pipeline import plan
from shaderlab.pipeline.roots import shaders_beside
from shaderlab.programs import bind
from shaderlab.programs.formats import shape_of
from shaderlab.programs.prepare import PreparedDraw, Preparer, Programs
from shaderlab.programs.stages import may_keep_out
from shaderlab.programs.varyings import elements
from shaderlab.records import Outcome

Texts = Mapping[str, str]


class Bench:
    """An open device on which trials are made. A context manager.

    Args:
        size: side in pixels of the square frame that is judged, where a case does not say.
        driver: as in `shaderlab.backends.open_backend`.
    """

    def __init__(self, size: int = 64, driver: str | None = None) -> None:
        self._size = size
        self._backend = open_backend(driver)
        self._originals: dict[str, Preparer] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._backend.close()

    @property
    def renderer(self) -> str:
        """What draws."""
        return self._backend.info["renderer"]

    def prepare(self, scene: Scene, texts: Texts) -> Programs:
        """The scene's programs, compiled for OpenGL alone, with some shaders' texts replaced.

        Raises:
            ShaderError, CaseError: a program does not compile, or does not fit the scene's data.
        """
        folder = Path(scene.case.file).parent
        preparer = _preparer(folder, texts)
        if not texts:
            preparer = self._originals.setdefault(str(folder), preparer)
        prepared = {p.name: tuple(preparer.prepare(d) for d in p.draws) for p in scene.passes}
        for draw in (draw for draws in prepared.values() for draw in draws):
            _ = draw.interface  # raises the compiler's first error where there is one
        return prepared

    @contextmanager
    def trial(
        self, scene: Scene, prepared: Programs, *, like: Trial | None = None
    ) -> Iterator[Trial]:
        """Draw a scene and keep it on the device for judging.

        Args:
            scene: what to draw.
            prepared: its programs, from `prepare`.
            like: a trial of the same scene with the shaders' own texts, or None if this is it:
                its programs and captured inputs are used again where they must be the same.

        Raises:
            ShaderError, UnsupportedError, CaseError: as `Session.run`.
        """
        size = (self._size,) * 2
        # What a replaced text is linked to goes away with its trial.
        with self._backend.session(
            scene, prepared, size, temporary_programs=like is not None
        ) as session:
            yield Trial(session, session.draw(), like)


@dataclass
class Trial:
    """One scene as it was drawn; captures and probes are made when they are first asked for.

    Attributes:
        session: the scene on the device; of use only while the trial is open.
        drawn: what drawing it gave.
        like: the trial that may be borrowed from.
    """

    session: Session
    drawn: Drawn
    like: Trial | None

    def __post_init__(self) -> None:
        self._fragments: dict[PassDraw, Fragments] = {}
        self._vertices: dict[PassDraw, Samples] = {}
        self._probes: dict[int, Samples] = {}

    @property
    def scene(self) -> Scene:
        """What was drawn."""
        return self.session.scene

    @property
    def bindings(self) -> Mapping[PassDraw, Bindings]:
        """Uniforms and textures by (pass, draw)."""
        return self.drawn.bindings

    @property
    def images(self) -> Mapping[tuple[str, str], Image]:
        """Attachments by (pass, output)."""
        return self.drawn.images

    @property
    def gl_errors(self) -> Mapping[PassDraw, tuple[int, ...]]:
        """As in `Frame`."""
        return self.drawn.gl_errors

    @property
    def captured_fragments(self) -> Mapping[PassDraw, Fragments]:
        """The captures of fragments made so far."""
        return self._fragments

    @property
    def captured_vertices(self) -> Mapping[PassDraw, Samples]:
        """The captures of vertices made so far."""
        return self._vertices

    def draw(self, key: PassDraw) -> PreparedDraw:
        """One draw of the scene, compiled."""
        return self.session.programs[key[0]][key[1]]

    def inputs_of(self, key: PassDraw) -> dict[str, tuple[tuple[int, ...], str]]:
        """The fragment inputs that `sample` takes: each one's shape and GLSL type."""
        declared = self.draw(key).interface.varyings
        return {v.name: (shape_of(v.type), v.type) for v in elements(declared.values())}

    def uniform_types(self, key: PassDraw) -> dict[str, str]:
        """The GLSL type of each uniform and each member of a uniform block."""
        return {n: v.type for n, v in bind.declared(self.draw(key).interface).items()}

    def fragments(self, key: PassDraw) -> Fragments:
        """What a draw's fragment shader got."""
        if key not in self._fragments:
            same = self.like is not None and self._gets_the_same(key[0], self.like)
            self._fragments[key] = (
                self.like.fragments(key)
                if same and self.like is not None
                else self.session.fragments(key)
            )
        return self._fragments[key]

    def vertices(self, key: PassDraw) -> Samples:
        """What a draw's vertex shader got and gave."""
        if key not in self._vertices:
            own, like = self.draw(key), self.like
            same = like is not None and all(
                own.text(stage) == like.draw(key).text(stage) for stage in ("vertex", "geometry")
            )
            self._vertices[key] = (
                like.vertices(key) if same and like else self.session.vertices(key)
            )
        return self._vertices[key]

    def probe(self, index: int) -> Samples:
        """What expectation `index`, a `value` or a `sweep`, has the program run on."""
        if index not in self._probes:
            expectation: Any = self.scene.expect[index]
            self._probes[index] = plan.probe(self.session, self.bindings, expectation)
        return self._probes[index]

    def sample(
        self, key: PassDraw, inputs: Mapping[str, Array], uniforms: Mapping[str, Array]
    ) -> Samples:
        """Run a draw's fragment stage on inputs and uniforms of one's own."""
        bindings = replace(self.bindings[key], uniforms={**self.bindings[key].uniforms, **uniforms})
        return self.session.probe_fragments(key, bindings, inputs)

    def sample_vertices(
        self, key: PassDraw, inputs: Mapping[str, Array], uniforms: Mapping[str, Array]
    ) -> Samples:
        """The same for the vertex stage of a draw of a mesh."""
        bindings = replace(self.bindings[key], uniforms={**self.bindings[key].uniforms, **uniforms})
        return self.session.probe_vertices(key, bindings, inputs)

    def judge(self, index: int) -> Outcome:
        """The outcome of expectation `index`; what no shader has a part in passes unread.

        Raises:
            CaseError, FormulaError: as `shaderlab.checks.judge`.
        """
        expectation = self.scene.expect[index]
        if _without_shaders(expectation):
            return Outcome(name=expectation.name, kind="skipped", status="pass")
        return judge(index, self.scene, self._frame(index, expectation), {}).outcome

    def _frame(self, index: int, expectation: Expectation) -> Frame:
        """No more than this expectation needs."""
        wants = plan.plan(replace(self.scene, expect=(expectation,)), self.session.programs)
        fragments = {key: self.fragments(key) for key in wants.fragments}
        vertices = {key: self.vertices(key) for key in wants.vertices}
        probes = {index: self.probe(index)} if wants.probes else {}
        replies: dict[int, Reply] = {}
        if isinstance(expectation, GlCall):
            replies[index] = self.session.call(expectation)
        return Frame(
            images=self.images,
            order=tuple(p.name for p in self.scene.passes),
            bindings=self.bindings,
            fragments=fragments,
            vertices=vertices,
            probes=probes,
            gl_errors=self.gl_errors,
            replies=replies,
            sample_positions=self.drawn.sample_positions,
            attributes={key: self.session.attributes(key) for key in wants.attributes},
            blocks={key: self.session.blocks(key) for key in wants.blocks},
            queries={
                (name, at, counter): self.session.count((name, at), counter)
                for name, at, counter in wants.queries
            },
            locations={key: self.session.locations(key) for key in wants.located},
        )

    def _gets_the_same(self, pass_name: str, other: Trial) -> bool:
        """Whether the fragment shaders of a pass must get the same inputs as in another trial."""
        for own, theirs in zip(
            self.session.programs[pass_name], other.session.programs[pass_name], strict=True
        ):
            if own.draw is not theirs.draw:
                return False  # other state may let other fragments through
            for stage in ("vertex", "geometry"):
                if own.text(stage) != theirs.text(stage):
                    return False
            fragment, other_fragment = own.text("fragment") or "", theirs.text("fragment") or ""
            if fragment != other_fragment and may_keep_out(fragment + other_fragment):
                return False
        return True


def judged_passes(scene: Scene) -> dict[int, frozenset[str]]:
    """For each expectation of the scene, the passes it is about: several where it compares
    them, none where no shader has a part."""
    found: dict[int, frozenset[str]] = {}
    for index, expectation in enumerate(scene.expect):
        if _without_shaders(expectation):
            found[index] = frozenset()
        elif isinstance(expectation, GlCall):
            named = programs_of(expectation)
            found[index] = frozenset(draw_key(scene, p.pass_name, p.draw)[0] for p in named)
        elif isinstance(expectation, Measure):
            key = draw_key(scene, expectation.pass_name, expectation.draw)
            found[index] = frozenset({key[0], *(p for p, _ in outputs_read(expectation, scene))})
        elif isinstance(
            expectation,
            Coverage | GlError | InactiveUniforms | Query | AttributeLayout | BlockLayout,
        ):
            found[index] = frozenset({draw_key(scene, expectation.pass_name, expectation.draw)[0]})
        else:
            name, _ = split_output(getattr(expectation, "output", ""), scene)
            found[index] = frozenset({scene.find_pass(name).name})
            if isinstance(expectation, Exact) and isinstance(expectation.equals, Output):
                found[index] |= {expectation.equals.pass_name}
            if isinstance(expectation, Exact) and isinstance(expectation.equals, Output):
                found[index] |= {expectation.equals.pass_name}
    return found


def _without_shaders(expectation: Expectation) -> bool:
    """Whether no shader of the case has a part in what is expected."""
    if isinstance(expectation, GlCall):
        return not programs_of(expectation)
    return isinstance(expectation, Computed | CompileFails | Refused | Cost)


class _OpenGLOnly(Preparer):
    """Compiles for plain GLSL, which has the verdict, and OpenGL, which says what is declared;
    leaves Vulkan out."""

    def compile(self, sources: tuple[Source, ...]) -> Compiled:
        if sources not in self._compiled:
            whole = self._compiling(sources, ("glsl", "opengl"))
            self._compiled[sources] = whole.only(["glsl"])
        return self._compiled[sources]


def _preparer(folder: Path, texts: Texts) -> Preparer:
    return _OpenGLOnly(shaders_beside(folder, texts), cached_compiler())
