"""Lays a run out as a page: each case with everything that belongs to it, in reading order."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from typing import TypeVar

from shaderlab.model.records import Curve, Outcome, Plot, Record, Row, Run
from shaderlab.report.assembly import Packed, assemblies
from shaderlab.report.grouping import CaseGroup, group_cases, total
from shaderlab.report.inline import SMALL, Picture, Pictures
from shaderlab.report.listing import Listing, anchor_of
from shaderlab.report.mutants import Mutants, combined
from shaderlab.report.page import (
    Apart,
    CaseView,
    ChapterView,
    Check,
    Page,
    Plate,
    Step,
    VariantView,
)
from shaderlab.report.sources import Shown, compiled, listings
from shaderlab.report.text import Anchors
from shaderlab.report.worst import worst_panel

# The folder of the cases' own pages.
CASES = "cases"
_LONGEST_NAME = 120
# A case shows so many figures in one table; if there are more, each variant shows its own.
_FIGURES_TOGETHER = 200
# What a script draws of a check's numbers where there is no file.
_FROM_NUMBERS = ("measured", "reference", "distance")
_KINDS = {"glsl": "shader", "python": "formula"}


def build(run: Run, pictures: Pictures, mutants: Mapping[str, Mutants] | None = None) -> Page:
    """Lay out a run as a page, with the results of mutation testing if there are any."""
    anchors = Anchors()
    groups = group_cases(run.records)
    shown: Shown = {}
    packed: Packed = {}
    known = mutants or {}
    covered = {found.id: found for found in run.code_coverage}
    cases = tuple(
        replace(
            _case(group, anchors, pictures, shown, packed),
            mutants=known.get(group.id),
            coverage=covered.get(group.id),
            apart=_apart(run, group.id, pictures),
        )
        for group in groups
    )
    if run.plots and cases:  # a sweep has one case
        over_all = (*(("", plot) for plot in run.plots), *cases[0].points)
        cases = (replace(cases[0], points=over_all), *cases[1:])
    chapters = []
    for (number, name), members in groupby(cases, lambda case: case.group.chapter):
        anchor = anchors.new(f"chapter-{number}")
        chapters.append(ChapterView(number, name, anchor, tuple(members)))
    noticed = combined(known[group.id] for group in groups if group.id in known)
    return Page(run, total(run, groups), tuple(chapters), cases, noticed)


def _apart(run: Run, case_id: str, pictures: Pictures) -> tuple[Apart, ...]:
    """Where drivers differ, what leaves a band first."""
    own = [d for d in run.disagreements if d.id == case_id and d.verdict != "equal"]
    return tuple(
        Apart(found, pictures.picture(found.image) if found.image else None)
        for found in sorted(own, key=lambda found: found.verdict != "outside")
    )


def _case(
    group: CaseGroup, anchors: Anchors, pictures: Pictures, shown: Shown, packed: Packed
) -> CaseView:
    anchor = anchors.new("case", group.id)
    source = anchors.next_short
    several = len(group.records) > 1
    glsl, python = listings(group, anchors, shown)
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
        plates=tuple(
            _plate(pictures, record, name, file, len(group.records))
            for record in group.records
            for name, file in record.images.items()
        ),
        curves=tuple(_with_variants(group, lambda record: record.curves)),
        points=tuple(_with_variants(group, lambda record: record.plots)),
        figures=figures if together else (),
        errata=tuple(dict.fromkeys(note for record in group.records for note in record.errata)),
        compiled=compiled(group),
        glsl=glsl,
        python=python,
        assemblies=assemblies(group, anchors, pictures, packed),
        variants=tuple(variants),
        passes=tuple(_steps(group, pictures)),
    )


def _file_name(anchor: str) -> str:
    """A case's page, named by its anchor: file systems have no room for very long ones."""
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
    numbers = pictures.numbers(outcome.values) if outcome.images else None
    names = dict.fromkeys((*outcome.images, *(_FROM_NUMBERS if numbers else ())))
    plates = tuple(
        Plate(
            name=name,
            alt=f"{name}: {outcome.name} of {record.title}, {record.variant}",
            caption=outcome.captions.get(name, ""),
            picture=pictures.picture(outcome.images[name]) if name in outcome.images else None,
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
    panel = None if outcome.worst is None else worst_panel(outcome.worst)
    return Check(outcome, anchor, plates, panel, places, numbers)


def _plate(pictures: Pictures, record: Record, name: str, file: str, many: int) -> Plate:
    several = many > 1
    caption = record.captions.get(name, "")
    title = record.variant if several else ("" if name == "picture" else name)
    if several and name != "picture":
        title = f"{record.variant}: {name}"
    alt = f"{record.title}, {record.variant}: {name}" if several else f"{record.title}: {name}"
    # Side by side each is shown small.
    picture = pictures.picture(file, SMALL) if many > 2 else pictures.picture(file)
    return Plate(title, alt, caption, picture)


def _steps(group: CaseGroup, pictures: Pictures) -> Iterator[Step]:
    """The passes of the first variant that has any: they differ in values, not in their chain."""
    record = next((r for r in group.records if r.passes), group.first)
    before = ""
    for step in record.passes:
        plates = tuple(
            Plate(
                name=attachment.name,
                alt=f"{record.title}: {attachment.name} of pass {step.name}",
                caption=attachment.format,
                picture=pictures.picture(attachment.image, SMALL),
            )
            for attachment in step.attachments
        )
        fed = any(name.rpartition(".")[0] == before for name in step.reads)
        draws = tuple(Counter(step.draws).items())
        yield Step(step.name, step.size, draws, step.reads, plates, fed)
        before = step.name


def _thumbnail(group: CaseGroup, pictures: Pictures) -> Picture | None:
    """A small picture of the variant that gives the case its status, or of any that has one."""
    status = group.status  # that of all records
    records = sorted(group.records, key=lambda record: record.status != status)
    files = [_main_image(record.images) for record in records]
    files += [_main_image(outcome.images) for record in records for outcome in record.expectations]
    for file in files:
        if file:
            small = pictures.picture(file, SMALL)
            if not small.missing:
                return small
    return None


def _main_image(images: Mapping[str, str]) -> str:
    for name in ("picture", "measured"):
        if name in images:
            return images[name]
    return next(iter(images.values()), "")
