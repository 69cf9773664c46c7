"""Changes from one run to another: verdicts, largest distances, times, pictures, drivers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from shaderlab.model.records import Record, Run, Status
from shaderlab.report.grouping import STATUSES
from shaderlab.report.inline import Picture, Pictures

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
        """Whether its status differs, or it is in one run only."""
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
        """Whether driver or versions differ."""
        return any(earlier != later for what, earlier, later in self.facts if what != "duration")


def compare(
    run: Run, folder: Path, before: Run, before_folder: Path, links: Mapping[Key, str]
) -> Comparison:
    """Everything that is not the same in `run` as in the earlier one.

    Args:
        run, folder: the later run and where its pictures lie.
        before, before_folder: the earlier one.
        links: where the report shows each (case, variant) of the later run.
    """
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
        picture = None if record is None else folder.picture(record.images.get("picture", ""))
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
