"""same_as: a draw's shader computes what an approved one does."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass

from shaderlab.engine.expectations.base import Context, DrawExpectation
from shaderlab.engine.expectations.needs import CapturedFragments, CapturedVertices
from shaderlab.errors import CaseError, nearest
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs, Read
from shaderlab.model.frame import Frame, PassDraw
from shaderlab.model.phases import phase
from shaderlab.model.records import Row

from .answer import Answer
from .batches import fragment_batch, vertex_batch
from .comparison import Plan, compare_programs
from .interpreter import load

_MOST = 2048  # invocations
_PLAN = Plan(rounds=1, accuracy=False)


@dataclass(frozen=True)
class ComparedWith(Need):
    """How the shader of a draw compares with an approved one of its stage, on what it got."""

    key: PassDraw
    approved: str

    def answer(self, context: Context) -> Answer:
        source = context.preparer.source(self.approved)
        draw = context.session.programs[self.key[0]][self.key[1]]
        own = next((one for one in draw.sources if one.stage == source.stage), None)
        if own is None or source.stage not in ("fragment", "vertex"):
            raise CaseError(f"same_as: the draw has no {source.stage} shader to compare")
        bindings = context.bindings[self.key]
        if source.stage == "fragment":
            fragments = CapturedFragments(self.key).answer(context)
            batch = fragment_batch(fragments, bindings, _MOST)
        else:
            batch = vertex_batch(CapturedVertices(self.key).answer(context), bindings, _MOST)
        if not batch.count:
            raise CaseError("same_as: the draw has no invocation to compare on")
        with phase("judge", f"comparing {own.name} with {self.approved}"):
            return compare_programs(load(source), load(own), _PLAN, [batch])


@dataclass(frozen=True)
class SameAs(DrawExpectation):
    """A draw's fragment shader, or its vertex shader, computes the same mathematics as `approved`,
    a shader that somebody looked at and found right: on all inputs that it got in the scene, and on
    others like them.

    Args:
        approved: the shader's name, as `Draw` has it; its extension tells the stage.
        outputs: which outputs are held against it.
        pass_name: the pass; the last one by default.
        draw: which draw of it.
        name: how outcomes call it.
    """

    kind = "same as"

    approved: str
    _: KW_ONLY
    outputs: Sequence[str] = ("FragColor",)

    @property
    def default_name(self) -> str:
        return f"same as {self.approved}"

    def __post_init__(self) -> None:
        if not self.outputs or isinstance(self.outputs, str):
            raise CaseError(f"same_as {self.approved!r}: outputs is a sequence of names")

    def reads(self, scene: Scene) -> Iterable[Read]:
        pass_name, draw = self.key(scene)
        for output in self.outputs:
            yield Read(pass_name, output, draw=draw)

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield ComparedWith(self.key(scene), self.approved)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        answer: Answer = frame.answers[ComparedWith(self.key(scene), self.approved)]
        known = {output.name: output for output in answer.outputs}
        rows = []
        for name in self.outputs:
            if name not in known:
                raise CaseError(
                    f"same_as: there is no output {name!r}", remedy=nearest(name, known)
                )
            words = str(known[name]).partition(": ")[2]
            rows.append(
                Row(label=name, expected="the same", measured=words, ok=known[name].same is True)
            )
        message = "; ".join(f"{row.label} {row.measured}" for row in rows if not row.ok)
        judged = sum(known[name].judged for name in self.outputs)
        return self.judge_rows(rows, message, judged=judged)


same_as = SameAs
