"""portable: conforming devices draw nearly the same, at highp or at mediump."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Literal

import numpy as np

from shaderlab.analysis.audit import Spread, spread
from shaderlab.analysis.inputs import given_fragments, inputs_of
from shaderlab.analysis.interpreter import load
from shaderlab.engine.expectations.base import Context, OutputExpectation
from shaderlab.engine.expectations.needs import CapturedFragments
from shaderlab.errors import CaseError, nearest
from shaderlab.model.activity import doing
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Frame, PassDraw
from shaderlab.model.records import Row

_MOST = 2048  # invocations


@dataclass(frozen=True)
class SpreadOf(Need):
    """How far devices may differ at the outputs of a draw's fragment shader, on what it got."""

    key: PassDraw
    precision: str

    def answer(self, context: Context) -> list[Spread]:
        draw = context.session.programs[self.key[0]][self.key[1]]
        source = next(one for one in draw.sources if one.stage == "fragment")
        fragments = CapturedFragments(self.key).answer(context)
        given = given_fragments(fragments, context.bindings[self.key], _MOST)
        if not given.count:
            raise CaseError("portable: the draw has no fragment to ask about")
        program = load(source)
        with doing("judge", f"asking how portable {source.name} is"):
            return spread(program, given, inputs_of(program), (self.precision,))


@dataclass(frozen=True)
class Portable(OutputExpectation):
    """Devices differ by no more than `codes` codes of 8 bits at an output of a fragment shader, on
    what a draw gives it.

    At "highp" that is what the precision rules allow two conforming devices. At "mediump" it is
    what sampled devices of 16 bits are off: what the shader declares as mediump is computed so,
    or everything where it declares nothing.

    Args:
        output: the fragment shader's, with its pass before it where there are several.
        codes: how far they may be apart.
        precision: "highp" or "mediump".
        draw: which draw of the pass.
        name: how outcomes call it.
    """

    kind = "portable"

    output: str
    _: KW_ONLY
    codes: float = 1.0
    precision: Literal["highp", "mediump"] = "highp"

    @property
    def default_name(self) -> str:
        return f"portable {self.output} at {self.precision}"

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        if self.judges_vertices(scene, programs):
            raise CaseError(f"portable: {self.output!r} is no fragment shader's output")
        yield SpreadOf(self.key(scene), self.precision)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        found: list[Spread] = frame.answers[SpreadOf(self.key(scene), self.precision)]
        known = {one.output: one for one in found}
        name = self.own_name(scene)
        if name not in known:
            raise CaseError(
                f"portable: nothing can be said of {name!r}", remedy=nearest(name, known)
            )
        one = known[name]
        message = ""
        if one.codes > self.codes:
            message = str(one)
        elif one.unbounded:
            message = f"the rules bound nothing at {100.0 * one.unbounded:.3g} % of pixels"
        row = Row(
            label=name,
            expected=f"at most {self.codes:g} codes apart",
            measured="no number" if np.isinf(one.codes) else f"{one.codes:.3g} codes",
            ok=not message,
        )
        return self.judge_rows([row], message, judged=1)


portable = Portable
