"""query: a draw makes the driver count so much."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass

from shaderlab.errors import CaseError
from shaderlab.model.calls import COUNTERS
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Frame
from shaderlab.model.records import Row
from shaderlab.model.state import one_of

from .base import Asked, OfDraw, judge_rows


@dataclass(frozen=True)
class Query(OfDraw):
    """A draw makes the driver count exactly this much, or at least or at most so much.

    The pass is drawn once more with a query around the draw, earlier draws having filled the
    depth and stencil buffers. "samples_passed" are the samples that pass all tests and are not
    discarded: exact on every driver. What pipeline statistics count ("…_invocations" and the
    like) a driver may exceed where it works in blocks, and one without them leaves the case
    unsupported.

    Raises:
        CaseError: the counter is unknown, or nothing is expected of it.
    """

    kind = "query"

    counter: str
    _: KW_ONLY
    equals: int | None = None
    at_least: int | None = None
    at_most: int | None = None

    def __post_init__(self) -> None:
        one_of("query", "counter", self.counter, COUNTERS)
        if (self.equals is None) == (self.at_least is None and self.at_most is None):
            raise CaseError(f"query {self.counter!r}: give equals=, or at_least= and at_most=")
        self.name_by_default(self.counter.replace("_", " "))

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield Asked("count", (self.key(scene), self.counter))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        count = frame.answers[Asked("count", (self.key(scene), self.counter))]
        low, high = self.at_least or 0, self.at_most
        if self.equals is not None:
            low = high = int(self.equals)
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
        return judge_rows(self.name, self.kind, [row], message, judged=1)


query = Query
