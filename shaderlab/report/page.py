"""A run laid out as a page, in reading order: each case with everything that belongs to it.

What the templates show are records with their anchors, pictures, charts and links.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any, TypeVar

from markupsafe import Markup

from shaderlab.errors import ShaderlabError
from shaderlab.files import read_regular
from shaderlab.model.records import (
    CodeCoverage,
    Curve,
    Disagreement,
    ErratumNote,
    Outcome,
    Plot,
    Record,
    Row,
    Run,
    Status,
)
from shaderlab.report.charts import Chart, WorstPanel, draw_curve, draw_plot, lay_out_worst
from shaderlab.report.grouping import (
    PASSABLE,
    CaseGroup,
    Totals,
    count_totals,
    group_cases,
)
from shaderlab.report.pictures import SMALL, Picture, Pictures
from shaderlab.report.sources import (
    Assembly,
    Compiled,
    Listing,
    anchor_of,
    list_assemblies,
    list_programs,
    list_sources,
    render_formula,
    render_lesson,
)
from shaderlab.report.text import Anchors, format_conditions

# The folder of the cases' own pages.
CASES = "cases"
_LONGEST_NAME = 120
# A case shows so many figures in one table; if there are more, each variant shows its own.
_FIGURES_TOGETHER = 200
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
    """How many mutants the checks of one or several cases killed, and those that survived."""

    killed: int
    survivors: tuple[Survivor, ...]
    cases: int = 1

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

    Raises:
        ShaderlabError: the file is damaged, or something else.
    """
    path = folder / MUTATION_NAME
    try:
        cases = json.loads(read_regular(path))["cases"]
        return {case["id"]: _mutants(case) for case in cases}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError) as error:
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
    return Mutants(int(case["killed"]), survivors)


@dataclass(frozen=True)
class Figure:
    """A picture with its name and texts; None where a script draws it from the check's numbers."""

    name: str
    alt: str
    caption: str
    picture: Picture | None


@dataclass(frozen=True)
class Check:
    """An outcome; `places` are its sources as (what it is, file:line, anchor or None), `numbers`
    the file of the values behind its pictures."""

    outcome: Outcome
    anchor: str
    pictures: tuple[Figure, ...]
    worst: WorstPanel | None
    places: tuple[tuple[str, str, str | None], ...]
    numbers: Path | None = None


@dataclass(frozen=True)
class Step:
    """One pass; `draws` are (files, how many draws use them), `reads` say "pass.output", `fed`
    whether one of those is of the pass just before."""

    name: str
    size: tuple[int, int] | None
    draws: tuple[tuple[tuple[str, ...], int], ...]
    reads: tuple[str, ...]
    pictures: tuple[Figure, ...]
    fed: bool = False


@dataclass(frozen=True)
class DriverDifference:
    """An output on which two drivers differ, and a picture of where, if there is one."""

    found: Disagreement
    picture: Picture | None


@dataclass(frozen=True)
class VariantView:
    """A record; its figures are shown here only where the case's own table is too long."""

    record: Record
    anchor: str
    checks: tuple[Check, ...]
    own_figures: bool


@dataclass(frozen=True)
class CaseView:
    """A case with all its variants.

    `page` is its own page in the run's folder, `source` the number in the anchor of its first
    source text. `curves` and `points` are what its charts and plots show.
    """

    group: CaseGroup
    anchor: str
    page: str
    source: int
    status: Status
    thumbnail: Picture | None
    pictures: tuple[Figure, ...]
    curves: tuple[tuple[str, Curve], ...]
    points: tuple[tuple[str, Plot], ...]
    figures: tuple[tuple[str, Row], ...]
    errata: tuple[ErratumNote, ...]
    compiled: tuple[Compiled, ...]
    glsl: tuple[Listing, ...]
    python: tuple[Listing, ...]
    assemblies: tuple[Assembly, ...]
    variants: tuple[VariantView, ...]
    passes: tuple[Step, ...] = ()
    mutants: Mutants | None = None
    coverage: CodeCoverage | None = None
    differences: tuple[DriverDifference, ...] = ()

    # What takes time to make is made for the page that shows it.
    @cached_property
    def lesson(self) -> Markup:
        return render_lesson(self.group.first.lesson)

    @cached_property
    def formula(self) -> Markup:
        return render_formula(self.group.first.formula)

    @property
    def charts(self) -> list[tuple[str, Chart]]:
        """Its plots and curves, each with the names of its variants, "" if all share it."""
        plots = [(names, draw_plot(plot)) for names, plot in self.points]
        return plots + [(names, draw_curve(curve)) for names, curve in self.curves]

    @property
    def several(self) -> bool:
        return len(self.variants) > 1

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
    mutants: Mutants | None = None

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
        return [
            (case, variant)
            for case in self.cases
            for variant in case.variants
            if variant.record.status not in PASSABLE
        ]


