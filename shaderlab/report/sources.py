"""A case's sources with the compilers' messages, each once for all variants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from shaderlab.model.records import Declared, Diagnostic, SourceText, Verdict
from shaderlab.report.grouping import CaseGroup
from shaderlab.report.listing import Listing, listing
from shaderlab.report.page import Compiled
from shaderlab.report.text import Anchors

# Listings in the page so far, by text and messages.
Shown = dict[tuple[SourceText, frozenset[Diagnostic]], Listing]


def listings(
    group: CaseGroup, anchors: Anchors, shown: Shown
) -> tuple[tuple[Listing, ...], tuple[Listing, ...]]:
    """Each source text once, GLSL and Python apart, with the messages of all compilers.

    A listing that an earlier case has `shown` is used again.
    """
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
    cited = {
        source.file
        for record in group.records
        for outcome in record.expectations
        for source in outcome.sources
    }
    # Without a text that another one of the same file holds at the same lines. Sources of checks
    # come first, others (pictures, included files) after them.
    whole = [source for source in users if not any(_holds(other, source) for other in users)]
    texts = []
    for source in sorted(whole, key=lambda source: source.file not in cited):
        own_messages = frozenset(m for m in messages if m.file == source.file)
        earlier = shown.get((source, own_messages))
        users_of_it = _if_some(users[source], group)
        if earlier is None:
            texts.append(listing(source, anchors.short(), messages, users_of_it))
            shown[source, own_messages] = texts[-1]
        else:
            texts.append(replace(earlier, variants=users_of_it, repeated=True))
    return (
        tuple(text for text in texts if text.source.language == "glsl"),
        tuple(text for text in texts if text.source.language == "python"),
    )


def _holds(whole: SourceText, part: SourceText) -> bool:
    if whole.file != part.file or whole.line > part.line or len(whole.text) <= len(part.text):
        return False
    # Without indentation, which a line quoted alone has often lost.
    lines = [line.strip() for line in part.text.rstrip().split("\n")]
    start = part.line - whole.line
    return lines == [line.strip() for line in whole.text.split("\n")[start : start + len(lines)]]


def compiled(group: CaseGroup) -> tuple[Compiled, ...]:
    """Each program with its verdicts; variants that agree share an entry."""
    users: dict[tuple[tuple[str, ...], tuple[Verdict, ...], tuple[Declared, ...]], list[str]] = {}
    for record in group.records:
        for program in record.programs:
            names = users.setdefault((program.files, program.verdicts, program.declared), [])
            if record.variant not in names:
                names.append(record.variant)
    return tuple(
        Compiled(files, verdicts, _if_some(names, group), declared)
        for (files, verdicts, declared), names in users.items()
    )


def _if_some(variants: Sequence[str], group: CaseGroup) -> tuple[str, ...]:
    return () if len(variants) == len(group.records) else tuple(variants)
