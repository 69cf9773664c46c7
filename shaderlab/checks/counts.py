"""Judging counts: what the driver counted, and a table of what passes cost."""

from __future__ import annotations

import math
from collections.abc import Mapping

from shaderlab.checks.judgement import Judgement
from shaderlab.frame import Timing
from shaderlab.model import Cost, Query
from shaderlab.records import Outcome, Plot, PlotPoint, Row


def judge_query(expectation: Query, count: int) -> Judgement:
    """Compare what the driver counted with what was expected."""
    low, high = expectation.low, expectation.high
    ok = low <= count and (high is None or count <= high)
    if low == high:
        expected = str(low)
    elif high is None:
        expected = f"at least {low}"
    else:
        expected = f"at most {high}" if low == 0 else f"{low} to {high}"
    words = expectation.counter.replace("_", " ")
    row = Row(label=words, expected=expected, measured=str(count), ok=ok)
    message = "" if ok else f"{count} {words}, not {expected}"
    return _table(expectation.name, "query", [row], message, judged=1)


def judge_cost(expectation: Cost, timings: Mapping[str, Timing]) -> Judgement:
    """Draw calls and vertices as they should be; times beside them, and what becomes of the claim.

    The time of several passes together is the sum of their best times. Times over N are plotted.
    """
    rows = []
    best: dict[tuple[str, float], float] = {}
    for number in sorted({n for row in expectation.series.values() for n in row}):
        for label, row in expectation.series.items():
            if number in row:
                taken = [timings[name] for name in row[number]]
                best[label, number] = sum(min(t.seconds) for t in taken)
                rows.append(_row(expectation, label, number, taken))
    wrong = [row.label for row in rows if not row.ok]
    rows = _with_ratios(expectation, rows, best)
    if expectation.cheaper is not None:
        rows.append(_claim(expectation, best))
    message = f"other counts than expected: {', '.join(wrong)}" if wrong else ""
    return _table(expectation.name, "cost", rows, message, len(best), _times(expectation, best))


def _row(expectation: Cost, label: str, number: float, taken: list[Timing]) -> Row:
    calls, vertices = sum(t.draw_calls for t in taken), sum(t.vertices for t in taken)
    expected, ok = [], True
    for formulas, count, word in (
        (expectation.draw_calls, calls, "draw calls"),
        (expectation.vertices, vertices, "vertices"),
    ):
        if label in formulas:
            wanted = formulas[label](number)
            ok = ok and wanted == count
            expected.append(f"{wanted} {word}")
    seconds = sum(min(t.seconds) for t in taken)
    return Row(
        label=f"{label}, {expectation.over} = {number:g}",
        expected=", ".join(expected) or "any",
        measured=f"{calls} draw calls, {vertices} vertices, {1e3 * seconds:.3g} ms",
        ok=ok,
    )


def _with_ratios(
    expectation: Cost, rows: list[Row], best: Mapping[tuple[str, float], float]
) -> list[Row]:
    """Each row says how its time compares with the fastest of its N."""
    from dataclasses import replace

    fastest: dict[float, float] = {}
    for (_, number), seconds in best.items():
        fastest[number] = min(seconds, fastest.get(number, seconds))
    return [
        replace(row, note=f"{seconds / fastest[number]:.2f} × the fastest")
        for row, ((_, number), seconds) in zip(rows, best.items(), strict=True)
    ]


def _claim(expectation: Cost, best: Mapping[tuple[str, float], float]) -> Row:
    assert expectation.cheaper is not None
    less, more = expectation.cheaper
    both = [n for n in expectation.series[less] if n in expectation.series[more]]
    ratios = {n: best[more, n] / best[less, n] for n in both}
    holds = [n for n in both if ratios[n] > 1.0]
    if len(holds) == len(both):
        said = "holds on this driver"
    elif not holds:
        said = "does not hold on this driver"
    else:
        listed = ", ".join(f"{n:g}" for n in holds)
        said = f"holds on this driver for {expectation.over} = {listed}, and not else"
    shown = ", ".join(f"{ratio:.2f} at {n:g}" for n, ratio in ratios.items())
    return Row(
        label=expectation.claim,
        expected="said, not judged",
        measured=said,
        ok=True,
        note=f"time of {more} over time of {less}: {shown}",
    )


def _times(expectation: Cost, best: Mapping[tuple[str, float], float]) -> Plot | None:
    """Milliseconds over N, a line for each way of drawing; None unless there are two numbers."""
    numbers = {number for _, number in best}
    if len(numbers) < 2:
        return None
    points = tuple(
        PlotPoint(series=label, x=number, y=1e3 * seconds, low=-math.inf, high=math.inf, ok=True)
        for (label, number), seconds in best.items()
    )
    # Each N is as a rule a multiple of the last, and a logarithm has no place for 0.
    return Plot(
        title=expectation.name,
        x_label=expectation.over,
        y_label="ms, the best of several (not judged)",
        points=points,
        log_x=min(numbers) > 0.0,
        log_y=all(seconds > 0.0 for seconds in best.values()),
    )


def _table(
    name: str, kind: str, rows: list[Row], message: str, judged: int, plot: Plot | None = None
) -> Judgement:
    return Judgement(
        plot=plot,
        outcome=Outcome(
            name=name,
            kind=kind,
            status="fail" if message else "pass",
            message=message,
            judged=judged,
            outside=sum(not row.ok for row in rows),
            rows=tuple(rows),
        ),
    )