def build_page(run: Run, pictures: Pictures, mutants: Mapping[str, Mutants] | None = None) -> Page:
    """Lay out a run as a page, with the results of mutation testing if there are any."""
    anchors = Anchors()
    groups = group_cases(run.records)
    known = mutants or {}
    covered = {found.id: found for found in run.code_coverage}
    cases = tuple(
        replace(
            _case(group, anchors, pictures),
            mutants=known.get(group.id),
            coverage=covered.get(group.id),
            differences=_driver_differences(run, group.id, pictures),
        )
        for group in groups
    )
    chapters = []
    for (number, name), members in groupby(cases, lambda case: case.group.chapter):
        anchor = anchors.new(f"chapter-{number}")
        chapters.append(ChapterView(number, name, anchor, tuple(members)))
    noticed = combine_mutants(known[group.id] for group in groups if group.id in known)
    return Page(run, count_totals(run, groups), tuple(chapters), cases, noticed)


def _driver_differences(run: Run, case_id: str, pictures: Pictures) -> tuple[DriverDifference, ...]:
    """The outputs on which drivers differ, what leaves a band first."""
    own = [d for d in run.disagreements if d.id == case_id and d.verdict != "equal"]
    return tuple(
        DriverDifference(found, pictures.find(found.image) if found.image else None)
        for found in sorted(own, key=lambda found: found.verdict != "outside")
    )


def _case(group: CaseGroup, anchors: Anchors, pictures: Pictures) -> CaseView:
    anchor = anchors.new("case", group.id)
    source = anchors.next_short
    several = len(group.records) > 1
    glsl, python = list_sources(group, anchors)
    figures = tuple(
        (record.variant if several and outcome.rows_per_variant else "", row)
        for record in group.records
        for outcome in record.expectations
        for row in _rows(outcome)
    )
    together = len(figures) <= _FIGURES_TOGETHER
    variants = []
    for record in group.records:
        own = anchors.new(anchor, record.variant)
        checks = tuple(
            _check(record, outcome, anchors.new(own, outcome.name), (*glsl, *python), pictures)
            for outcome in record.expectations
        )
        variants.append(VariantView(record, own, checks, own_figures=not together))
    return CaseView(
        group=group,
        anchor=anchor,
        page=f"{CASES}/{_file_name(anchor)}",
        source=source,
        status=group.status,
        thumbnail=_thumbnail(group, pictures),
        pictures=tuple(
            _figure(pictures, record, name, file, len(group.records))
            for record in group.records
            for name, file in record.images.items()
        ),
        curves=tuple(_with_variants(group, lambda record: record.curves)),
        points=tuple(_with_variants(group, lambda record: record.plots)),
        figures=figures if together else (),
        errata=tuple(dict.fromkeys(note for record in group.records for note in record.errata)),
        compiled=list_programs(group),
        glsl=glsl,
        python=python,
        assemblies=list_assemblies(group, pictures),
        variants=tuple(variants),
        passes=tuple(_steps(group, pictures)),
    )


