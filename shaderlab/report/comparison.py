"""What differs between two runs, and between the drivers of one."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path

from shaderlab.model.records import (
    Agreement,
    Disagreement,
    DriverResult,
    Record,
    Run,
    Status,
)
from shaderlab.report.grouping import STATUSES
from shaderlab.report.pictures import Picture, Pictures
from shaderlab.report.text import MARKS

AGREEMENTS: dict[Agreement, str] = {
    "equal": "the same to the bit",
    "within": "different, each within its band",
    "outside": "outside of a band on one",
}
"""What a verdict on two drivers' values means, in words."""

Key = tuple[str, str]


@dataclass(frozen=True)
class Side:
    """One run's view of a variant. `widths` and `ulp` are its largest distances from a band's
    middle (in half widths) and from a reference; None where nothing was held against a band."""

    status: Status
    widths: float | None
    ulp: float | None
    seconds: float = field(compare=False)


@dataclass(frozen=True)
class Change:
    """A variant that is not the same in both runs; a run that does not have it has no side.

    `pictures` are the two runs' pictures, where both have one and they differ.
    """

    title: str
    variant: str
    link: str | None
    before: Side | None
    after: Side | None
    pictures: tuple[Picture, Picture] | None

    @property
    def verdict_changed(self) -> bool:
        return self.before is None or self.after is None or self.before.status != self.after.status


@dataclass(frozen=True)
class Comparison:
    """Two runs side by side; `same` counts the variants that agree in all but their time, `facts`
    are (what, earlier, later) of drivers and versions, `differs` says if any of them do."""

    before: Run
    name: str
    changes: tuple[Change, ...]
    same: int
    facts: tuple[tuple[str, str, str], ...]

    @property
    def differs(self) -> bool:
        return any(earlier != later for what, earlier, later in self.facts if what != "duration")


def compare_runs(
    run: Run, folder: Path, before: Run, before_folder: Path, links: Mapping[Key, str]
) -> Comparison:
    """Return everything that is not the same in `run` as in the earlier one."""
    old, new = (
        {(record.id, record.variant): record for record in each.records} for each in (before, run)
    )
    keys = list(dict.fromkeys((*new, *old)))
    seen = Pictures(before_folder), Pictures(folder)
    changes = []
    for key in keys:
        pair = old.get(key), new.get(key)
        pictures = _pictures(pair, seen)
        sides = _side(pair[0]), _side(pair[1])
        if pictures is None and sides[0] == sides[1]:
            continue
        record = pair[1] or pair[0]
        assert record is not None
        changes.append(
            Change(record.title, record.variant, links.get(key), sides[0], sides[1], pictures)
        )
    return Comparison(
        before=before,
        name=before_folder.resolve().name,
        changes=tuple(sorted(changes, key=_urgency)),
        same=len(keys) - len(changes),
        facts=tuple(_facts(before, run)),
    )


def _side(record: Record | None) -> Side | None:
    if record is None:
        return None
    worst = [o.worst for o in record.expectations if o.worst is not None]
    widths = [w.widths for w in worst if not math.isnan(w.widths)]
    ulps = [w.ulp for w in worst if not math.isnan(w.ulp)]
    return Side(record.status, max(widths, default=None), max(ulps, default=None), record.seconds)


def _pictures(
    pair: tuple[Record | None, Record | None], folders: tuple[Pictures, Pictures]
) -> tuple[Picture, Picture] | None:
    """The two runs' pictures of a variant, where both are there and their files differ."""
    both = []
    for record, folder in zip(pair, folders, strict=True):
        picture = None if record is None else folder.find(record.images.get("picture", ""))
        if picture is None or picture.missing:
            return None
        both.append(picture)
    try:
        same = both[0].path.read_bytes() == both[1].path.read_bytes()
    except OSError:
        return None
    return None if same else (both[0], both[1])


def _urgency(change: Change) -> tuple[bool, int, float]:
    """Changed verdicts first, the worst of them on top; then by how much the distance grew."""
    after = change.after
    rank = STATUSES.index(after.status) if after is not None else len(STATUSES)
    grown = ((after and after.widths) or 0.0) - ((change.before and change.before.widths) or 0.0)
    return not change.verdict_changed, rank, -grown


def _facts(before: Run, after: Run) -> Iterable[tuple[str, str, str]]:
    yield "duration", f"{before.seconds:.1f} s", f"{after.seconds:.1f} s"
    for earlier, later in ((before.driver, after.driver), (before.versions, after.versions)):
        for name in dict.fromkeys([*earlier, *later]):
            yield name, earlier.get(name, ""), later.get(name, "")


@dataclass(frozen=True)
class DriverRow:
    """One scene; `results` are in the order of the drivers, None where one did not run it."""

    id: str
    variant: str
    link: str | None
    results: tuple[DriverResult | None, ...]

    @property
    def agrees(self) -> bool:
        return len({result and result.status for result in self.results}) == 1

    @property
    def cells(self) -> tuple[str, ...]:
        """Of each driver a few words: the verdict, and how its outputs compare with the first's."""
        return tuple(_cell(result) for result in self.results)


@dataclass(frozen=True)
class DriverTable:
    """`drivers` are (name, renderer); scenes with differing verdicts come first. `differences` are
    the outputs that differ, what leaves a band first; `outputs` counts all by verdict."""

    drivers: tuple[tuple[str, str], ...]
    rows: tuple[DriverRow, ...]
    differences: tuple[Disagreement, ...] = ()
    outputs: Counter[Agreement] = field(default_factory=Counter)
    words = AGREEMENTS

    @property
    def disputed(self) -> int:
        return sum(not row.agrees for row in self.rows)

    def by_case(self) -> Iterator[tuple[str, int, tuple[str, ...]]]:
        """Each case with the number of its variants whose cells are these."""
        for case_id, rows in groupby(sorted(self.rows, key=lambda r: r.id), lambda row: row.id):
            for cells, count in Counter(row.cells for row in rows).items():
                yield case_id, count, cells


def compare_drivers(run: Run, links: Mapping[tuple[str, str], str]) -> DriverTable | None:
    """Return the table, or None for a single driver; `links` lead to the variants."""
    names = {result.driver: result.renderer for result in run.drivers}
    if len(names) < 2:
        return None
    by_scene: dict[tuple[str, str], dict[str, DriverResult]] = {}
    for result in run.drivers:
        by_scene.setdefault((result.id, result.variant), {})[result.driver] = result
    rows = [
        DriverRow(*scene, links.get(scene), tuple(results.get(name) for name in names))
        for scene, results in by_scene.items()
    ]
    return DriverTable(
        drivers=tuple(names.items()),
        rows=tuple(sorted(rows, key=lambda row: row.agrees)),
        differences=tuple(
            sorted(
                (each for each in run.disagreements if each.verdict != "equal"),
                key=lambda each: each.verdict != "outside",
            )
        ),
        outputs=Counter(each.verdict for each in run.disagreements),
    )


def _cell(result: DriverResult | None) -> str:
    if result is None:
        return "not run"
    without = f", {result.not_asked} skipped" if result.not_asked else ""
    return f"{MARKS[result.status]} {result.agrees or result.status}{without}"
