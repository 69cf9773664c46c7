"""What differs between runs: against another one, since earlier runs beside it, between drivers.

Each run leaves a summary in its folder, which later runs beside it read. Compared are runs on the
same renderer, with the same files in shaders' places, and variants judged at the same size.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

from shaderlab.files import read_regular, write_text
from shaderlab.model.records import (
    Agreement,
    Disagreement,
    DriverResult,
    Record,
    Run,
    Status,
    Worst,
)
from shaderlab.report.grouping import STATUSES, group_cases
from shaderlab.report.pictures import Picture, Pictures
from shaderlab.report.text import MARKS, format_summary

SUMMARY_NAME = "summary.json"
LONGEST_HISTORY = 20
"""Of how many runs there is a history, the present one included."""
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
    are (what, earlier, later) of drivers and versions, `differs` says if any of them do. `alone`
    counts points of sweeps that one run lists and the other, which does not list all, may have."""

    before: Run
    name: str
    changes: tuple[Change, ...]
    same: int
    facts: tuple[tuple[str, str, str], ...]
    alone: int = 0

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
    changes, alone = [], 0
    for key in keys:
        pair = old.get(key), new.get(key)
        if (before.points and pair[0] is None) or (run.points and pair[1] is None):
            alone += 1
            continue
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
        same=len(keys) - len(changes) - alone,
        facts=tuple(_facts(before, run)),
        alone=alone,
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
class VariantSummary:
    """What a run found of a variant.

    Attributes:
        status: its status.
        widths: how far its worst value lies from the middle of its band, in half widths; 0 for
            one that is as near to its reference as a float can be, None where nothing was held
            against a band.
        seconds: how long it took.
        size: the judged frame's side in pixels, 0 where nothing was drawn.
    """

    status: Status
    widths: float | None
    seconds: float = field(compare=False)
    size: int = field(compare=False)


Entries = Mapping[tuple[str, str], VariantSummary]


@dataclass(frozen=True)
class PastRun:
    name: str
    started: str
    entries: Entries


@dataclass(frozen=True)
class Changed:
    """A variant that is not what it was when it ran last."""

    id: str
    variant: str
    title: str
    link: str | None
    before: VariantSummary
    after: VariantSummary
    when: PastRun

    @property
    def verdict_changed(self) -> bool:
        return self.before.status != self.after.status


@dataclass(frozen=True)
class Trend:
    """A case over the runs that had all of its variants, this one last: the headroom of its worst
    value (0 at the edge of its band or outside, 1 in the middle; None where nothing was held
    against a band), and seconds."""

    headroom: tuple[float | None, ...]
    seconds: tuple[float, ...]

    def path(self, what: str, width: float, height: float) -> str:
        """An SVG path through "headroom" (0 to 1) or "seconds" (0 to the longest)."""
        values: Sequence[float | None] = getattr(self, what)
        most = 1.0 if what == "headroom" else max(self.seconds) or 1.0
        path, pen = "", "M"
        for n, value in enumerate(values):
            if value is not None:
                x, y = n / (len(values) - 1) * width, (1 - value / most) * height
                path += f"{pen}{x:.1f} {y:.1f}"
            pen = "M" if value is None else "L"
        return path


@dataclass(frozen=True)
class History:
    """Earlier runs, the last one first, and what changed since each variant was run last. `known`
    counts the variants that one of them has; `trends` has the cases of two runs or more."""

    runs: tuple[PastRun, ...]
    changes: tuple[Changed, ...]
    known: int
    trends: Mapping[str, Trend]


def save_summary(run: Run, folder: Path) -> None:
    """Write the run's summary into its folder. Raises ShaderlabError."""
    cases: dict[str, dict[str, list[Any]]] = {}
    for record in run.records:
        entry = _summarise(record)
        widths = entry.widths
        if widths is not None and not math.isfinite(widths):
            widths = str(widths)  # type: ignore[assignment]
        cases.setdefault(record.id, {})[record.variant] = [
            entry.status, widths, round(entry.seconds, 4), entry.size
        ]  # fmt: skip
    about = {
        "started": run.started,
        "status": _status(run),
        "missing": run.missing,
        "said": format_summary(run),
        **_conditions(run),
        "cases": cases,
    }
    write_text(folder / SUMMARY_NAME, json.dumps(about, separators=(",", ":")) + "\n")


