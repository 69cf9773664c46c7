"""What cases are found by: the words of their lessons, checks, figures and sources."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence

from shaderlab.model.records import Record
from shaderlab.report.text import clean


def words(records: Iterable[Record]) -> str:
    """The words of a case's records, each once and in small letters."""
    found: dict[str, None] = {}
    seen: set[str] = set()
    for record in records:
        for text in _texts(record):
            if text not in seen:
                seen.add(text)
                found.update(dict.fromkeys(clean(text).lower().split()))
    return " ".join(found)


def script(cases: Iterable[tuple[str, Sequence[Record]]]) -> Iterator[str]:
    """A script with the words of each case, given by its anchor and its records, in pieces."""
    yield "globalThis.shaderlabWords = {\n"
    for anchor, records in cases:
        yield f"{json.dumps(anchor)}: {json.dumps(words(records), ensure_ascii=False)},\n"
    yield "};\n"


def _texts(record: Record) -> Iterator[str]:
    """All texts that a case's page shows of a record, but for numbers and compilers' tables."""
    yield from (record.id, record.title, record.section, record.chapter, record.file)
    yield from (record.variant, record.lesson, record.message, *record.notices, *record.inputs)
    for outcome in record.expectations:
        yield from (outcome.name, outcome.kind, outcome.message)
        yield from (text for row in outcome.rows for text in (row.label, row.note))
        yield from (source.text for source in outcome.sources)
    for program in record.programs:
        yield from (text for source in program.sources for text in (source.file, source.text))
        yield from (said.message for verdict in program.verdicts for said in verdict.diagnostics)
    yield from (text for note in record.errata for text in (note.says, note.truth, note.proof))
    yield from (curve.title for curve in record.curves)
    yield from (plot.title for plot in record.plots)
    yield from (step.name for step in record.passes)
