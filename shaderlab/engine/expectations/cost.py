"""cost: a table of what passes cost by a number N: draw calls, vertices, and time, not judged."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any

from shaderlab.errors import CaseError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation, Judgement, Need, Programs
from shaderlab.model.frame import Frame, Timing
from shaderlab.model.records import Plot, PlotPoint, Row
from shaderlab.model.state import check_choice

from .base import SessionQuery

Number = Callable[[float], int]
Best = Mapping[tuple[str, float], float]
"""The best time of each series at each N, in seconds."""


@dataclass(frozen=True)
class Cost(Expectation):
    """What passes cost: a table of draw calls, vertices and the best times, and a plot of these.

    Draw calls and vertices are judged where a formula for them is given. Time never is: it differs
    between machines, and only its ratios are of interest. The table says whether a claim about it
    holds on this driver.

    Args:
        series: for each way of drawing, the pass (or passes) by N: `{"instanced": {4: "few", …}}`.
        claim: the claim in words ("one draw call is cheaper than N").
        cheaper: the series that it says takes less time, and the one that takes more.
        draw_calls: the number of draw calls as a function of N, by series.
        vertices: likewise the number of vertices submitted, those of all instances together.
        over: what N is, for the table and the plot.
        repeats: how often each pass is drawn; the fastest one counts.

    Raises CaseError: a name is that of no series, or a claim is not complete."""

    kind = "cost"

    series: Mapping[str, Mapping[float, Any]]
    _: KW_ONLY
    claim: str = ""
    cheaper: tuple[str, str] | None = None
    draw_calls: Mapping[str, Number] = field(default_factory=dict)
    vertices: Mapping[str, Number] = field(default_factory=dict)
    over: str = "N"
    repeats: int = 5

    def __post_init__(self) -> None:
        tuples = {
            label: {float(n): (p,) if isinstance(p, str) else tuple(p) for n, p in row.items()}
            for label, row in self.series.items()
        }
        object.__setattr__(self, "series", tuples)
        named = {"cheaper": self.cheaper, "draw_calls": self.draw_calls, "vertices": self.vertices}
        for owner, names in named.items():
            for label in names or ():
                check_choice("cost", owner, label, tuple(tuples))
        if bool(self.claim) != (self.cheaper is not None):
            raise CaseError("cost: a claim needs both claim= and cheaper=(series, series)")
        if not tuples or not all(tuples.values()):
            raise CaseError("cost: there are no passes to compare")
        if self.repeats < 1:
            raise CaseError(f"cost: repeats must be at least 1, not {self.repeats}")

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        for row in self.series.values():
            for names in row.values():
                yield from (self._timing(scene.find_pass(name).name) for name in names)

    def _timing(self, pass_name: str) -> SessionQuery[Timing]:
        return SessionQuery("time", (pass_name, self.repeats))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        rows = []
        best: dict[tuple[str, float], float] = {}
        for number in sorted({n for row in self.series.values() for n in row}):
            for label, row in self.series.items():
                if number in row:
                    taken = [frame.answer(self._timing(name)) for name in row[number]]
                    best[label, number] = sum(min(t.seconds) for t in taken)
                    rows.append(self._row(label, number, taken))
        wrong = [row.label for row in rows if not row.ok]
        rows = _add_ratios(rows, best)
        if self.cheaper is not None:
            rows.append(self._claim_row(best, *self.cheaper))
        message = f"unexpected counts: {', '.join(wrong)}" if wrong else ""
        found = self.judge_rows(rows, message, judged=len(best))
        return replace(found, plot=self._plot_times(best))

    def _row(self, label: str, number: float, taken: list[Timing]) -> Row:
        calls, vertices = sum(t.draw_calls for t in taken), sum(t.vertices for t in taken)
        expected, ok = [], True
        for formulas, count, word in (
            (self.draw_calls, calls, "draw calls"),
            (self.vertices, vertices, "vertices"),
        ):
            if label in formulas:
                wanted = formulas[label](number)
                ok = ok and wanted == count
                expected.append(f"{wanted} {word}")
        seconds = sum(min(t.seconds) for t in taken)
        return Row(
            label=f"{label}, {self.over} = {number:g}",
            expected=", ".join(expected) or "any",
            measured=f"{calls} draw calls, {vertices} vertices, {1e3 * seconds:.3g} ms",
            ok=ok,
        )

    def _claim_row(self, best: Best, less: str, more: str) -> Row:
        both = [n for n in self.series[less] if n in self.series[more]]
        ratios = {n: best[more, n] / best[less, n] for n in both}
        holds = [n for n in both if ratios[n] > 1.0]
        if len(holds) == len(both):
            said = "holds on this driver"
        elif not holds:
            said = "does not hold on this driver"
        else:
            listed = ", ".join(f"{n:g}" for n in holds)
            said = f"holds on this driver for {self.over} = {listed} only"
        shown = ", ".join(f"{ratio:.2f} at {n:g}" for n, ratio in ratios.items())
        return Row(
            label=self.claim,
            expected="said, not judged",
            measured=said,
            ok=True,
            note=f"time of {more} over time of {less}: {shown}",
        )

    def _plot_times(self, best: Best) -> Plot | None:
        numbers = {number for _, number in best}
        if len(numbers) < 2:
            return None
        points = tuple(
            PlotPoint(
                series=label, x=number, y=1e3 * seconds, low=-math.inf, high=math.inf, ok=True
            )
            for (label, number), seconds in best.items()
        )
        # Each N is usually a multiple of the last, and 0 has no logarithm.
        return Plot(
            title=self.name,
            x_label=self.over,
            y_label="ms, the best of several (not judged)",
            points=points,
            log_x=min(numbers) > 0.0,
            log_y=all(seconds > 0.0 for seconds in best.values()),
        )


def _add_ratios(rows: list[Row], best: Best) -> list[Row]:
    fastest: dict[float, float] = {}
    for (_, number), seconds in best.items():
        fastest[number] = min(seconds, fastest.get(number, seconds))
    return [
        replace(row, note=f"{seconds / fastest[number]:.2f} × the fastest")
        for row, ((_, number), seconds) in zip(rows, best.items(), strict=True)
    ]


cost = Cost
