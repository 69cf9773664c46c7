"""The points of a sweep: its parameters as typed, the grid that they span, the table of results and
the plots made of it."""

from __future__ import annotations

import heapq
import math
import re
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from shaderlab.cli.recorded_run import SIZE, Grid, Parameter
from shaderlab.engine.jobs import CaseInfo
from shaderlab.errors import UsageError, suggest
from shaderlab.model.phases import PHASES
from shaderlab.model.records import Plot, PlotPoint, Points, Status
from shaderlab.report.grouping import PASSABLE, STATUSES

LARGEST_SIZE = 4096
MOST_POINTS = 100_000
"""So many were measured: docs/internals/measurements.md has their time and memory."""
_RANGE = re.compile(r"(?P<start>[^:]+):(?P<stop>[^:]+):(?P<count>\d+)(?P<log>log)?")
_PARTS = "take fewer values, or sweep in parts, each into its own --report FOLDER"
_RIGHT = "write NAME=START:STOP:COUNT, NAME=START:STOP:COUNTlog or NAME=A,B,C"


def parse_parameter(word: str) -> Parameter:
    """From "reach=1:50:8", "reach=0.1:100:4log" or "reach=7,13,20".

    >>> parse_parameter("size=64:1024:3log").values
    (64.0, 256.0, 1024.0)

    Raises:
        UsageError: the format is wrong; the remedy shows the right one.
    """
    name, equals, values = (part.strip() for part in word.partition("="))
    if not equals or not name or not values:
        raise UsageError(f"--param {word}: no name and values", remedy=_RIGHT)
    found = _RANGE.fullmatch(values)
    if found is None and ":" in values:
        raise UsageError(
            f"--param {word}: {values!r} is no range",
            remedy="write START:STOP:COUNT, such as 0:1:11, or 0.01:1:50log (logarithmic)",
        )
    if found is None:
        numbers = tuple(_parse_number(word, text) for text in values.split(","))
    else:
        ends = _parse_number(word, found["start"]), _parse_number(word, found["stop"])
        numbers = _space_values(word, *ends, int(found["count"]), log=bool(found["log"]))
    if name == SIZE:
        numbers = _check_sizes(word, numbers)
    return Parameter(name, tuple(dict.fromkeys(numbers)), bool(found and found["log"]))


def parse_parameters(words: Sequence[str]) -> tuple[Parameter, ...]:
    """All parameters of a sweep. Raises UsageError, also if one is given twice."""
    found = tuple(parse_parameter(word) for word in words)
    names = [parameter.name for parameter in found]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(
                f"--param {name} is given twice", remedy="put all its values into one list"
            )
    points = math.prod(len(parameter.values) for parameter in found)
    if points > MOST_POINTS:
        sides = " × ".join(f"{len(parameter.values):,}" for parameter in found)
        raise UsageError(
            f"the grid has {points:,} points ({sides}), the limit is {MOST_POINTS:,}",
            remedy=_PARTS,
        )
    return found


def make_grid(facts: CaseInfo, variant: str, swept: Sequence[Parameter]) -> Grid:
    """The grid of a case's parameters.

    Args:
        facts: of the case.
        variant: whose inputs all points have, except the swept ones.
        swept: the parameters.

    Raises:
        UsageError: the case has no such parameter, it is not a single number, or the case has no
            formula, so that nothing can be judged at other inputs.
    """
    if not facts.formulas[facts.variants.index(variant)]:
        raise UsageError(
            f"{facts.id} has no formula, and its figures hold for its own inputs only",
            file=facts.file,
            remedy="sweep a case with a formula(…) expectation",
        )
    for parameter in swept:
        _check_parameter(facts, parameter)
    return Grid(
        file=facts.file,
        id=facts.id,
        title=facts.title,
        section=facts.section,
        variant=variant,
        parameters=tuple(swept),
    )


def _check_parameter(facts: CaseInfo, parameter: Parameter) -> None:
    if parameter.name == SIZE:
        if not facts.sized:
            raise UsageError(f"every pass of {facts.id} has a fixed size", file=facts.file)
        return
    single = [name for name, components in facts.parameters.items() if components == 1]
    components = facts.parameters.get(parameter.name)
    if components is None:
        raise UsageError(
            f"{facts.id} has no uniform or ramp {parameter.name!r}",
            file=facts.file,
            remedy=suggest(parameter.name, [*single, SIZE]),
        )
    if components != 1:
        raise UsageError(
            f"{parameter.name!r} of {facts.id} has {components} components, not one",
            file=facts.file,
            remedy=f"single numbers are {', '.join([*single, SIZE])}",
        )


