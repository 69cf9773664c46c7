"""Records put together as the report shows them: variants into cases, cases into chapters."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shaderlab.model.records import Record, Run, Status

# Worst first: a case has the first of these that one of its variants has.
STATUSES: tuple[Status, ...] = ("crash", "timeout", "error", "fail", "unsupported", "pass")

STATUS_WORDS: dict[Status, str] = {
    "crash": "crashed", "timeout": "timed out", "error": "error", "fail": "failed",
    "unsupported": "unsupported", "pass": "passed",
}  # fmt: skip

OWN = "Your own"
"""The heading of cases whose tree names no chapters."""


@dataclass(frozen=True)
class CaseGroup:
    """All records of one case, in the order they ran; there is at least one."""

    id: str
    records: tuple[Record, ...]

    @property
    def first(self) -> Record:
        """The record that speaks for the case: title, section, lesson and formula are its."""
        return self.records[0]

    @property
    def status(self) -> Status:
        """The worst of its records' statuses."""
        return min((record.status for record in self.records), key=STATUSES.index)

    @property
    def not_asked(self) -> int:
        """How many of its expectations are about OpenGL's own calls, where another API draws."""
        return sum(len(record.not_asked) for record in self.records)

    @property
    def chapter(self) -> tuple[int, str]:
        """Number and title of its stage of the course's path, or else of the chapter it lies in;
        (0, OWN) for a case of one's own."""
        if self.first.place.order:
            return self.first.place.stage, self.first.place.stage_title
        head = re.match(r"\s*(\d{1,4})", self.first.section)
        return (int(head.group(1)), self.first.chapter) if head and self.first.chapter else (0, OWN)


@dataclass(frozen=True)
class Totals:
    """What was done, in numbers. `cases` and `variants` count statuses, `missing` the variants that
    an interrupted run did not come to. `partly` counts cases that passed without their checks of
    OpenGL's own calls, `not_asked` those checks."""

    cases: Counter[Status]
    variants: Counter[Status]
    expectations: int
    judged: int
    outside: int
    programs: int
    targets: tuple[str, ...]
    refused: int
    missing: int
    partly: int
    not_asked: int

    @property
    def good(self) -> bool:
        """Whether something was checked, and everything ran and passed."""
        passed = self.expectations > 0 and self.cases["pass"] > 0
        return passed and not self.bad and not self.missing

    @property
    def bad(self) -> int:
        """Cases that failed in any way; unsupported ones did not."""
        return sum(self.cases[status] for status in STATUSES if status not in PASSABLE)


PASSABLE: tuple[Status, ...] = ("unsupported", "pass")


def group_cases(records: Sequence[Record]) -> list[CaseGroup]:
    """Return a group for each case id, ordered by the course's path, or by chapter and section.

    Equal sections stay in the order they ran; cases outside the course come last.
    """
    by_id: dict[str, list[Record]] = {}
    for record in records:
        by_id.setdefault(record.id, []).append(record)
    groups = [CaseGroup(id, tuple(members)) for id, members in by_id.items()]
    return sorted(groups, key=_place)


def _place(group: CaseGroup) -> tuple[bool, tuple[int, str], int, list[int]]:
    first_section = group.first.section.split(",")[0]
    numbers = [int(n) for n in re.findall(r"\d{1,9}", first_section)]
    return group.chapter == (0, OWN), group.chapter, group.first.place.order, numbers


def count_totals(run: Run, cases: Sequence[CaseGroup]) -> Totals:
    """Count everything once; a program that several variants share is one program."""
    outcomes = [outcome for record in run.records for outcome in record.expectations]
    every = [program for record in run.records for program in record.programs]
    programs = {(program.files, program.sources): program.verdicts for program in every}
    verdicts = [verdict for group in programs.values() for verdict in group]
    return Totals(
        cases=Counter(case.status for case in cases),
        variants=Counter(record.status for record in run.records),
        expectations=len(outcomes),
        judged=sum(outcome.judged for outcome in outcomes),
        outside=sum(outcome.outside for outcome in outcomes),
        programs=len(programs),
        targets=tuple(dict.fromkeys(verdict.target for verdict in verdicts)),
        refused=sum(not verdict.ok for verdict in verdicts),
        missing=run.missing,
        partly=sum(case.status == "pass" and case.not_asked > 0 for case in cases),
        not_asked=sum(case.not_asked for case in cases),
    )
