"""A run laid out as a page, in reading order: each case with everything that belongs to it.

What the templates show are records with their anchors, pictures, charts and links.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any
from urllib.parse import quote

from shaderlab.errors import ShaderlabError
from shaderlab.files import read_regular
from shaderlab.model.records import (
    Curve,
    ErratumNote,
    Outcome,
    PassRecord,
    Record,
    Row,
    Run,
    Status,
)
from shaderlab.report.charts import Chart, draw_curve, draw_plot
from shaderlab.report.grouping import PASSABLE, CaseGroup, Totals, count_totals, group_cases
from shaderlab.report.pictures import Picture, Pictures
from shaderlab.report.sources import Listing, anchor_of, list_sources
from shaderlab.report.text import Anchors, format_conditions

# The folder of the cases' own pages.
CASES = "cases"
_LONGEST_NAME = 120
# What a script draws of a check's numbers where there is no file.
_FROM_NUMBERS = ("measured", "reference", "distance")
_KINDS = {"glsl": "shader", "python": "formula"}

MUTATION_NAME = "mutation.json"


@dataclass(frozen=True)
class Survivor:
    """A mistake that no expectation noticed, in a program or (none) in a case's own state."""

    file: str
    line: int
    operator: str
    before: str
    after: str
    program: str = ""

    @property
    def place(self) -> str:
        """`file:line`; the file alone of a mistake in the case's own data."""
        return f"{self.file}:{self.line}" if self.line else self.file


@dataclass(frozen=True)
class Mutants:
    """How many mutants the checks of one or several cases killed, and those that survived; `shown`
    are those that a live picture can show, the survivors first, in JSON."""

    killed: int
    survivors: tuple[Survivor, ...]
    cases: int = 1
    shown: str = "[]"

    @property
    def judged(self) -> int:
        """How many mutants changed an output."""
        return self.killed + len(self.survivors)

    @property
    def score(self) -> float:
        """The share that was noticed, 0…1; 1 of none."""
        return self.killed / self.judged if self.judged else 1.0


def load_mutants(folder: Path) -> dict[str, Mutants]:
    """Return the results in `folder`/mutation.json by case; none where there is no such file.
    Raises ShaderlabError: the file is damaged, or something else."""
    path = folder / MUTATION_NAME
    try:
        cases = json.loads(read_regular(path))["cases"]
        return {case["id"]: _mutants(case) for case in cases}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise ShaderlabError(
            f"these are no results of shaderlab mutate ({type(error).__name__}: {error})",
            file=path,
            remedy="delete the file, or run shaderlab mutate --report again",
        ) from error


def combine_mutants(results: Iterable[Mutants]) -> Mutants | None:
    """Return all results as one; None if there are none."""
    judged = [each for each in results if each.judged]
    if not judged:
        return None
    survivors = tuple(survivor for each in judged for survivor in each.survivors)
    return Mutants(sum(each.killed for each in judged), survivors, len(judged))


def merge_mutants(old: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any]:
    """Merge the contents of two files; `new` results replace those of the same case."""
    cases = {case["id"]: case for each in (old, new) for case in each["cases"]}
    return {"cases": list(cases.values())}


def _mutants(case: Mapping[str, Any]) -> Mutants:
    fields = ("file", "line", "operator", "before", "after")
    survivors = tuple(
        Survivor(**{n: each[n] for n in fields}, program=" + ".join(each.get("program", ())))
        for each in case["survived"]
    )
    names = ("operator", "before", "after", "program", "edit")
    shown = [
        {**{n: each[n] for n in names}, "noticed": each.get("note") if key == "examples" else ""}
        for key in ("survived", "examples")
        for each in case.get(key, ())
        if "edit" in each
    ]
    return Mutants(int(case["killed"]), survivors, shown=json.dumps(shown))


@dataclass(frozen=True)
class Figure:
    """A picture with its name and texts; None where a script draws it from the check's numbers."""

    name: str
    alt: str
    caption: str
    picture: Picture | None


@dataclass(frozen=True)
class VariantView:
    """A record, and its outcomes with their anchors."""

    record: Record
    anchor: str
    checks: tuple[tuple[Outcome, str], ...]

    @property
    def failed(self) -> list[tuple[Outcome, str]]:
        return [check for check in self.checks if check[0].status != "pass"]


