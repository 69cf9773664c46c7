"""SARIF 2.1.0, the format in which code scanning takes findings (OASIS, 2020)."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

from shaderlab.errors import Severity
from shaderlab.model.records import Run
from shaderlab.report.findings import (
    Finding,
    LineReader,
    collect_findings,
    find_repository,
    relative_path,
)
from shaderlab.report.text import clean

_LEVELS: Mapping[Severity, str] = {"error": "error", "warning": "warning", "info": "note"}
_SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/os/schemas/sarif-schema-2.1.0.json"
_ROOT = "SRCROOT"
_RULES = {
    "compile-error": "A shader does not compile",
    "compile-warning": "A compiler warns of a shader",
    "case": "A case did not pass",
    "crash": "A case took its process down",
    "driver": "A case fails on another driver",
    "error": "A case could not be judged",
    "hazard": "A shader does what GLSL does not define, on some inputs",
    "interrupted": "The run was interrupted",
    "not-audited": "A shader can't be audited",
    "timeout": "A case took too long",
}


def render(run: Run) -> str:
    return render_findings(collect_findings(run), "run", complete=not run.missing)


def render_findings(findings: Iterable[Finding], command: str, *, complete: bool = True) -> str:
    """Findings of a command, such as "run", as a SARIF log, as indented JSON. Logs of different
    commands do not replace each other; `complete` says whether everything was looked at.

    Paths are relative to the repository. A fingerprint is made of the rule, the path, what is
    judged and the line's text: it stays when lines above come and go, and figures change."""
    found = list(findings)
    rules = sorted({finding.rule for finding in found})
    root, lines, seen = find_repository(), LineReader(), Counter[str]()
    results = []
    for finding in found:
        words = [finding.rule, _uri(root, finding.file), finding.subject]
        print_of = "\0".join([*words, lines(finding.file, finding.line) if finding.file else ""])
        seen[print_of] += 1
        digest = hashlib.sha256(f"{print_of}\0{seen[print_of]}".encode("utf-8", "replace"))
        results.append(_result(finding, rules, root, digest.hexdigest()[:32]))
    run = {
        "tool": {"driver": {"name": "shaderlab", "rules": [_rule(name) for name in rules]}},
        "automationDetails": {"id": f"shaderlab/{command}/"},
        "originalUriBaseIds": {_ROOT: {"uri": f"{root.as_uri().rstrip('/')}/"}},
        "invocations": [{"executionSuccessful": complete}],
        "columnKind": "unicodeCodePoints",
        "results": results,
    }
    log = {"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}
    return json.dumps(log, indent=2, ensure_ascii=False) + "\n"


def _rule(name: str) -> dict[str, Any]:
    text = _RULES.get(name, f"What is expected does not hold: {name}")
    return {"id": name, "shortDescription": {"text": text}}


def _result(finding: Finding, rules: list[str], root: Path, digest: str) -> dict[str, Any]:
    result: dict[str, Any] = {
        "ruleId": finding.rule,
        "ruleIndex": rules.index(finding.rule),
        "level": _LEVELS[finding.severity],
        "message": {"text": clean(finding.message)},
        "partialFingerprints": {"shaderlab/v1": digest},
    }
    if finding.file:
        result["locations"] = [_location(root, finding.file, finding.line)]
    if finding.related:
        result["relatedLocations"] = [_location(root, *place) for place in finding.related]
    return result


def _location(root: Path, file: str, line: int) -> dict[str, Any]:
    inside = relative_path(root, file) is not None
    place: dict[str, Any] = {
        "artifactLocation": {"uri": _uri(root, file)} | ({"uriBaseId": _ROOT} if inside else {})
    }
    if line:
        place["region"] = {"startLine": line}
    return {"physicalLocation": place}


def _uri(root: Path, file: str) -> str:
    if not file:
        return ""
    relative = relative_path(root, file)
    if relative is not None:
        return quote(relative.encode("utf-8", "surrogateescape"))
    return Path(file).absolute().as_uri()
