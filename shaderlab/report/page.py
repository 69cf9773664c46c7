"""The page as the templates want it: a run's records with anchors, pictures, charts and links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..records import Diagnostic, ErratumNote, Outcome, Record, Row, Run, SourceText, Status, Verdict
from . import markup
from .chart import Chart, chart
from .grouping import CHAPTERS, CaseGroup, Totals, group_cases, total, worst
from .inline import Picture, Pictures
from .listing import Listing, listing
from .text import Anchors
from .worst import WorstPanel, worst_panel

if TYPE_CHECKING:
    from markupsafe import Markup

THUMBNAIL = 240
# Up to so many figures are shown in one table for the whole case, more in each variant's.
_FIGURES_TOGETHER = 60
_KINDS = {"glsl": "shader", "python": "formula"}


@dataclass(frozen=True)
class Plate:
    """A picture with its name, alternative text and caption."""

    name: str
    alt: str
    caption: str
    picture: Picture


@dataclass(frozen=True)
class Check:
    """An outcome; `places` are its sources as (what it is, file:line, anchor or None)."""

    outcome: Outcome
    anchor: str
    plates: tuple[Plate, ...]
    worst: WorstPanel | None
    places: tuple[tuple[str, str, str | None], ...]


@dataclass(frozen=True)
class VariantView:
    """A record; its figures are shown here only where the case's own table is too long."""

    record: Record
    anchor: str
    checks: tuple[Check, ...]
    own_figures: bool


@dataclass(frozen=True)
class Compiled:
    """Programs with the same files and verdicts. `variants` is empty where all share them."""

    files: tuple[str, ...]
    verdicts: tuple[Verdict, ...]
    variants: tuple[str, ...]


@dataclass(frozen=True)
class CaseView:
    """A case with all its variants."""

    group: CaseGroup
    anchor: str
    status: Status
    lesson: Markup
    formula: Markup
    thumbnail: Picture | None
    plates: tuple[Plate, ...]
    charts: tuple[tuple[str, Chart], ...]
    figures: tuple[tuple[str, Row], ...]
    errata: tuple[ErratumNote, ...]
    compiled: tuple[Compiled, ...]
    glsl: tuple[Listing, ...]
    python: tuple[Listing, ...]
    variants: tuple[VariantView, ...]

    @property
    def several(self) -> bool:
        """Whether there is more than one variant to tell apart."""
        return len(self.variants) > 1

    @property
    def search(self) -> str:
        """What the filter box looks at."""
        record = self.group.first
        names = " ".join(variant.record.variant for variant in self.variants)
        return f"{record.id} {record.title} {record.section} {record.file} {names}".lower()

    def anchor_of(self, file: str, line: int | None) -> str | None:
        """The anchor of a source line, if one of the listings shows it."""
        if line is None:
            return None
        found = (text.anchor_of(file, line) for text in (*self.glsl, *self.python))
        return next((anchor for anchor in found if anchor), None)


@dataclass(frozen=True)
class ChapterView:
    """A chapter with its cases; there is at least one."""

    number: int
    name: str
    anchor: str
    cases: tuple[CaseView, ...]

    @property
    def status(self) -> Status:
        """The worst of its cases' statuses."""
        return worst(case.status for case in self.cases)


@dataclass(frozen=True)
class Page:
    """Everything that is on the page."""

    run: Run
    totals: Totals
    chapters: tuple[ChapterView, ...]
    cases: tuple[CaseView, ...] = field(default=())


def build(run: Run, pictures: Pictures) -> Page:
    """Lay a run out as a page."""
    anchors = Anchors()
    groups = group_cases(run.records)
    cases = tuple(_case(group, anchors, pictures) for group in groups)
    chapters = []
    for number, name in CHAPTERS.items():
        members = tuple(case for case in cases if case.group.chapter == number)
        if members:
            chapters.append(ChapterView(number, name, anchors.new(f"chapter-{number}"), members))
    return Page(run, total(run, groups), tuple(chapters), cases)


def _case(group: CaseGroup, anchors: Anchors, pictures: Pictures) -> CaseView:
    first = group.first
    anchor = anchors.new("case", group.id)
    several = len(group.records) > 1
    glsl, python = _listings(group, anchor)
    figures = tuple(
        (record.variant if several else "", row)
        for record in group.records
        for outcome in record.expectations
        for row in outcome.rows
    )
    together = len(figures) <= _FIGURES_TOGETHER
    return CaseView(
        group=group,
        anchor=anchor,
        status=group.status,
        lesson=markup.lesson(first.lesson),
        formula=markup.formula(first.formula),
        thumbnail=_thumbnail(group, pictures),
        plates=tuple(
            _plate(pictures, record, name, file, several)
            for record in group.records
            for name, file in record.images.items()
        ),
        charts=tuple(
            (record.variant if several else "", chart(curve))
            for record in group.records
            for curve in record.curves
        ),
        figures=figures if together else (),
        errata=tuple(dict.fromkeys(note for record in group.records for note in record.errata)),
        compiled=_compiled(group),
        glsl=glsl,
        python=python,
        variants=tuple(
            _variant(record, anchors.new(anchor, record.variant), (*glsl, *python), pictures,
                     anchors, not together)
            for record in group.records
        ),
    )


