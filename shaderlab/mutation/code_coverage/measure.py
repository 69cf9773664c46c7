"""Runs the scenes of a case with their points watched, and says what none of them saw."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from shaderlab.compiler.compile import Compiled
from shaderlab.compiler.sources import Source
from shaderlab.drivers.programs.prepare import PreparedDraw
from shaderlab.engine.expectations.reads import all_reads
from shaderlab.engine.lab import Lab
from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.files import display_path
from shaderlab.model.case import Scene
from shaderlab.model.records import CodeCoverage, CoverageGap

from .points import ITEMS, Point, wrapped
from .watching import WORD, watched

Place = tuple[str, int, int, str, str]
"""An author's file, line and column, the kind of point and its text."""


def code_coverage(lab: Lab, scenes: Iterable[Scene]) -> CodeCoverage:
    """What the judged draws of some scenes of one case exercised of their shaders.

    A point that several programs share, or several scenes run, was exercised if one of them did.

    Raises:
        UnsupportedError: the driver has no storage buffers, or refuses a watched program.
        ShaderError, CaseError: a scene can't be drawn.
    """
    seen: dict[tuple[Place, str], bool] = {}
    case_id = ""
    for scene in scenes:
        case_id = scene.case.id
        for item, now in _seen(lab, scene):
            seen[item] = seen.get(item, False) or now
    gaps = [
        CoverageGap(file=display_path(file), line=line, text=text, what=what)
        for (file, line, _, _, text), what in sorted(s for s, now in seen.items() if not now)
    ]
    return CodeCoverage(id=case_id, items=len(seen), gaps=tuple(dict.fromkeys(gaps)))


@dataclass
class _Watched:
    """The stages whose points are wrapped, each once, and where their bits are in the buffer."""

    stages: dict[Source, Source] = field(default_factory=dict)
    points: list[tuple[Source, Point, int]] = field(default_factory=list)
    words: int = 0

    def stage(self, source: Source) -> Source:
        """The stage with its points wrapped."""
        if source not in self.stages:
            text, points = wrapped(source.text)
            words = -(-sum(len(ITEMS[point.kind]) for point in points) // WORD)
            if points:
                text = watched(text, source.stage, self.words, words)
                self.points += [(source, point, self.words) for point in points]
                self.words += words
            self.stages[source] = replace(source, text=text if points else source.text)
        return self.stages[source]


def _seen(lab: Lab, scene: Scene) -> Iterator[tuple[tuple[Place, str], bool]]:
    """Each item of the points of a scene's judged stages, and whether it was seen."""
    every = _Watched()
    programs = {
        name: tuple(_watch(scene, (name, index), draw, every) for index, draw in enumerate(draws))
        for name, draws in lab.prepare_for_opengl(scene).items()
    }
    if not every.words:
        return
    with lab.backend.storage(every.words) as read:
        try:
            with lab.evaluation(scene, programs) as evaluation:
                for expectation in scene.expect:
                    evaluation.gather(expectation)
        except ShaderError as error:
            raise UnsupportedError(
                f"{scene.case.id}: this driver refuses a program whose branches are watched "
                f"({error.message.splitlines()[0]})",
                file=scene.case.file or None,
            ) from error
        buffer = read()
    for source, point, first in every.points:
        file, line = source.place(point.line)
        place = (file, line, point.column, point.kind, point.text)
        for i, what in enumerate(ITEMS[point.kind]):
            if what:
                word, bit = divmod(point.bit + i, WORD)
                yield (place, what), bool(int(buffer[first + word]) >> bit & 1)


def _watch(scene: Scene, key: tuple[str, int], draw: PreparedDraw, every: _Watched) -> PreparedDraw:
    """A draw with those of its stages watched that an expectation judges."""
    name, index = key
    reads = (r for r in all_reads(scene) if r.pass_name == name and r.draw in (None, index))
    read = {r.output for r in reads}
    judged = {"vertex", "geometry"} if read else set()
    if read & {*draw.outputs, "depth", "stencil", "coverage"}:
        judged.add("fragment")
    sources = (
        every.stage(source) if source in draw.authored and source.stage in judged else source
        for source in draw.sources
    )

    def compiled_as_it_was(_: Sequence[Source], targets: Sequence[str]) -> Compiled:
        return draw.compiling(draw.sources[:1], targets)

    return replace(draw, sources=tuple(sources), compiling=compiled_as_it_was)
