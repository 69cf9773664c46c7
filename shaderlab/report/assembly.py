"""A case's SPIR-V as text, folded away, and once in the page however many cases share it."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

from shaderlab.report.grouping import CaseGroup
from shaderlab.report.inline import Pictures, in_base64
from shaderlab.report.text import Anchors

# Anchors of the texts in the page so far, by file.
Packed = dict[str, str]


@dataclass(frozen=True)
class Assembly:
    """One program's modules for one target: the files it is made of, its size, and where its text
    is. `packed` is that text, deflated and in base64; it is "" where the file has gone, and where
    an earlier case has it under the same anchor."""

    target: str
    files: tuple[str, ...]
    bytes: int
    instructions: int
    file: str
    anchor: str
    packed: str


def assemblies(
    group: CaseGroup, anchors: Anchors, pictures: Pictures, packed: Packed
) -> tuple[Assembly, ...]:
    """Each program's modules once for all variants; a text in `packed` is not repeated."""
    by_file: dict[str, Assembly] = {}
    for record in group.records:
        for program in record.programs:
            for verdict in program.verdicts:
                if not verdict.assembly or verdict.assembly in by_file:
                    continue
                text = ""
                if verdict.assembly not in packed:
                    data = pictures.text(verdict.assembly)
                    text = in_base64(zlib.compress(data, 9)) if data else ""
                    packed[verdict.assembly] = anchors.short() if text else ""
                by_file[verdict.assembly] = Assembly(
                    target=verdict.target,
                    files=program.files,
                    bytes=verdict.spirv_bytes,
                    instructions=verdict.instructions,
                    file=verdict.assembly,
                    anchor=packed[verdict.assembly],
                    packed=text,
                )
    return tuple(by_file.values())
