"""What earlier runs found: each leaves a summary in its folder, and later ones beside it read them.

Compared is what is alike: runs on the same renderer, with the same files in shaders' places, and
variants judged at the same size.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from shaderlab.files import read_regular, write_text
from shaderlab.model.records import Record, Run, Status, Worst
from shaderlab.report.grouping import STATUSES, group_cases
from shaderlab.report.plain_text import summary

FILE_NAME = "summary.json"
LONGEST = 20
"""Of how many runs there is a history, the present one included."""


@dataclass(frozen=True)
class Entry:
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


Entries = Mapping[tuple[str, str], Entry]


@dataclass(frozen=True)
class PastRun:
    """An earlier run, and the name of its folder."""

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
    before: Entry
    after: Entry
    when: PastRun

    @property
    def verdict_changed(self) -> bool:
        """Whether its status is another one."""
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


def save(run: Run, folder: Path) -> None:
    """Write the run's summary into its folder. Raises ShaderlabError."""
    cases: dict[str, dict[str, list[Any]]] = {}
    for record in run.records:
        entry = _entry(record)
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
        "said": summary(run),
        **_alike(run),
        "cases": cases,
    }
    write_text(folder / FILE_NAME, json.dumps(about, separators=(",", ":")) + "\n")


def _status(run: Run) -> Status:
    """The worst of its records, or of another driver's; "unsupported" only where nothing passed."""
    found = {record.status for record in run.records} | {each.status for each in run.drivers}
    some = [status for status in STATUSES if status in found and status != "unsupported"]
    return some[0] if some else "unsupported"


def history(run: Run, folder: Path, links: Mapping[tuple[str, str], str]) -> History | None:
    """What runs found whose folders stand beside `folder` and that began before this one.

    Args:
        run, folder: the run, and where it is.
        links: where the report shows each (case, variant).

    Returns:
        None where there is no such run. A summary that can't be read is not counted.
    """
    past = sorted(_past(run, folder), key=lambda each: (each.started, each.name), reverse=True)
    runs = past[: LONGEST - 1]
    now = {(record.id, record.variant): _entry(record) for record in run.records}
    changes, known = [], 0
    for record in run.records:
        key = record.id, record.variant
        when = next((each for each in runs if _like(each.entries.get(key), now[key])), None)
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
            if all(_like(entry, now[key]) for entry, key in zip(own, keys, strict=True)):
                points.append([entry for entry in own if entry is not None])
        if len(points) > 1:
            headroom = tuple(_headroom(entries) for entries in points)
            yield group.id, Trend(headroom, tuple(sum(e.seconds for e in p) for p in points))


def _headroom(entries: Sequence[Entry]) -> float | None:
    widths = [entry.widths for entry in entries if entry.widths is not None]
    return max(0.0, 1.0 - max(widths)) if widths else None


def _entry(record: Record) -> Entry:
    worst = [outcome.worst for outcome in record.expectations if outcome.worst is not None]
    widths = [_widths(each) for each in worst if not math.isnan(each.widths)]
    return Entry(record.status, max(widths, default=None), record.seconds, record.size)


def _widths(worst: Worst) -> float:
    # A band of two neighbouring floats has no middle to lie in.
    nearest = worst.exact or (worst.ulp <= 0.5 and worst.widths <= 1)
    return 0.0 if nearest else worst.widths


def _like(before: Entry | None, now: Entry) -> bool:
    """Whether an entry can be compared with this run's."""
    return before is not None and (before.size == now.size or not before.size * now.size)


def _alike(run: Run) -> dict[str, Any]:
    """What two runs have in common that are compared."""
    return {"renderer": run.driver.get("renderer", ""), "replaced": sorted(run.replaced)}


def _past(run: Run, folder: Path) -> Iterator[PastRun]:
    own = folder.resolve()
    alike = _alike(run)
    for path in own.parent.glob(f"*/{FILE_NAME}"):
        if path.parent.is_symlink() or path.parent == own:
            continue
        try:
            found = json.loads(read_regular(path))
            same = {name: found[name] for name in alike} == alike
            past = PastRun(path.parent.name, str(found["started"]), dict(_entries(found["cases"])))
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            continue
        if same and (past.started, past.name) < (run.started, own.name):
            yield past


def _entries(cases: Any) -> Iterator[tuple[tuple[str, str], Entry]]:
    for case_id, variants in cases.items():
        for variant, (status, widths, seconds, size) in variants.items():
            if status not in STATUSES:
                raise ValueError(f"{status!r} is no status")
            distance = None if widths is None else float(widths)
            yield (case_id, variant), Entry(status, distance, float(seconds), int(size))
