"""What the templates show: records with their anchors, pictures, charts and links."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.model.records import (
    CodeCoverage,
    Curve,
    Declared,
    Disagreement,
    ErratumNote,
    Outcome,
    Plot,
    Record,
    Row,
    Run,
    Status,
    Verdict,
)
from shaderlab.report import markup
from shaderlab.report.assembly import Assembly
from shaderlab.report.chart import Chart, chart
from shaderlab.report.grouping import PASSABLE, CaseGroup, Totals, worst
from shaderlab.report.inline import Picture
from shaderlab.report.listing import Listing, anchor_of
from shaderlab.report.mutants import Mutants
from shaderlab.report.plain_text import conditions
from shaderlab.report.plot import PlotView, plot_view
from shaderlab.report.worst import WorstPanel

if TYPE_CHECKING:
    from markupsafe import Markup


@dataclass(frozen=True)
class Plate:
    """A picture with its name, alternative text and caption; None where a script draws it from
    the check's numbers."""

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
    plates: tuple[Plate, ...]
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
    plates: tuple[Plate, ...]
    fed: bool = False


@dataclass(frozen=True)
class Apart:
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
class Compiled:
    """Programs with the same files and verdicts. `variants` is empty where all share them."""

    files: tuple[str, ...]
    verdicts: tuple[Verdict, ...]
    variants: tuple[str, ...]
    declared: tuple[Declared, ...] = ()


@dataclass(frozen=True)
class CaseView:
    """A case with all its variants.

    `page` is its own page in the run's folder, `source` the number in the anchor of the first
    source or SPIR-V text that no earlier case has. `curves` and `points` are what its charts and
    plots show.
    """

    group: CaseGroup
    anchor: str
    page: str
    source: int
    status: Status
    thumbnail: Picture | None
    plates: tuple[Plate, ...]
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
    apart: tuple[Apart, ...] = ()

    # What takes time to make is made for the page that shows it.
    @cached_property
    def lesson(self) -> Markup:
        """Its lesson."""
        return markup.lesson(self.group.first.lesson)

    @cached_property
    def formula(self) -> Markup:
        """Its formula, "" if there is none."""
        return markup.formula(self.group.first.formula)

    @cached_property
    def charts(self) -> list[tuple[str, Chart]]:
        """Its curves, each with the names of its variants, "" if all share it."""
        return [(names, chart(curve)) for names, curve in self.curves]

    @cached_property
    def plots(self) -> list[tuple[str, PlotView]]:
        """Its plots, likewise."""
        return [(names, plot_view(plot)) for names, plot in self.points]

    @property
    def several(self) -> bool:
        """Whether there is more than one variant to tell apart."""
        return len(self.variants) > 1

    def link_to(self, file: str, line: int | None) -> str | None:
        """A link to a source line, if one of the listings shows it."""
        anchor = None if line is None else anchor_of((*self.glsl, *self.python), file, line)
        return anchor and f"#{anchor}"


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
    """Everything that is on the page; `cases` are those of all chapters."""

    run: Run
    totals: Totals
    chapters: tuple[ChapterView, ...]
    cases: tuple[CaseView, ...]
    mutants: Mutants | None = None

    @cached_property
    def notes(self) -> list[str]:
        """What to know before anything else: files in shaders' places, another size."""
        return list(conditions(self.run))

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

    def shown_apart(self) -> Iterator[Picture]:
        """Every picture of the overview, of cases and of their passes, as often as it is shown."""
        for case in self.cases:
            plates = (*case.plates, *(plate for step in case.passes for plate in step.plates))
            yield from filter(None, (case.thumbnail, *(plate.picture for plate in plates)))

    @property
    def failed(self) -> list[tuple[CaseView, VariantView]]:
        """Every variant that did not pass, with its case."""
        return [
            (case, variant)
            for case in self.cases
            for variant in case.variants
            if variant.record.status not in PASSABLE
        ]
