"""A case's SPIR-V as text, folded away, and kept once however many cases share it."""

from __future__ import annotations

import zlib

from markupsafe import Markup

from shaderlab.lazy_dataclass import dataclass
from shaderlab.report.grouping import CaseGroup
from shaderlab.report.inline import Pictures, in_base64
from shaderlab.report.text import Anchors

# Anchors of the cases' texts so far, and the texts, by file.
Packed = dict[str, tuple[str, Markup]]


@dataclass(frozen=True)
class Assembly:
    """One program's modules for one target: the files it is made of, its size, and where its text
    is. `packed` is that text, deflated and in base64, "" where the file has gone; `repeated` says
    that an earlier case has it, under the same anchor."""

    target: str
    files: tuple[str, ...]
    bytes: int
    instructions: int
    file: str
    anchor: str
    packed: Markup
    repeated: bool


def assemblies(
    group: CaseGroup, anchors: Anchors, pictures: Pictures, packed: Packed
) -> tuple[Assembly, ...]:
    """Each program's modules once for all variants; a text is packed once for all cases."""
    by_file: dict[str, Assembly] = {}
    for record in group.records:
        for program in record.programs:
            for verdict in program.verdicts:
                if not verdict.assembly or verdict.assembly in by_file:
                    continue
                repeated = verdict.assembly in packed
                if not repeated:
                    data = pictures.text(verdict.assembly)
                    text = in_base64(zlib.compress(data, 6)) if data else Markup()
                    packed[verdict.assembly] = (anchors.short() if text else "", text)
                by_file[verdict.assembly] = Assembly(
                    target=verdict.target,
                    files=program.files,
                    bytes=verdict.spirv_bytes,
                    instructions=verdict.instructions,
                    file=verdict.assembly,
                    anchor=packed[verdict.assembly][0],
                    packed=packed[verdict.assembly][1],
                    repeated=repeated,
                )
    return tuple(by_file.values())