def _parse_number(word: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise UsageError(f"--param {word}: {text!r} is no number", remedy=_RIGHT) from None
    if not math.isfinite(value):
        raise UsageError(f"--param {word}: {text} is not finite", remedy=_RIGHT)
    return value


def _space_values(
    word: str, start: float, stop: float, count: int, *, log: bool
) -> tuple[float, ...]:
    if count < 2:
        raise UsageError(f"--param {word}: a range needs 2 values or more", remedy=_RIGHT)
    if count > MOST_POINTS:
        raise UsageError(
            f"--param {word}: {count:,} values, the limit is {MOST_POINTS:,} points", remedy=_PARTS
        )
    if log and not start * stop > 0.0:
        raise UsageError(
            f"--param {word}: a logarithmic range can't go from {start:g} to {stop:g}",
            remedy="both ends must be above 0, or both below",
        )
    import numpy as np  # a run that is resumed needs none of it

    space = np.geomspace if log else np.linspace
    # Twelve digits, so that 0.3 does not become 0.30000000000000004.
    return tuple(float(f"{value:.12g}") for value in space(start, stop, count))


def _check_sizes(word: str, values: Sequence[float]) -> tuple[float, ...]:
    sizes = [float(round(value)) for value in values]
    if not all(1 <= size <= LARGEST_SIZE for size in sizes):
        raise UsageError(f"--param {word}: sizes are 1…{LARGEST_SIZE} pixels")
    return tuple(sizes)


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
            "widths": max((_parse_distance(each["widths"]) for each in worst), default=math.nan),
            "ulp": max((_parse_distance(each["ulp"]) for each in worst), default=math.nan),
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


def _parse_distance(number: float | str) -> float:
    """A NaN counts as infinitely far away."""
    return math.inf if math.isnan(float(number)) else float(number)


MOST_SERIES = 6
"""The number of colours that a plot has for series."""
MOST_DOTS = 1000
PARTS = 300
"""A plot that would have more dots has one for each series in so many equal parts of its points:
about two pixels of a page."""

_TITLES = {
    "widths": ("Worst distance from the band's middle", "half band widths", 1.0),
    "ulp": ("Worst distance from the reference", "ULP", math.inf),
}


def make_plots(table: SweepTable) -> tuple[Plot, ...]:
    """The largest distances over the parameter with the most values. Another parameter with few
    values, if there is one, gives the series; the maximum is taken over all others, and over
    neighbouring values where there are very many."""
    swept = table.grid.parameters
    seen = _list_values(table)
    axes = sorted(range(len(swept)), key=lambda axis: swept[axis].name == SIZE)  # sizes last
    across = max(axes, key=lambda axis: len(seen[axis]))
    if len(seen[across]) < 2:
        return ()
    few = (axis for axis in axes if axis != across and 2 <= len(seen[axis]) <= MOST_SERIES)
    series = next(few, None)
    parts = _count_parts(len(seen[across]), 1 if series is None else len(seen[series]))
    over = [
        parameter.name
        for axis, parameter in enumerate(swept)
        if axis not in (across, series) and len(seen[axis]) > 1
    ]
    least, most = min(seen[across]), max(seen[across])
    drawn = []
    for column, (title, label, high) in _TITLES.items():
        points = tuple(_find_largest(table, across, series, seen[across], parts, column, high))
        heights = [point.y for point in points]
        if not heights:
            continue
        what = f"largest over {' and '.join(over)}" if over else "largest"
        binned = f" in each of {parts} parts" if parts < len(seen[across]) else ""
        drawn.append(
            Plot(
                title=title + (f", {what}{binned}" if over or binned else ""),
                x_label=swept[across].name,
                y_label=label,
                points=points,
                log_x=least > 0.0 and most / least >= 50.0,
                log_y=min(heights) > 0.0 and max(heights) / min(heights) >= 1000.0,
            )
        )
    return tuple(drawn)


def _list_values(table: SweepTable) -> list[dict[float, int]]:
    """For each parameter its values at points that were run, and which of them each is by size."""
    grid = table.grid
    found: list[set[int]] = [set() for _ in grid.parameters]
    for point in table.points():
        for places, place in zip(found, grid.places(point), strict=True):
            places.add(place)
    values = (
        sorted(parameter.values[place] for place in places)
        for parameter, places in zip(grid.parameters, found, strict=True)
    )
    return [{value: n for n, value in enumerate(some)} for some in values]


def _count_parts(values: int, series: int) -> int:
    """Into how many parts so many values are taken."""
    return values if values * series <= MOST_DOTS else min(values, PARTS)


def _find_largest(
    table: SweepTable,
    across: int,
    series: int | None,
    seen: dict[float, int],
    parts: int,
    column: str,
    high: float,
) -> Iterator[PlotPoint]:
    """The largest value of a column in each part, where it is."""
    grid, values = table.grid, table.column(column)
    worst: dict[tuple[float, int], tuple[float, float]] = {}
    for point in table.points():
        if math.isnan(values[point]):
            continue
        found = [p.values[n] for p, n in zip(grid.parameters, grid.places(point), strict=True)]
        of, x = 0.0 if series is None else found[series], found[across]
        key = of, seen[x] * parts // len(seen)
        if key not in worst or values[point] > worst[key][0]:
            worst[key] = values[point], x
    for (of, _), (y, x) in sorted(worst.items()):
        name = column if series is None else f"{grid.parameters[series].name} {of:g}"
        yield PlotPoint(series=name, x=x, y=y, low=-math.inf, high=high, ok=y <= high)
