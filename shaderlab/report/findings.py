"""What is wrong, at its file and line: what code reviews and editors show beside the code."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.errors import Diagnostic, Severity, Verdict
from shaderlab.files import read_regular
from shaderlab.report.grouping import PASSABLE, STATUS_WORDS
from shaderlab.report.text import clean, format_label, format_outcome, plural

if TYPE_CHECKING:
    from shaderlab.model.records import Outcome, Record, Run

_PLACE = re.compile(r"(?P<file>[^\n]+?):(?P<line>\d+): ")
_CASE = re.compile(r"case\s*[:=]")
_MOST_BYTES = 1 << 24
WORKSPACE = "GITHUB_WORKSPACE"


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One thing that is wrong.

    Attributes:
        rule: what kind of thing, "compile-error" or "formula": the same from run to run.
        file, line: "" where it is in no file, 0 for the file as a whole.
        message: what is wrong; its first line says the most.
        subject: what it is about: with the rule, the file and the line's text it tells a finding
            from others, whatever the figures in its message are.
        related: other files and lines that have to do with it.
    """

    rule: str
    file: str
    line: int
    message: str
    severity: Severity = "error"
    subject: str = ""
    related: tuple[tuple[str, int], ...] = field(default=())


def collect_findings(run: Run) -> list[Finding]:
    """Return what is wrong in a run; what several variants of a case share is one finding.

    That is compilers' messages, expectations that do not hold, and variants without a verdict.
    """
    found: dict[tuple[object, ...], tuple[Finding, list[str]]] = {}
    for record in run.records:
        for finding in _record_findings(record):
            key = (finding.rule, finding.file, finding.line, finding.subject)
            found.setdefault(key, (finding, []))[1].append(record.variant)
    merged = [_name_variants(finding, variants) for finding, variants in found.values()]
    merged += _driver_findings(run)
    if run.missing:
        message = f"the run was interrupted: {plural(run.missing, 'variant')} not run"
        merged.append(Finding(rule="interrupted", file="", line=0, message=message))
    return merged


def collect_verdict_findings(verdicts: Iterable[Verdict], path: str) -> Iterator[Finding]:
    """Yield the errors and warnings of compile targets about one program, each once."""
    targets: dict[Diagnostic, list[str]] = {}
    for verdict in verdicts:
        for diagnostic in verdict.diagnostics:
            if diagnostic.severity != "info":
                targets.setdefault(diagnostic, []).append(verdict.target)
        if not verdict.ok and not any(d.severity == "error" for d in verdict.diagnostics):
            diagnostic = Diagnostic(file=path, line=None, severity="error", message="refused")
            targets.setdefault(diagnostic, []).append(verdict.target)
    for diagnostic, names in targets.items():
        yield Finding(
            rule=f"compile-{diagnostic.severity}",
            file=diagnostic.file,
            line=diagnostic.line or 0,
            severity=diagnostic.severity,
            message=f"{diagnostic.message} [{', '.join(dict.fromkeys(names))}]",
            subject=diagnostic.message,
        )


def find_repository() -> Path:
    """Return the folder that paths are relative to in a review.

    That is the checkout of a CI job, or else the repository that holds the working folder.
    """
    checkout = os.environ.get(WORKSPACE)
    here = Path.cwd()
    if checkout and here.is_relative_to(os.path.realpath(checkout)):
        return Path(os.path.realpath(checkout))
    return next((folder for folder in (here, *here.parents) if (folder / ".git").exists()), here)


def relative_path(root: Path, file: str) -> str | None:
    """Return a file's path below a folder, with "/"; None if it is elsewhere."""
    path = Path(os.path.abspath(file))
    for one in (path, Path(os.path.realpath(path))):
        if one.is_relative_to(root):
            return one.relative_to(root).as_posix()
    return None


class LineReader:
    """The text of files' lines, each file read once."""

    def __init__(self) -> None:
        self._files: dict[str, Sequence[str]] = {}

    def __call__(self, file: str, line: int) -> str:
        if file not in self._files:
            self._files[file] = _read_lines(file)
        lines = self._files[file]
        return lines[line - 1].strip() if 0 < line <= len(lines) else ""


def _record_findings(record: Record) -> Iterator[Finding]:
    name = format_label(record.id, record.variant)
    if record.status in PASSABLE:
        return
    refused = [f for p in record.programs for f in collect_verdict_findings(p.verdicts, p.files[0])]
    yield from refused
    shown = {finding.subject for finding in refused if finding.severity == "error"}
    wrong = [outcome for outcome in record.expectations if outcome.status != "pass"]
    for outcome in wrong:
        yield _outcome_finding(record, outcome)
    if not shown and not wrong:
        yield _ending_finding(record, name)


def _outcome_finding(record: Record, outcome: Outcome) -> Finding:
    file, line = record.file, outcome.line or _find_case_line(record.file)
    related = [(source.file, source.line) for source in outcome.sources]
    explained = outcome.explanation
    if explained is not None and explained.file and explained.line:
        related.insert(0, (file, line))
        file, line = explained.file, explained.line
    details = "\n".join(map(clean, format_outcome(outcome)))
    name = f"{outcome.name} of {format_label(record.id, record.variant)}"
    return Finding(
        rule=outcome.kind,
        file=file,
        line=line,
        message=f"{name}: {details or 'does not hold'}",
        subject=f"{record.id}: {outcome.name}",
        related=tuple(place for place in dict.fromkeys(related) if place != (file, line)),
    )


def _ending_finding(record: Record, name: str) -> Finding:
    """Of a record that no expectation accounts for: its message begins with the place, if known."""
    place = _PLACE.match(record.message)
    file, line, details = record.file, 0, record.message
    if place is not None and os.path.isfile(place["file"]):
        file, line, details = place["file"], int(place["line"]), record.message[place.end() :]
    return Finding(
        rule=record.status if record.status != "fail" else "case",
        file=file,
        line=line or _find_case_line(file),
        message=clean(f"{name}: {details or STATUS_WORDS[record.status]}"),
        subject=record.id,
    )


def _driver_findings(run: Run) -> Iterator[Finding]:
    """Scenes that pass on the first driver of several, and fail on another."""
    records: Mapping[tuple[str, str], Record] = {(r.id, r.variant): r for r in run.records}
    for result in run.drivers:
        record = records.get((result.id, result.variant))
        if record is not None and record.status in PASSABLE and result.status not in PASSABLE:
            yield Finding(
                rule="driver",
                file=record.file,
                line=_find_case_line(record.file),
                message=f"{format_label(result.id, result.variant)}: {STATUS_WORDS[result.status]} "
                f"on {result.driver}",
                subject=f"{result.id}[{result.variant}] on {result.driver}",
            )


def _name_variants(finding: Finding, variants: Sequence[str]) -> Finding:
    others = list(dict.fromkeys(variants))[1:]
    if not others:
        return finding
    shown = ", ".join(others[:5]) + (", …" if len(others) > 5 else "")
    return replace(finding, message=f"{finding.message}\nalso in {shown}")


def _find_case_line(file: str) -> int:
    """The line of a case file that has the case; 1 where that is not found."""
    lines = enumerate(_read_lines(file), 1)
    return next((number for number, line in lines if _CASE.match(line)), 1)


def _read_lines(file: str) -> Sequence[str]:
    with suppress(OSError):
        return read_regular(file, _MOST_BYTES).decode("utf-8", "replace").splitlines()
    return []
