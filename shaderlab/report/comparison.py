"""What differs between the drivers of a run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby

from shaderlab.model.records import Agreement, Disagreement, DriverResult, Run
from shaderlab.report.text import MARKS

AGREEMENTS: dict[Agreement, str] = {
    "equal": "the same to the bit",
    "within": "different, each within its band",
    "outside": "outside of a band on one",
}
"""What a verdict on two drivers' values means, in words."""


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
    unequal = (each for each in run.disagreements if each.verdict != "equal")
    return DriverTable(
        drivers=tuple(names.items()),
        rows=tuple(sorted(rows, key=lambda row: row.agrees)),
        differences=tuple(sorted(unequal, key=lambda each: each.verdict != "outside")),
        outputs=Counter(each.verdict for each in run.disagreements),
    )


def _cell(result: DriverResult | None) -> str:
    if result is None:
        return "not run"
    without = f", {result.not_asked} skipped" if result.not_asked else ""
    return f"{MARKS[result.status]} {result.agrees or result.status}{without}"