def _file_name(anchor: str) -> str:
    """A case's page, named by its anchor, which file systems may find too long."""
    name = anchor.removeprefix("case-")
    if len(name) > _LONGEST_NAME:
        name = f"{name[:_LONGEST_NAME]}-{hashlib.blake2s(name.encode(), digest_size=4).hexdigest()}"
    return f"{name}.html"


def _rows(outcome: Outcome) -> tuple[Row, ...]:
    """An outcome's rows, labelled so that they can stand beside those of others."""
    if not outcome.rows_heading:
        return outcome.rows
    return tuple(replace(r, label=f"{outcome.rows_heading}: {r.label}") for r in outcome.rows)


Drawn = TypeVar("Drawn", Curve, Plot)


def _with_variants(
    group: CaseGroup, drawings_of: Callable[[Record], Iterable[Drawn]]
) -> Iterator[tuple[str, Drawn]]:
    """Each curve or plot with the names of its variants, "" if all of them share it."""
    users: dict[Drawn, dict[str, None]] = {}
    for record in group.records:
        for drawing in drawings_of(record):
            users.setdefault(drawing, {})[record.variant] = None
    for drawing, names in users.items():
        yield "" if len(names) == len(group.records) else ", ".join(names), drawing


def _check(
    record: Record, outcome: Outcome, anchor: str, texts: Sequence[Listing], pictures: Pictures
) -> Check:
    numbers = pictures.find_numbers(outcome.values) if outcome.images else None
    names = dict.fromkeys((*outcome.images, *(_FROM_NUMBERS if numbers else ())))
    shown = tuple(
        Figure(
            name=name,
            alt=f"{name}: {outcome.name} of {record.title}, {record.variant}",
            caption=outcome.captions.get(name, ""),
            picture=pictures.find(outcome.images[name]) if name in outcome.images else None,
        )
        for name in names
    )
    places = tuple(
        (
            _KINDS[source.language],
            f"{source.file}:{source.line}",
            anchor_of(texts, source.file, source.line),
        )
        for source in outcome.sources
    )
    panel = None if outcome.worst is None else lay_out_worst(outcome.worst)
    return Check(outcome, anchor, shown, panel, places, numbers)


def _figure(pictures: Pictures, record: Record, name: str, file: str, many: int) -> Figure:
    several = many > 1
    caption = record.captions.get(name, "")
    title = record.variant if several else ("" if name == "picture" else name)
    if several and name != "picture":
        title = f"{record.variant}: {name}"
    alt = f"{record.title}, {record.variant}: {name}" if several else f"{record.title}: {name}"
    # Side by side each is shown small.
    picture = pictures.find(file, SMALL) if many > 2 else pictures.find(file)
    return Figure(title, alt, caption, picture)


def _steps(group: CaseGroup, pictures: Pictures) -> Iterator[Step]:
    """The passes of the first variant that has any: they differ in values, not in their chain."""
    record = next((r for r in group.records if r.passes), group.first)
    before = ""
    for step in record.passes:
        shown = tuple(
            Figure(
                name=attachment.name,
                alt=f"{record.title}: {attachment.name} of pass {step.name}",
                caption=attachment.format,
                picture=pictures.find(attachment.image, SMALL),
            )
            for attachment in step.attachments
        )
        fed = any(name.rpartition(".")[0] == before for name in step.reads)
        draws = tuple(Counter(step.draws).items())
        yield Step(step.name, step.size, draws, step.reads, shown, fed)
        before = step.name


def _thumbnail(group: CaseGroup, pictures: Pictures) -> Picture | None:
    """A small picture of the variant that gives the case its status, or of any that has one."""
    status = group.status  # that of all records
    records = sorted(group.records, key=lambda record: record.status != status)
    files = [_main_image(record.images) for record in records]
    files += [_main_image(outcome.images) for record in records for outcome in record.expectations]
    for file in files:
        if file:
            small = pictures.find(file, SMALL)
            if not small.missing:
                return small
    return None


def _main_image(images: Mapping[str, str]) -> str:
    for name in ("picture", "measured"):
        if name in images:
            return images[name]
    return next(iter(images.values()), "")
