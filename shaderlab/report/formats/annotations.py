"""Annotations of GitHub's reviews: a workflow command for each finding, for standard output.

The format is that of GitHub's documentation, "Workflow commands for GitHub Actions".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from shaderlab.model.records import Run, Severity
from shaderlab.report.findings import Finding, collect_findings, find_repository, relative_path
from shaderlab.report.text import clean

_COMMANDS: Mapping[Severity, str] = {"error": "error", "warning": "warning", "info": "notice"}
_IN_MESSAGES = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})
_IN_PROPERTIES = _IN_MESSAGES | str.maketrans({":": "%3A", ",": "%2C"})


def render(run: Run) -> str:
    return render_findings(collect_findings(run), "run")


def render_findings(findings: Iterable[Finding], command: str) -> str:
    """A line for each finding, errors first: of many, GitHub shows the first ones only."""
    root = find_repository()
    order = list(_COMMANDS)
    lines = []
    for found in sorted(findings, key=lambda found: order.index(found.severity)):
        properties = {"title": f"shaderlab {command}: {found.rule}"}
        if found.file:
            shown = relative_path(root, found.file)
            place = {"file": found.file if shown is None else shown}
            place |= {"line": str(found.line)} if found.line else {}
            properties = place | properties
        words = ",".join(f"{n}={_escaped(v, _IN_PROPERTIES)}" for n, v in properties.items())
        message = _escaped(found.message, _IN_MESSAGES)
        lines.append(f"::{_COMMANDS[found.severity]} {words}::{message}\n")
    return "".join(lines)


def _escaped(text: str, replacements: Mapping[int, str]) -> str:
    return clean(text).translate(replacements)
