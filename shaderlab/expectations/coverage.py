"""coverage: exactly this many pixels show a draw in the end."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from shaderlab.expectations.base import OfDraw, table
from shaderlab.expectations.requests import CapturedFragments
from shaderlab.frame import Frame
from shaderlab.model import Judgement, Programs, Read, Request, Scene
from shaderlab.records import Row


@dataclass(frozen=True, kw_only=True)
class Coverage(OfDraw):
    """`pixels` pixels show the draw."""

    kind = "coverage"

    pixels: int

    def reads(self, scene: Scene) -> Iterable[Read]:
        yield Read(self.key(scene)[0], "coverage")

    def requests(self, scene: Scene, programs: Programs) -> Iterable[Request]:
        yield CapturedFragments(self.key(scene))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        covered = frame.answers[CapturedFragments(self.key(scene))].covered
        count = int(np.count_nonzero(covered))
        ok = count == self.pixels
        row = Row(label="pixels", expected=str(self.pixels), measured=str(count), ok=ok)
        message = "" if ok else f"{count} pixels are covered, not {self.pixels}"
        return table(self.name, self.kind, [row], message, judged=covered.size)


def coverage(
    pixels: int, *, pass_name: str | None = None, draw: int = -1, name: str = ""
) -> Coverage:
    """Exactly `pixels` pixels show the draw in the end: those that it covers, that pass every test
    and are not discarded, and that no later draw of the pass covers."""
    return Coverage(pixels=pixels, pass_name=pass_name, draw=draw, name=name or "coverage")