def _variant(
    record: Record,
    anchor: str,
    listings: Sequence[Listing],
    pictures: Pictures,
    anchors: Anchors,
    own_figures: bool,
) -> VariantView:
    checks = []
    for outcome in record.expectations:
        plates = tuple(
            Plate(
                name=name,
                alt=f"{name}: {outcome.name} of {record.title}, {record.variant}",
                caption=outcome.captions.get(name, ""),
                picture=pictures.full(file),
            )
            for name, file in outcome.images.items()
        )
        places = tuple(
            (_KINDS[source.language], f"{source.file}:{source.line}", _anchor_of(listings, source))
            for source in outcome.sources
        )
        panel = None if outcome.worst is None else worst_panel(outcome.worst)
        checks.append(Check(outcome, anchors.new(anchor, outcome.name), plates, panel, places))
    return VariantView(record, anchor, tuple(checks), own_figures)


def _listings(group: CaseGroup, anchor: str) -> tuple[tuple[Listing, ...], tuple[Listing, ...]]:
    """Each source text once, GLSL and Python apart, with the messages of all compilers."""
    users: dict[SourceText, list[str]] = {}
    messages: list[Diagnostic] = []
    for record in group.records:
        sources: list[SourceText] = []
        for program in record.programs:
            sources.extend(program.sources)
            messages.extend(m for verdict in program.verdicts for m in verdict.diagnostics)
        for outcome in record.expectations:
            sources.extend(outcome.sources)
        for source in dict.fromkeys(sources):
            users.setdefault(source, []).append(record.variant)
    texts = [
        listing(source, f"{anchor}-source-{number}", messages, _if_some(names, group))
        for number, (source, names) in enumerate(_without_parts(users).items(), start=1)
    ]
    return (
        tuple(text for text in texts if text.language == "glsl"),
        tuple(text for text in texts if text.language == "python"),
    )


def _without_parts(users: dict[SourceText, list[str]]) -> dict[SourceText, list[str]]:
    """Leave out a text that another one of the same file holds at the same lines."""
    kept = {}
    for source, names in users.items():
        whole = any(
            other is not source
            and other.file == source.file
            and other.line <= source.line
            and len(other.text) > len(source.text)
            and _lines_from(other, source.line, source.text) == source.text.rstrip("\n")
            for other in users
        )
        if not whole:
            kept[source] = names
    return kept


def _lines_from(source: SourceText, line: int, text: str) -> str:
    start = line - source.line
    count = len(text.rstrip("\n").split("\n"))
    return "\n".join(source.text.split("\n")[start : start + count])


def _compiled(group: CaseGroup) -> tuple[Compiled, ...]:
    users: dict[tuple[tuple[str, ...], tuple[Verdict, ...]], list[str]] = {}
    for record in group.records:
        for program in record.programs:
            names = users.setdefault((program.files, program.verdicts), [])
            if record.variant not in names:
                names.append(record.variant)
    return tuple(
        Compiled(files, verdicts, _if_some(names, group))
        for (files, verdicts), names in users.items()
    )


def _if_some(variants: Sequence[str], group: CaseGroup) -> tuple[str, ...]:
    return () if len(variants) == len(group.records) else tuple(variants)


def _plate(pictures: Pictures, record: Record, name: str, file: str, several: bool) -> Plate:
    caption = record.captions.get(name, "")
    title = record.variant if several else ("" if name == "picture" else name)
    if several and name != "picture":
        title = f"{record.variant}: {name}"
    alt = f"{record.title}, {record.variant}: {name}" if several else f"{record.title}: {name}"
    return Plate(title, alt, caption, pictures.full(file))


def _thumbnail(group: CaseGroup, pictures: Pictures) -> Picture | None:
    """A small picture of the variant that gives the case its status, or of any that has one."""
    records = sorted(group.records, key=lambda record: record.status != group.status)
    files = [_main_image(record.images) for record in records]
    files += [
        _main_image(outcome.images) for record in records for outcome in record.expectations
    ]
    for file in files:
        if file:
            small = pictures.small(file, THUMBNAIL)
            if not small.missing:
                return small
    return None


def _main_image(images: Mapping[str, str]) -> str:
    for name in ("picture", "measured"):
        if name in images:
            return images[name]
    return next(iter(images.values()), "")


def _anchor_of(listings: Sequence[Listing], source: SourceText) -> str | None:
    found = (text.anchor_of(source.file, source.line) for text in listings)
    return next((anchor for anchor in found if anchor), None)
