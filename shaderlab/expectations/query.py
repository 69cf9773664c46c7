"""query: a draw makes the driver count so much."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from shaderlab.errors import CaseError
from shaderlab.expectations.base import Context, OfDraw, table
from shaderlab.frame import Frame, PassDraw
from shaderlab.model import COUNTERS, Judgement, Programs, Request, Scene, one_of
from shaderlab.records import Row


@dataclass(frozen=True)
class Counted(Request):
    """What the driver counts while one draw of a pass is drawn once more."""

    key: PassDraw
    counter: str

    def answer(self, context: Context) -> int:
        return context.session.count(self.key, self.counter)


@dataclass(frozen=True, kw_only=True)
class Query(OfDraw):
    """What a draw makes the driver count lies in `low` … `high`."""

    kind = "query"

    counter: str
    low: int
    high: int | None

    def requests(self, scene: Scene, programs: Programs) -> Iterable[Request]:
        yield Counted(self.key(scene), self.counter)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        count = frame.answers[Counted(self.key(scene), self.counter)]
        low, high = self.low, self.high
        ok = low <= count and (high is None or count <= high)
        if low == high:
            expected = str(low)
        elif high is None:
            expected = f"at least {low}"
        else:
            expected = f"at most {high}" if low == 0 else f"{low} to {high}"
        words = self.counter.replace("_", " ")
        row = Row(label=words, expected=expected, measured=str(count), ok=ok)
        message = "" if ok else f"{count} {words}, not {expected}"
        return table(self.name, self.kind, [row], message, judged=1)


def query(
    counter: str,
    *,
    equals: int | None = None,
    at_least: int | None = None,
    at_most: int | None = None,
    pass_name: str | None = None,
    draw: int = -1,
    name: str = "",
) -> Query:
    """A draw makes the driver count exactly this much, or at least or at most so much.

    The pass is drawn once more with a query around the draw, earlier draws having filled the
    depth and stencil buffers. "samples_passed" are the samples that pass all tests and are not
    discarded: exact on every driver. What pipeline statistics count ("…_invocations" and the
    like) a driver may exceed where it works in blocks, and one without them leaves the case
    unsupported.

    Raises:
        CaseError: the counter is unknown, or nothing is expected of it.
    """
    one_of("query", "counter", counter, COUNTERS)
    if (equals is None) == (at_least is None and at_most is None):
        raise CaseError(f"query {counter!r}: give equals=, or at_least= and at_most=")
    low, high = (equals, equals) if equals is not None else (at_least or 0, at_most)
    return Query(
        counter=counter,
        low=low,
        high=high,
        pass_name=pass_name,
        draw=draw,
        name=name or counter.replace("_", " "),
    )
