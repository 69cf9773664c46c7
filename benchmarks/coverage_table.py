"""Writes docs/internals/coverage-gaps.md: `python -m benchmarks.coverage_table [RUN.json]`.

The page's table is made from coverage-gaps.toml, which says why a gap is there. RUN.json, which
`shaderlab run --all --coverage --json RUN.json` wrote, gives the totals above it. Gaps that nothing
there is about are printed, and explanations of what is no gap any more; the exit status is then 1.
"""

from __future__ import annotations

import json
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.mutation_table import between

REPOSITORY = Path(__file__).resolve().parents[1]
FOLDER = REPOSITORY / "docs" / "internals"
PAGE = FOLDER / "coverage-gaps.md"
GAPS = FOLDER / "coverage-gaps.toml"

Entry = Mapping[str, Any]
Gap = tuple[str, str, str, str]
"""A case's id, a shader below `shaders`, an expression and what it never does."""


def main(files: Sequence[str]) -> int:
    """Write the page and return the exit status."""
    entries = load_entries()
    text, complaints = page(PAGE.read_text(encoding="utf-8"), entries), list[str]()
    for file in files:
        run = json.loads(Path(file).read_text(encoding="utf-8"))["coverage"]
        text = between(text, "totals", totals(run))
        complaints += unexplained(run, entries)
    PAGE.write_text(text, encoding="utf-8")
    for line in complaints:
        print(line)
    return 1 if complaints else 0


def load_entries() -> list[Entry]:
    """The explanations."""
    entries: list[Entry] = tomllib.loads(GAPS.read_text(encoding="utf-8"))["gap"]
    return entries


def page(text: str, entries: Sequence[Entry]) -> str:
    """The page with its table made anew."""
    return between(text, "gaps", table(entries))


def totals(run: Sequence[Mapping[str, Any]]) -> str:
    """How much of the catalogue was exercised, and what was not measured."""
    measured = [case for case in run if not case["message"]]
    items = sum(case["items"] for case in measured)
    missed = sum(len(case["gaps"]) for case in measured)
    lines = [f"{items - missed} of {items} items in {len(measured)} cases; {missed} gaps."]
    others = ", ".join(case["id"] for case in run if case["message"])
    return "\n".join(lines + [f"Not measured: {others}."] * bool(others))


def unexplained(run: Sequence[Mapping[str, Any]], entries: Sequence[Entry]) -> list[str]:
    """A line for each gap without an explanation, and for each explanation without its gap."""
    found = {gap for case in run for gap in _gaps_of(case)}
    known = {gap for entry in entries for gap in _explained(entry)}
    measured = {case["id"] for case in run if not case["message"]}
    return [
        *(f"not in {GAPS.name}: {': '.join(gap)}" for gap in sorted(found - known)),
        *(f"no gap: {': '.join(gap)}" for gap in sorted(known - found) if gap[0] in measured),
    ]


def table(entries: Sequence[Entry]) -> str:
    """A row for each explanation, with the expressions' present lines."""
    lines = ["| gap | cases | why |", "|---|---|---|"]
    for entry in entries:
        place = f"`{entry['file']}:{line_number(entry['file'], entry['text'])}`"
        gap = f"{place}: `{entry['text']}` {entry['what']}"
        lines.append(f"| {gap} | {', '.join(entry['cases'])} | {entry['why']} |")
    return "\n".join(lines)


def line_number(file: str, text: str) -> int:
    """Where a shader, a path below `shaders`, has this expression first, but for its uniforms.

    Raises:
        LookupError: there is no such shader or expression; the explanation is out of date.
    """
    path = REPOSITORY / "shaders" / file
    if path.is_file():
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if text in line and not line.startswith("uniform "):
                return number
    raise LookupError(f"{GAPS.name}: no shader {file} has {text!r}")


def _gaps_of(case: Mapping[str, Any]) -> Iterator[Gap]:
    for gap in case["gaps"]:
        file = gap["file"].rpartition("shaders/")[2]
        yield case["id"], file, gap["text"], gap["what"]


def _explained(entry: Entry) -> Iterator[Gap]:
    for case in entry["cases"]:
        yield case, entry["file"], entry["text"], entry["what"]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
