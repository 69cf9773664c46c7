"""computed: a printed figure that no shader draws follows from a Python reference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any

from shaderlab.errors import FormulaError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation, Judgement
from shaderlab.model.frame import Frame

from ..judging.distance import figure_row, rounds_to, shown
from ..judging.formats import source_of
from .base import judge_rows
from .value import Figure


@dataclass(frozen=True)
class Computed(Expectation):
    """A figure that follows from a reference alone: what `compute` gives in float64, rounded to
    `digits` decimals, is `equals`."""

    kind = "computed"
    once = True

    name: str
    compute: Callable[[], Any]
    _: KW_ONLY
    equals: Figure
    digits: int
    note: str = ""

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        try:
            got = self.compute()
        except Exception as error:
            place = source_of(self.compute)
            raise FormulaError(
                f"{self.name}: {type(error).__name__}: {error}", file=place.file, line=place.line
            ) from error
        ok = rounds_to(got, self.equals, self.digits)
        note = self.note or "float64, no shader"
        row = figure_row(self.name, self.equals, self.digits, got, None, ok, note)
        message = "" if ok else f"the reference gives {shown(got, self.digits + 3)}"
        return judge_rows(self.name, self.kind, [row], message, judged=1, rows_per_variant=False)


computed = Computed
