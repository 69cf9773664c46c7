"""A case's passes as a chain: what each draws with, what it reads, what it draws into."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from shaderlab.records import PassRecord
from shaderlab.report.grouping import CaseGroup
from shaderlab.report.inline import Pictures
from shaderlab.report.page import Plate


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


def steps(group: CaseGroup, pictures: Pictures) -> tuple[Step, ...]:
    """The passes of the first variant that has any: they differ in values, not in their chain."""
    record = next((r for r in group.records if r.passes), group.first)
    before = ("", *(each.name for each in record.passes))
    return tuple(
        _step(each, record.title, pictures, last)
        for each, last in zip(record.passes, before, strict=False)
    )


def _step(step: PassRecord, title: str, pictures: Pictures, before: str) -> Step:
    plates = tuple(
        Plate(
            name=attachment.name,
            alt=f"{title}: {attachment.name} of pass {step.name}",
            caption=attachment.format,
            picture=pictures.picture(attachment.image),
        )
        for attachment in step.attachments
    )
    fed = any(name.rpartition(".")[0] == before for name in step.reads)
    draws = tuple(Counter(step.draws).items())
    return Step(step.name, step.size, draws, step.reads, plates, fed)
