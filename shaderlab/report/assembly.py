"""A case's SPIR-V as text, folded away, and kept once however many cases share it."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

from markupsafe import Markup

from shaderlab.model.records import Verdict
from shaderlab.report.grouping import CaseGroup
from shaderlab.report.inline import Pictures, in_base64
from shaderlab.report.text import Anchors

# Anchors of the cases' texts so far, and the texts, by file.
Packed = dict[str, tuple[str, Markup]]


@dataclass(frozen=True)
class Assembly:
    """One program's modules: the files it is made of, what was compiled for each target, and where
    the text of all is. `packed` is that text, deflated and in base64, "" where the file has gone;
    `repeated` says that an earlier case has it, under the same anchor."""

    files: tuple[str, ...]
    verdicts: tuple[Verdict, ...]
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
            verdicts = tuple(verdict for verdict in program.verdicts if verdict.assembly)
            for file in {verdict.assembly: None for verdict in verdicts}:
                if file in by_file:
                    continue
                repeated = file in packed
                if not repeated:
                    data = pictures.text(file)
                    text = in_base64(zlib.compress(data, 6)) if data else Markup()
                    packed[file] = (anchors.short() if text else "", text)
                by_file[file] = Assembly(
                    files=program.files,
                    verdicts=tuple(verdict for verdict in verdicts if verdict.assembly == file),
                    file=file,
                    anchor=packed[file][0],
                    packed=packed[file][1],
                    repeated=repeated,
                )
    return tuple(by_file.values())
