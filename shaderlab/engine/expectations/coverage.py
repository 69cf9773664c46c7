"""coverage: exactly this many pixels show a draw in the end."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass

import numpy as np

from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs, Read
from shaderlab.model.frame import Frame
from shaderlab.model.records import Row

from .base import OfDraw, judge_rows
from .needs import CapturedFragments


@dataclass(frozen=True)
class Coverage(OfDraw):
    """Exactly `pixels` pixels show the draw in the end: those that it covers, that pass every test
    and are not discarded, and that no later draw of the pass covers."""

    kind = "coverage"

    pixels: int
    _: KW_ONLY
    name: str = "coverage"

    def reads(self, scene: Scene) -> Iterable[Read]:
        yield Read(self.key(scene)[0], "coverage")

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield CapturedFragments(self.key(scene))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        covered = frame.answers[CapturedFragments(self.key(scene))].covered
        count = int(np.count_nonzero(covered))
        ok = count == self.pixels
        row = Row(label="pixels", expected=str(self.pixels), measured=str(count), ok=ok)
        message = "" if ok else f"{count} pixels are covered, not {self.pixels}"
        return judge_rows(self.name, self.kind, [row], message, judged=covered.size)


coverage = Coverage
