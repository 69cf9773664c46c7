"""What kinds of expectation share: what is about one draw or one output, and what scenes read."""

import functools
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from shaderlab.compiler.sources import Source
from shaderlab.drivers import Session
from shaderlab.drivers.programs.captures import vertex_output_names
from shaderlab.drivers.programs.prepare import Preparer, describe_draw
from shaderlab.errors import CaseError, Verdict, suggest
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation, Judgement, Programs, Read, TypedNeed
from shaderlab.model.frame import Answer, Bindings, Frame, PassDraw
from shaderlab.model.records import Row
from shaderlab.model.scene import Pass, Pixel


@dataclass(frozen=True)
class Context:
    """What requests are answered from: the scene on the device, the compilers, the driver.

    `bindings` are the uniforms and textures that each draw got; `driver_verdict` gives the driver's
    own verdict on a program, and raises DriverError for a stage that the driver lacks.
    """

    session: Session
    bindings: Mapping[PassDraw, Bindings]
    preparer: Preparer
    driver_verdict: Callable[[tuple[Source, ...]], Verdict]

    def describe_draw(self, key: PassDraw) -> str:
        """A draw in words: what is to blame if the driver goes down with it."""
        return describe_draw(key, self.session.programs[key[0]][key[1]])

    def shorten_paths(self, text: str) -> str:
        """The text with the folders of the case and of the shaders left out of its paths.

        A folder alone keeps its own name: of "/a/b/x.frag:3 is not in /a/b" there remains
        "x.frag:3 is not in b".
        """
        for folder in self._folders:
            text = text.replace(f"{folder}/", "").replace(folder, Path(folder).name)
        return text

    @functools.cached_property
    def _folders(self) -> list[str]:
        # A case that was named by a relative path has errors with absolute ones.
        named = (Path(self.session.scene.case.file).parent, *self.preparer.folders)
        found = {str(f) for folder in named for f in (folder, folder.resolve()) if f.parts}
        return sorted(found, key=len, reverse=True)


@dataclass(frozen=True)
class SessionQuery(TypedNeed[Answer]):
    """What the session answers: one of `shaderlab.drivers.QUERIES`, and its arguments."""

    question: str
    about: tuple[Hashable, ...]

    def answer(self, context: Context) -> Answer:
        found: Answer = context.session.query(self.question, *self.about)
        return found


@dataclass(frozen=True, kw_only=True)
class Demand(Expectation):
    """What a specification demands of drivers. `departs` has those that are known to do otherwise:
    a part of the vendor's name → the first word of what such a driver answers."""

    departs: Mapping[str, str] | None = None

    def judge_demand(self, rows: Sequence[Row], message: str, frame: Frame) -> Judgement:
        """Judge a table's rows; a known departure passes, with a message that names it."""
        judgement = self.judge_rows(rows, message, judged=len(rows) or 1)
        wrong = {row.measured.split(" ")[0] for row in rows if not row.ok}
        for vendor, known in (self.departs or {}).items():
            if vendor in frame.vendor and wrong == {known}:
                note = f"a known departure of {vendor}'s driver from the specification: {message}"
                passed = replace(judgement.outcome, status="pass", message=note)
                return Judgement(outcome=passed)
        return judgement


@dataclass(frozen=True, kw_only=True)
class DrawExpectation(Expectation):
    """An expectation of one draw: of the pass `pass_name` (the last one by default), the draw
    `draw` (negative numbers count from the last)."""

    pass_name: str | None = None
    draw: int = -1

    def key(self, scene: Scene) -> PassDraw:
        """The pass and draw. Raises CaseError if they do not exist."""
        return scene.draw_key(self.pass_name, self.draw)

    def passes(self, scene: Scene) -> frozenset[str]:
        return frozenset({self.key(scene)[0]})


