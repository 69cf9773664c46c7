"""The results of a sweep as a table: a row for each point, in columns of numbers, a hundred bytes a
point."""

from __future__ import annotations

import heapq
import math
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from shaderlab.model.activity import PHASES
from shaderlab.model.records import Points, Status
from shaderlab.report.grouping import PASSABLE, STATUSES

from .sweep_grid import Grid

ALL_LISTED = 1000
"""Points of a sweep that has no more are all in its report."""
FAILURES_LISTED, OTHERS_LISTED = 100, 50
"""Of a larger sweep so many points are that did not pass, and of the others, the worst of each."""

Cell = str | float | int | None
Row = Mapping[str, Cell]
_WHOLE = ("outside", "judged")
_FIGURES = ("widths", "ulp", *_WHOLE, "vacuous", "seconds", *PHASES)


class SweepTable:
    """A row for each point of a grid that was run, all with the same columns.

    The parameters come first, by name. `widths` (half band widths) and `ulp` are the largest
    distances from the reference over all formulas, None if nothing was judged. `outside` and
    `judged` count values; `vacuous` is the largest share of values whose band allows any value.
    Then come the seconds, in total and in each phase.
    """

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self._status = bytearray(len(grid))  # 0 where it was not run, else a status's number and 1
        self._columns = {name: array("d", [math.nan]) * len(grid) for name in (*_FIGURES, "checks")}
        self._messages: dict[int, str] = {}
        self._texts: dict[str, str] = {}

    def add(self, point: int, record: Mapping[str, Any]) -> None:
        """Take a point's record, as plain data. Raises ValueError or LookupError: it is none."""
        outcomes = record["expectations"]
        worst = [outcome["worst"] for outcome in outcomes if outcome["worst"] is not None]
        found = {
            "widths": max((_distance(each["widths"]) for each in worst), default=math.nan),
            "ulp": max((_distance(each["ulp"]) for each in worst), default=math.nan),
            "outside": sum(outcome["outside"] for outcome in outcomes),
            "judged": sum(outcome["judged"] for outcome in outcomes),
            "vacuous": max((float(outcome["vacuous"]) for outcome in outcomes), default=math.nan),
            "seconds": record["seconds"],
            **{phase: record["timings"].get(phase, 0.0) for phase in PHASES},
            "checks": len(outcomes),
        }
        status = 1 + STATUSES.index(record["status"])
        for name, value in found.items():
            self._columns[name][point] = value
        if message := record["message"]:
            self._messages[point] = self._texts.setdefault(message, message)
        self._status[point] = status

    def __contains__(self, point: int) -> bool:
        """Whether a point was run."""
        return self._status[point] > 0

    @property
    def statuses(self) -> Counter[Status]:
        """How many points have each status."""
        counts = Counter(self._status)
        return Counter({s: counts[n] for n, s in enumerate(STATUSES, 1) if counts[n]})

    @property
    def failed(self) -> int:
        """How many points did not pass; lacking a feature of the driver is no failure."""
        return sum(count for status, count in self.statuses.items() if status not in PASSABLE)

    @property
    def messages(self) -> list[str]:
        """What points said that did not pass, each text once."""
        return sorted(self._texts)

    def points(self) -> Iterator[int]:
        """The points that were run."""
        return (point for point, status in enumerate(self._status) if status)

    def rows(self) -> Iterator[Row]:
        """The rows of all points that were run."""
        return map(self.row, self.points())

    def row(self, point: int) -> Row:
        """The row of a point that was run."""
        cells: dict[str, Cell] = {**self.grid.coordinates(point), "status": self._status_of(point)}
        for name in _FIGURES:
            value = self._columns[name][point]
            cells[name] = None if math.isnan(value) else int(value) if name in _WHOLE else value
        return {**cells, "message": self._messages.get(point, "")}

    def worst(self, count: int, among: Iterable[int] | None = None) -> list[int]:
        """The `count` worst points of all, or of some, the worst one first: those that did not
        pass, then by their distance from the reference."""
        widths = self._columns["widths"]

        def rank(point: int) -> tuple[bool, float, int]:
            # What was not judged at all is further away than anything.
            distance = math.inf if math.isnan(widths[point]) else widths[point]
            return self._status_of(point) == "pass", -distance, point

        return heapq.nsmallest(count, self.points() if among is None else among, key=rank)

    def listed(self) -> list[int]:
        """The points that the report shows one by one: all, or the worst ones first."""
        if len(self.grid) <= ALL_LISTED:
            return list(self.points())
        passed = {point for point in self.points() if self._status_of(point) in PASSABLE}
        failed = (point for point in self.points() if point not in passed)
        return [*self.worst(FAILURES_LISTED, failed), *self.worst(OTHERS_LISTED, passed)]

    def summary(self, file: str) -> Points:
        """What a report says of all points, which are in a file."""
        sums = {
            name: int(sum(value for value in self._columns[name] if not math.isnan(value)))
            for name in (*_WHOLE, "checks")
        }
        return Points(statuses=self.statuses, file=file, **sums)

    def column(self, name: str) -> Sequence[float]:
        """A column of numbers, NaN where there is none."""
        return self._columns[name]

    def _status_of(self, point: int) -> Status:
        return STATUSES[self._status[point] - 1]


def _distance(number: float | str) -> float:
    """A NaN counts as infinitely far away."""
    return math.inf if math.isnan(float(number)) else float(number)