def _status(run: Run) -> Status:
    """The worst of its records, or of another driver's; "unsupported" only where nothing passed."""
    found = {record.status for record in run.records} | {each.status for each in run.drivers}
    some = [status for status in STATUSES if status in found and status != "unsupported"]
    return some[0] if some else "unsupported"


def compare_with_past(
    run: Run, folder: Path, links: Mapping[tuple[str, str], str]
) -> History | None:
    """Return what earlier runs found whose folders stand beside `folder`.

    Returns:
        None where there is no such run. A summary that can't be read is not counted.
    """
    past = sorted(_past(run, folder), key=lambda each: (each.started, each.name), reverse=True)
    runs = past[: LONGEST_HISTORY - 1]
    now = {(record.id, record.variant): _summarise(record) for record in run.records}
    changes, known = [], 0
    for record in run.records:
        key = record.id, record.variant
        when = next(
            (each for each in runs if _is_comparable(each.entries.get(key), now[key])), None
        )
        if when is None:
            continue
        known += 1
        before = when.entries[key]
        if before != now[key]:
            changes.append(Changed(*key, record.title, links.get(key), before, now[key], when))
    if not known:
        return None
    changes.sort(key=lambda each: (not each.verdict_changed, STATUSES.index(each.after.status)))
    return History(tuple(runs), tuple(changes), known, dict(_trends(run, now, runs)))


def _trends(run: Run, now: Entries, runs: Sequence[PastRun]) -> Iterator[tuple[str, Trend]]:
    for group in group_cases(run.records):
        keys = [(record.id, record.variant) for record in group.records]
        points = []
        for entries in (*(each.entries for each in reversed(runs)), now):
            own = [entries.get(key) for key in keys]
            if all(_is_comparable(entry, now[key]) for entry, key in zip(own, keys, strict=True)):
                points.append([entry for entry in own if entry is not None])
        if len(points) > 1:
            headroom = tuple(_headroom(entries) for entries in points)
            yield group.id, Trend(headroom, tuple(sum(e.seconds for e in p) for p in points))


def _headroom(entries: Sequence[VariantSummary]) -> float | None:
    widths = [entry.widths for entry in entries if entry.widths is not None]
    return max(0.0, 1.0 - max(widths)) if widths else None


def _summarise(record: Record) -> VariantSummary:
    worst = [outcome.worst for outcome in record.expectations if outcome.worst is not None]
    widths = [_widths(each) for each in worst if not math.isnan(each.widths)]
    return VariantSummary(record.status, max(widths, default=None), record.seconds, record.size)


def _widths(worst: Worst) -> float:
    # A band of two neighbouring floats has no middle to lie in.
    nearest = worst.exact or (worst.ulp <= 0.5 and worst.widths <= 1)
    return 0.0 if nearest else worst.widths


def _is_comparable(before: VariantSummary | None, now: VariantSummary) -> bool:
    return before is not None and (before.size == now.size or not before.size * now.size)


def _conditions(run: Run) -> dict[str, Any]:
    """What two runs have in common that are compared."""
    return {"renderer": run.driver.get("renderer", ""), "replaced": sorted(run.replaced)}


def _past(run: Run, folder: Path) -> Iterator[PastRun]:
    own = folder.resolve()
    conditions = _conditions(run)
    for path in own.parent.glob(f"*/{SUMMARY_NAME}"):
        if path.parent.is_symlink() or path.parent == own:
            continue
        try:
            found = json.loads(read_regular(path))
            same = {name: found[name] for name in conditions} == conditions
            past = PastRun(path.parent.name, str(found["started"]), dict(_entries(found["cases"])))
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            continue
        if same and (past.started, past.name) < (run.started, own.name):
            yield past


def _entries(cases: Any) -> Iterator[tuple[tuple[str, str], VariantSummary]]:
    for case_id, variants in cases.items():
        for variant, (status, widths, seconds, size) in variants.items():
            if status not in STATUSES:
                raise ValueError(f"{status!r} is no status")
            distance = None if widths is None else float(widths)
            yield (case_id, variant), VariantSummary(status, distance, float(seconds), int(size))


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