@dataclass(frozen=True, kw_only=True)
class OutputExpectation(Expectation):
    """An expectation of one output of one draw.

    `output` is named as the fragment shader spells it ("FragColor"), with its pass before it where
    there are several ("shadow.FragColor"; without, the last pass is meant), or as the vertex
    shader spells it ("gl_Position" or any of its `out` variables): then every vertex is judged.
    Where a geometry stage follows, "gl_Position" is that stage's, and "gl_in.gl_Position" the
    vertex stage's.

    `discards` says which fragments the draw's program throws away: a reference that is true for
    those, a comparison of its inputs. It holds for all draws of that fragment shader. Without one,
    a draw shows all that its geometry covers.
    """

    named = "{self.output}"
    output: str
    draw: int = -1
    discards: Callable[..., Any] | None = None

    def key(self, scene: Scene) -> PassDraw:
        """The pass and draw that the output comes from. Raises CaseError if there is none."""
        return scene.draw_key(scene.split_output(self.output)[0], self.draw)

    def own_name(self, scene: Scene) -> str:
        return scene.split_output(self.output)[1]

    def find_reads(self, scene: Scene) -> Iterable[Read]:
        pass_name, draw = self.key(scene)
        yield Read(pass_name, self.own_name(scene), draw=draw)

    def passes(self, scene: Scene) -> frozenset[str]:
        return frozenset(read.pass_name for read in self.find_reads(scene))

    def judges_vertices(self, scene: Scene, programs: Programs) -> bool:
        key, name = self.key(scene), self.own_name(scene)
        if any(name in draw.outputs for draw in programs[key[0]]):
            return False
        return not self.is_of_depth(scene, programs) and self.is_of_vertex(scene, programs)

    def is_of_depth(self, scene: Scene, programs: Programs) -> bool:
        """Whether the output's name means its pass's depth or stencil, and no shader's output."""
        key, name = self.key(scene), self.own_name(scene)
        if scene.find_pass(key[0]).target.depth is None or name not in ("depth", "stencil"):
            return False
        return name not in programs[key[0]][key[1]].interface.outputs

    def is_of_vertex(self, scene: Scene, programs: Programs) -> bool:
        """Whether a vertex stage writes the output, and not a fragment stage. Raises CaseError: no
        stage writes it; names those that are written."""
        key = self.key(scene)
        draw, name = programs[key[0]][key[1]], self.own_name(scene)
        if name in draw.outputs:
            return False
        generated = draw.draw.mesh is None  # the lab's own stage, which only gives gl_Position
        known = [] if generated and name != "gl_Position" else vertex_output_names(draw)
        if name not in known:
            outputs = [*draw.outputs, *known]
            raise CaseError(f"there is no output {name!r}", remedy=suggest(name, outputs))
        if generated:
            raise CaseError(
                f"{name!r} belongs to the lab's own vertex stage: draw a mesh to judge it"
            )
        return True


Named = tuple[str, str]
"""A pass and an output of one of its stages."""


def judged_outputs(scenes: Iterable[Scene]) -> dict[Named, frozenset[Pixel] | None]:
    """What any expectation of these scenes reads, directly or through a later pass: of each output
    some pixels, or all of it (None)."""
    found: dict[Named, frozenset[Pixel] | None] = {}
    for scene in scenes:
        for read in all_reads(scene):
            name = (read.pass_name, read.output)
            known = found.get(name, frozenset())
            found[name] = None if read.pixel is None or known is None else known | {read.pixel}
    return found


def unread_outputs(scene: Scene, programs: Programs) -> tuple[str, ...]:
    """The outputs of fragment and compute shaders that no expectation of the scene reads, nor any
    pass that an expectation reads: "pass.output", or "pass.output of draw 0" where other draws'
    are read.

    An output that is read at single pixels alone is among them.
    """
    read = {(r.pass_name, r.draw, r.output) for r in all_reads(scene) if r.pixel is None}
    found: list[str] = []
    for description in scene.passes:
        draws = [list(draw.outputs) for draw in programs[description.name]]
        if description.target.colors is not None:  # what has no attachment is stored nowhere
            draws = [[n for n in names if n in description.target.colors] for names in draws]
        for output in dict.fromkeys(name for draw in draws for name in draw):
            if (description.name, None, output) in read:
                continue
            writing = [index for index, names in enumerate(draws) if output in names]
            missing = [i for i in writing if (description.name, i, output) not in read]
            whole = f"{description.name}.{output}"
            if missing == writing:
                found.append(whole)
            else:
                found += [f"{whole} of draw {index}" for index in missing]
    return tuple(found)


def all_reads(scene: Scene) -> Iterator[Read]:
    """What expectations read, and what the passes that they read got from earlier ones."""
    used: dict[str, set[str]] = {}
    direct = [read for expectation in scene.expect for read in expectation.find_reads(scene)]
    for read in direct:
        used.setdefault(read.pass_name, set()).add(read.output)
        yield read
    for description in reversed(scene.passes):
        outputs = used.get(description.name)
        if outputs is not None:
            for read in _reads_of_pass(description, outputs):
                used.setdefault(read.pass_name, set()).add(read.output)
                yield read


def _reads_of_pass(description: Pass, outputs: Iterable[str]) -> Iterator[Read]:
    for draw in description.draws:
        for source in draw.outputs_read():
            yield Read(source.pass_name, source.name)
    if description.onto:
        for output in sorted(outputs):
            yield Read(description.onto, output)
