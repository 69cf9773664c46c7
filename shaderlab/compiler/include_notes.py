"""Says which file includes what lacks a declaration: often that one is to be mended."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from shaderlab.compiler.sources import Source
from shaderlab.records import Diagnostic, Verdict

_MISSING = ("undeclared identifier", "no matching overloaded function found")
_INCLUDE = re.compile(r"^[ \t]*#[ \t]*include[ \t]*[\"<]([^\">]+)[\">]", re.MULTILINE)


def with_include_notes(verdict: Verdict, sources: Sequence[Source]) -> Verdict:
    """The verdict with a note for each name that an included file lacks, at the `#include` that the
    declaration has to precede."""
    notes: dict[Diagnostic, None] = {}
    for diagnostic in verdict.diagnostics:
        if diagnostic.severity == "error" and diagnostic.message.endswith(_MISSING):
            for source in sources:
                notes |= dict.fromkeys(_notes(diagnostic, source))
    return replace(verdict, diagnostics=(*verdict.diagnostics, *notes)) if notes else verdict


def _notes(diagnostic: Diagnostic, source: Source) -> Iterator[Diagnostic]:
    parts = dict(source.parts)
    if diagnostic.file == source.path or diagnostic.file not in parts:
        return
    name = posixpath.basename(diagnostic.file)
    for file, text in parts.items():
        for found in _INCLUDE.finditer(text):
            if posixpath.basename(found[1]) == name:
                yield Diagnostic(
                    file=file,
                    line=text.count("\n", 0, found.start()) + 1,
                    severity="info",
                    message=f"{name}, included here, needs {diagnostic.token!r} declared before it",
                    token=diagnostic.token,
                )