@dataclass(frozen=True)
class CaseView:
    """A case with all its variants; `page` is its own page in the run's folder.

    What takes time to make is a property, which is asked for by the page that shows it.
    """

    group: CaseGroup
    anchor: str
    page: str
    store: Pictures
    glsl: tuple[Listing, ...]
    python: tuple[Listing, ...]
    variants: tuple[VariantView, ...]
    mutants: Mutants | None

    @property
    def status(self) -> Status:
        return self.group.status

    @property
    def lead(self) -> tuple[VariantView, tuple[Outcome, str] | None] | None:
        """The first variant that did not pass, with its first failing check, if there is one."""
        for variant in self.variants:
            if variant.record.status not in PASSABLE:
                return variant, next(iter(variant.failed), None)
        return None

    @property
    def several(self) -> bool:
        return len(self.variants) > 1

    @property
    def charts(self) -> list[tuple[str, Chart]]:
        """Its plots and curves, each with the names of its variants, "" if all share it."""
        users: dict[Any, dict[str, None]] = {}
        for record in self.group.records:
            for drawing in (*record.plots, *record.curves):
                users.setdefault(drawing, {})[record.variant] = None
        return [
            (
                "" if len(names) == len(self.variants) else ", ".join(names),
                draw_curve(each) if isinstance(each, Curve) else draw_plot(each),
            )
            for each, names in sorted(users.items(), key=lambda user: isinstance(user[0], Curve))
        ]

    @property
    def errata(self) -> list[ErratumNote]:
        return list(dict.fromkeys(note for r in self.group.records for note in r.errata))

    @property
    def figures(self) -> list[tuple[str, Row]]:
        """The rows of all outcomes, with the variant that each is of, "" where all have it."""
        return [
            (record.variant if self.several and outcome.rows_per_variant else "", row)
            for record in self.group.records
            for outcome in record.expectations
            for row in _label_rows(outcome)
        ]

    @property
    def passes(self) -> list[tuple[PassRecord, list[tuple[tuple[str, ...], int]]]]:
        """The passes of the first variant that has any (they differ in values, not in their chain),
        each with the files of its draws and how many draws use them."""
        record = next((r for r in self.group.records if r.passes), self.group.first)
        return [(step, list(Counter(step.draws).items())) for step in record.passes]

    @property
    def thumbnail(self) -> Picture | None:
        """A picture of the variant that gives the case its status, or of any that has one."""
        status = self.status
        records = sorted(self.group.records, key=lambda record: record.status != status)
        images = [record.images for record in records]
        images += [outcome.images for record in records for outcome in record.expectations]
        for names in images:
            file = next(filter(None, map(names.get, ("small", "picture", "measured", *names))), "")
            if file and not (picture := self.store.find(file)).missing:
                return picture
        return None

    @property
    def pictures(self) -> list[Figure]:
        """The pictures of all variants."""
        return [
            self._figure(record, name, self.store.find(file))
            for record in self.group.records
            for name, file in record.images.items()
            if name != "small"
        ]

    @property
    def live(self) -> str:
        """Name, recording and picture of each variant that can be played, in JSON; or ""."""
        found = [
            (r.variant, quote(r.live), self.store.find(r.images.get("picture", "")).link)
            for r in self.group.records
            if r.live
        ]
        return json.dumps(found) if found else ""

    def _figure(self, record: Record, name: str, picture: Picture) -> Figure:
        names = [record.variant] if self.several else []
        alt = f"{', '.join([record.title, *names])}: {name}"
        names += [] if name == "picture" else [name]
        return Figure(": ".join(names), alt, record.captions.get(name, ""), picture)

    def check_pictures(self, record: Record, outcome: Outcome) -> list[Figure]:
        """A check's pictures, and those that a script draws."""
        drawn = _FROM_NUMBERS if self.find_numbers(outcome) else ()
        return [
            Figure(
                name=name,
                alt=f"{name}: {outcome.name} of {record.title}, {record.variant}",
                caption=outcome.captions.get(name, ""),
                picture=self.store.find(outcome.images[name]) if name in outcome.images else None,
            )
            for name in dict.fromkeys((*outcome.images, *drawn))
        ]

    def find_numbers(self, outcome: Outcome) -> Path | None:
        """The file of the values behind a check's pictures."""
        return self.store.find_numbers(outcome.values) if outcome.images else None

    def places(self, outcome: Outcome) -> list[tuple[str, str, str | None]]:
        """A check's sources as (what it is, file:line, link or None)."""
        return [
            (_KINDS[s.language], f"{s.file}:{s.line}", self.link_to(s.file, s.line))
            for s in outcome.sources
        ]

    def link_to(self, file: str, line: int | None) -> str | None:
        """A link to a source line, if one of the listings shows it."""
        anchor = None if line is None else anchor_of((*self.glsl, *self.python), file, line)
        return anchor and f"#{anchor}"


@dataclass(frozen=True)
class ChapterView:
    number: int
    name: str
    anchor: str
    cases: tuple[CaseView, ...]


@dataclass(frozen=True)
class Page:
    """Everything that is on the page; `cases` are those of all chapters."""

    run: Run
    totals: Totals
    chapters: tuple[ChapterView, ...]
    cases: tuple[CaseView, ...]
    mutants: Mutants | None

    @cached_property
    def by_id(self) -> dict[str, CaseView]:
        return {case.group.id: case for case in self.cases}

    @cached_property
    def notes(self) -> list[str]:
        """What to know before anything else: files in shaders' places, another size."""
        return list(format_conditions(self.run))

    def links(self, single: bool) -> dict[tuple[str, str], str]:
        """Where each (case, variant) is shown, as a link from the front page.

        `single` says that all of them are on that page.
        """
        return {
            (variant.record.id, variant.record.variant): f"{'' if single else case.page}"
            f"#{variant.anchor}"
            for case in self.cases
            for variant in case.variants
        }

    @property
    def failed(self) -> list[tuple[CaseView, VariantView]]:
        every = ((case, variant) for case in self.cases for variant in case.variants)
        return [each for each in every if each[1].record.status not in PASSABLE]


def build_page(run: Run, pictures: Pictures, mutants: Mapping[str, Mutants] | None = None) -> Page:
    """Lay out a run as a page, with the results of mutation testing if there are any."""
    anchors = Anchors()
    groups = group_cases(run.records)
    known = mutants or {}
    cases = []
    for group in groups:
        anchor = anchors.new("case", group.id)
        glsl, python = list_sources(group, anchors)
        case = CaseView(
            group=group,
            anchor=anchor,
            page=f"{CASES}/{_file_name(anchor)}",
            store=pictures,
            glsl=glsl,
            python=python,
            variants=tuple(_variant(record, anchor, anchors) for record in group.records),
            mutants=known.get(group.id),
        )
        cases.append(case)
    chapters = []
    for (number, name), members in groupby(cases, lambda case: case.group.chapter):
        anchor = anchors.new(f"chapter-{number}")
        chapters.append(ChapterView(number, name, anchor, tuple(members)))
    noticed = combine_mutants(known[group.id] for group in groups if group.id in known)
    return Page(run, count_totals(run, groups), tuple(chapters), tuple(cases), noticed)


def _variant(record: Record, case_anchor: str, anchors: Anchors) -> VariantView:
    anchor = anchors.new(case_anchor, record.variant)
    outcomes = record.expectations
    checks = tuple((outcome, anchors.new(anchor, outcome.name)) for outcome in outcomes)
    return VariantView(record, anchor, checks)


def _file_name(anchor: str) -> str:
    """A case's page, named by its anchor, which file systems may find too long."""
    name = anchor.removeprefix("case-")
    if len(name) > _LONGEST_NAME:
        name = f"{name[:_LONGEST_NAME]}-{hashlib.blake2s(name.encode(), digest_size=4).hexdigest()}"
    return f"{name}.html"


def _label_rows(outcome: Outcome) -> tuple[Row, ...]:
    """An outcome's rows, labelled so that they can stand beside those of others."""
    if not outcome.rows_heading:
        return outcome.rows
    return tuple(replace(r, label=f"{outcome.rows_heading}: {r.label}") for r in outcome.rows)
